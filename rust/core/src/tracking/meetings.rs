//! The targets and tracks that ever meet: a sparse table over identities, numbered target by target.

use super::sequence::{Sequence, SimilarPairs};

/// A pair of rows that is no meeting.
pub(super) const NONE: u32 = u32::MAX;

/// The meetings of a sequence.
#[derive(Debug)]
pub(super) struct Meetings {
    /// The meetings of target `i` are `starts[i] .. starts[i + 1]`.
    pub(super) starts: Vec<usize>,
    /// The track of each meeting.
    pub(super) tracks: Vec<u32>,
    /// The meeting of each pair of rows, [`NONE`] for a pair that does not count.
    pub(super) of_pair: Vec<u32>,
}

impl Meetings {
    /// The meetings in the pairs of rows that count.
    pub(super) fn new(
        sequence: &Sequence,
        pairs: &SimilarPairs,
        counts: impl Fn(usize) -> bool,
    ) -> Self {
        let truth = &sequence.truth;
        let mut starts = Vec::with_capacity(truth.names + 1);
        let mut tracks: Vec<u32> = Vec::new();
        let mut of_pair = vec![NONE; pairs.columns.len()];
        // One more than the last meeting of each track; those of earlier targets are lower.
        let mut last = vec![0usize; sequence.tracks.names];
        starts.push(0);
        for rows in rows_by_id(truth.ids, truth.names).chunks() {
            let first = tracks.len();
            for pair in rows.iter().flat_map(|&row| pairs.of(row as usize)) {
                if !counts(pair) {
                    continue;
                }
                let track = sequence.tracks.ids[pairs.columns[pair] as usize];
                let last = &mut last[track as usize];
                if *last <= first {
                    tracks.push(track as u32);
                    *last = tracks.len();
                }
                of_pair[pair] = (*last - 1) as u32;
            }
            starts.push(tracks.len());
        }
        Self { starts, tracks, of_pair }
    }

    /// How many meetings.
    pub(super) fn len(&self) -> usize {
        self.tracks.len()
    }
}

/// Rows in the order of their ids, and within an id in their own order.
struct RowsById {
    rows: Vec<u32>,
    ends: Vec<usize>,
}

impl RowsById {
    fn chunks(&self) -> impl Iterator<Item = &[u32]> {
        let begins = [0].into_iter().chain(self.ends.iter().copied());
        begins.zip(&self.ends).map(|(begin, &end)| &self.rows[begin..end])
    }
}

fn rows_by_id(ids: &[i64], names: usize) -> RowsById {
    let mut ends = vec![0; names + 1];
    ids.iter().for_each(|&id| ends[id as usize + 1] += 1);
    (0..names).for_each(|id| ends[id + 1] += ends[id]);
    let mut rows = vec![0; ids.len()];
    for (row, &id) in ids.iter().enumerate() {
        let place = &mut ends[id as usize];
        rows[*place] = row as u32;
        *place += 1;
    }
    ends.truncate(names);
    RowsById { rows, ends }
}
