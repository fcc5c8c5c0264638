//! HOTA: detection and association over many thresholds of similarity.
//!
//! Luiten et al., "HOTA: A higher order metric for evaluating multi-object tracking", Int. J. Computer
//! Vision 129, 2021, doi:10.1007/s11263-020-01375-2. With S the similarity of a frame's rows,
//!
//! ```text
//! shared(i, j)     sum over the frames of S / (row sum + column sum - S)
//! agreement(i, j)  shared / (rows of i + rows of j - shared)
//! ```
//!
//! each frame takes the pairs with the largest total of agreement x S; those of similarity alpha and
//! more count. With n the number of pairs of target i and track j at an alpha, association is the mean
//! over the pairs of `n / (rows of i + rows of j - n)`, `n / rows of i` and `n / rows of j`.
//!
//! Only targets and tracks that ever meet are listed. Sums are taken in NumPy's order where they
//! decide an assignment. Cost: O(k) for k similar pairs, see `frame_assignment`.

use super::frame_assignment::{FrameAssignment, Objective};
use super::meetings::{Meetings, NONE};
use super::pairwise_sum::sparse_pairwise_sum;
use super::sequence::{Sequence, SimilarPairs};
use crate::error::Result;
use crate::interrupt::Interrupt;
use std::ops::Range;

/// What HOTA is made of, at each threshold.
#[derive(Debug, Default, PartialEq)]
pub struct Hota {
    /// How many pairs count.
    pub true_positives: Vec<i64>,
    /// The sum of their similarities.
    pub similarity: Vec<f64>,
    /// Association accuracy.
    pub accuracy: Vec<f64>,
    /// Association recall.
    pub recall: Vec<f64>,
    /// Association precision.
    pub precision: Vec<f64>,
}

/// Computes the parts of HOTA at rising thresholds of similarity.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn hota(
    sequence: &Sequence,
    pairs: &SimilarPairs,
    thresholds: &[f64],
    interrupt: &Interrupt<'_>,
) -> Result<Hota> {
    let meetings = Meetings::new(sequence, pairs, |pair| pairs.similarities[pair] > 0.0);
    let rows = [sequence.truth.rows_of_ids(), sequence.tracks.rows_of_ids()];
    let agreement = agreement(sequence, pairs, &meetings, &rows, interrupt)?;
    let mut tally = Tally { matched: Vec::new(), sums: vec![0.0; thresholds.len() + 1] };
    let mut frame = FrameAssignment::default();
    for (rows, columns) in sequence.slices() {
        interrupt.check()?;
        if rows.is_empty() || columns.is_empty() {
            continue;
        }
        frame.clear();
        for row in rows {
            for place in pairs.of(row) {
                let meeting = meetings.of_pair[place];
                if meeting != NONE {
                    let score = agreement[meeting as usize] * pairs.similarities[place];
                    if score > 0.0 {
                        frame.push(pairs.columns[place] as usize - columns.start, score, place);
                    }
                }
            }
            frame.end_row();
        }
        frame.solve(columns.len(), Objective::Most(1.0), interrupt)?;
        for (_, place, _) in frame.pairs() {
            let similarity = pairs.similarities[place];
            tally.add(meetings.of_pair[place], similarity, thresholds);
        }
    }
    Ok(tally.scores(&meetings, &rows))
}

/// How well target and track of each meeting agree over the sequence.
fn agreement(
    sequence: &Sequence,
    pairs: &SimilarPairs,
    meetings: &Meetings,
    rows_of_ids: &[Vec<usize>; 2],
    interrupt: &Interrupt<'_>,
) -> Result<Vec<f64>> {
    let mut shared = vec![0.0; meetings.len()];
    let mut sums = Sums::default();
    for (rows, columns) in sequence.slices() {
        interrupt.check()?;
        sums.add_columns(pairs, &rows, &columns);
        for row in rows {
            let places = pairs.of(row);
            let row_sum = sums.row(pairs, places.clone(), &columns);
            for place in places {
                let similarity = pairs.similarities[place];
                let column = pairs.columns[place] as usize - columns.start;
                let union = sums.columns[column] + row_sum - similarity;
                if union > f64::EPSILON && similarity > 0.0 {
                    shared[meetings.of_pair[place] as usize] += similarity / union;
                }
            }
        }
    }
    for (target, range) in meetings.starts.windows(2).enumerate() {
        let range = range[0]..range[1];
        for (shared, &track) in shared[range.clone()].iter_mut().zip(&meetings.tracks[range]) {
            let rows = (rows_of_ids[0][target] + rows_of_ids[1][track as usize]) as f64;
            *shared /= rows - *shared;
        }
    }
    Ok(shared)
}

/// Sums over the rows and columns of the matrix of a frame.
#[derive(Default)]
struct Sums {
    columns: Vec<f64>,
    entries: Vec<(usize, f64)>,
}

impl Sums {
    /// Adds the rows of a matrix one after another, as NumPy does; but a single column as a row.
    fn add_columns(&mut self, pairs: &SimilarPairs, rows: &Range<usize>, columns: &Range<usize>) {
        self.columns.clear();
        self.columns.resize(columns.len(), 0.0);
        if columns.len() == 1 {
            self.entries.clear();
            for row in rows.clone() {
                let values =
                    pairs.of(row).map(|place| (row - rows.start, pairs.similarities[place]));
                self.entries.extend(values);
            }
            self.columns[0] = sparse_pairwise_sum(&self.entries, 0, rows.len());
            return;
        }
        for place in rows.clone().flat_map(|row| pairs.of(row)) {
            self.columns[pairs.columns[place] as usize - columns.start] +=
                pairs.similarities[place];
        }
    }

    #[inline]
    fn row(&mut self, pairs: &SimilarPairs, places: Range<usize>, columns: &Range<usize>) -> f64 {
        if places.len() < 3 {
            return pairs.similarities[places].iter().sum();
        }
        self.entries.clear();
        let entry =
            |place| (pairs.columns[place] as usize - columns.start, pairs.similarities[place]);
        self.entries.extend(places.map(entry));
        sparse_pairwise_sum(&self.entries, 0, columns.len())
    }
}

/// The pairs of all frames.
struct Tally {
    /// The meeting of each pair, and how many thresholds it reaches.
    matched: Vec<(u32, u32)>,
    /// The sum of the similarities of the pairs that reach so many thresholds.
    sums: Vec<f64>,
}

impl Tally {
    #[inline]
    fn add(&mut self, meeting: u32, similarity: f64, thresholds: &[f64]) {
        let level = thresholds.iter().filter(|&&least| similarity >= least).count();
        self.matched.push((meeting, level as u32));
        self.sums[level] += similarity;
    }

    fn scores(mut self, meetings: &Meetings, rows_of_ids: &[Vec<usize>; 2]) -> Hota {
        let thresholds = self.sums.len() - 1;
        let zeros = || vec![0.0; thresholds];
        let mut scores = Hota {
            true_positives: vec![0; thresholds],
            similarity: zeros(),
            accuracy: zeros(),
            recall: zeros(),
            precision: zeros(),
        };
        let by_level = sorted_by(&self.matched, thresholds + 1, |pair| pair.1);
        self.matched = sorted_by(&by_level, meetings.len(), |pair| pair.0);
        let mut target = 0;
        for group in self.matched.chunk_by(|a, b| a.0 == b.0) {
            let meeting = group[0].0 as usize;
            while meetings.starts[target + 1] <= meeting {
                target += 1;
            }
            let track = meetings.tracks[meeting] as usize;
            let rows = [rows_of_ids[0][target] as f64, rows_of_ids[1][track] as f64];
            scores.add_meeting(group, rows);
        }
        let mut above = 0.0;
        for (k, part) in scores.similarity.iter_mut().enumerate().rev() {
            above += self.sums[k + 1];
            *part = above;
        }
        for (k, &pairs) in scores.true_positives.iter().enumerate() {
            let pairs = pairs.max(1) as f64;
            scores.accuracy[k] /= pairs;
            scores.recall[k] /= pairs;
            scores.precision[k] /= pairs;
        }
        scores
    }
}

/// The pairs in the order of a key below `keys`; those of the same key keep their order.
fn sorted_by(pairs: &[(u32, u32)], keys: usize, key: fn(&(u32, u32)) -> u32) -> Vec<(u32, u32)> {
    let mut places = vec![0usize; keys + 1];
    pairs.iter().for_each(|pair| places[key(pair) as usize + 1] += 1);
    (0..keys).for_each(|k| places[k + 1] += places[k]);
    let mut sorted = vec![(0, 0); pairs.len()];
    for pair in pairs {
        let place = &mut places[key(pair) as usize];
        sorted[*place] = *pair;
        *place += 1;
    }
    sorted
}

impl Hota {
    /// Adds the pairs of a meeting, in the order of how many thresholds they reach.
    fn add_meeting(&mut self, group: &[(u32, u32)], [rows, columns]: [f64; 2]) {
        let mut below = 0;
        let mut shares = [0.0; 3];
        let mut counted = usize::MAX;
        for k in 0..group[group.len() - 1].1 as usize {
            while group[below].1 as usize <= k {
                below += 1;
            }
            if counted != below {
                counted = below;
                let n = (group.len() - below) as f64;
                shares = [n * (n / (rows + columns - n)), n * (n / rows), n * (n / columns)];
            }
            self.true_positives[k] += (group.len() - below) as i64;
            self.accuracy[k] += shares[0];
            self.recall[k] += shares[1];
            self.precision[k] += shares[2];
        }
    }
}
