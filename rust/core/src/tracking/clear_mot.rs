//! CLEAR MOT: matching truth and tracks frame by frame, and what happens to each target and track.
//!
//! Bernardin and Stiefelhagen, "Evaluating multiple object tracking performance: the CLEAR MOT
//! metrics", EURASIP J. Image and Video Processing, 2008, doi:10.1155/2008/246309; the rules in which
//! implementations differ are [`Rules`].
//!
//! ```text
//! switch         pair of a target whose last pair was with another track
//! ascend         switch to a track that had no pair before
//! transfer       newly assigned pair of a track whose last newly assigned pair was with another target
//! migrate        transfer to a target that had no pair before
//! fragmentation  pair of a target after an interruption
//! ```
//!
//! Cost: O(k) for the k similar pairs of a frame, see `frame_assignment`.

use super::frame_assignment::{FrameAssignment, Objective};
use super::sequence::{Sequence, SimilarPairs};
use crate::error::Result;
use crate::interrupt::Interrupt;
use std::ops::Range;

/// What a continued pair scores more; TrackEval's number.
const CONTINUED_SCORE: f64 = 1000.0;
const NONE: i64 = -1;

/// What happens with a pair, as bits of a number.
pub mod event {
    /// The pair continues an earlier one.
    pub const CONTINUED: i64 = 1;
    /// The target was with another track.
    pub const SWITCH: i64 = 2;
    /// The track was with another target.
    pub const TRANSFER: i64 = 4;
    /// A switch to a track that had no pair before.
    pub const ASCEND: i64 = 8;
    /// A transfer to a target that had no pair before.
    pub const MIGRATE: i64 = 16;
    /// The target was interrupted.
    pub const FRAGMENTATION: i64 = 32;
}

/// The rules in which implementations differ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// Only pairs of the last frame with both sides are continued, not the last pair of a target.
    pub forgets: bool,
    /// One assignment of the largest total similarity, in which continued pairs score more; otherwise
    /// continued pairs are fixed, then as many others as possible are added at least total distance.
    pub most_similar: bool,
    /// A target is not interrupted by frames in which it is absent.
    pub own_frames: bool,
    /// The least similarity or the largest distance of a pair.
    pub limit: f64,
}

/// The pairs of all frames and what happens with them.
#[derive(Debug, PartialEq)]
pub struct Matches {
    /// The track row of each truth row, -1 for none.
    pub partners: Vec<i64>,
    /// The similarity or distance of each truth row's pair, NaN for none.
    pub values: Vec<f64>,
    /// What happens with each truth row's pair: a sum of [`event`]s.
    pub events: Vec<i64>,
    /// How many pairs each target has.
    pub matched: Vec<i64>,
    /// Sum of the values.
    pub total: f64,
}

/// Matches truth and tracks.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn clear_mot(
    sequence: &Sequence,
    pairs: &SimilarPairs,
    rules: Rules,
    interrupt: &Interrupt<'_>,
) -> Result<Matches> {
    let mut history = History::new(sequence, rules);
    let mut frame = FrameAssignment::default();
    let mut fixed = Fixed::default();
    for (rows, columns) in sequence.slices() {
        interrupt.check()?;
        if rows.is_empty() || columns.is_empty() {
            history.count_rows(&rows);
            continue;
        }
        if rules.most_similar {
            history.most_similar(pairs, &rows, &columns, &mut frame, interrupt)?;
        } else {
            history.fix(pairs, &rows, &columns, &mut fixed);
            history.add(pairs, &rows, &columns, &fixed, &mut frame, interrupt)?;
        }
        history.count_rows(&rows);
        history.time += 1;
    }
    Ok(history.found)
}

/// What is remembered of a target.
#[derive(Debug, Clone, Copy)]
struct Target {
    /// The track of its last pair.
    track: i64,
    /// When that was, in frames with both sides.
    time: i64,
    /// The number of its row then, on the clock of fragmentations.
    clock: i64,
    /// How many rows it had before this frame.
    rows: i64,
}

/// What is remembered of a track.
#[derive(Debug, Clone, Copy)]
struct Track {
    /// The target of its last newly assigned pair.
    target: i64,
    had_a_pair: bool,
}

/// The pairs of a frame that are fixed before the assignment.
#[derive(Debug, Default)]
struct Fixed {
    rows: Vec<bool>,
    columns: Vec<bool>,
}

struct History<'a> {
    sequence: &'a Sequence<'a>,
    rules: Rules,
    targets: Vec<Target>,
    tracks: Vec<Track>,
    /// How many frames with both sides there were.
    time: i64,
    found: Matches,
}

impl<'a> History<'a> {
    fn new(sequence: &'a Sequence<'a>, rules: Rules) -> Self {
        let target = Target { track: NONE, time: NONE, clock: NONE, rows: 0 };
        let rows = sequence.truth.len();
        Self {
            sequence,
            rules,
            targets: vec![target; sequence.truth.names],
            tracks: vec![Track { target: NONE, had_a_pair: false }; sequence.tracks.names],
            time: 0,
            found: Matches {
                partners: vec![NONE; rows],
                values: vec![f64::NAN; rows],
                events: vec![0; rows],
                matched: vec![0; sequence.truth.names],
                total: 0.0,
            },
        }
    }

    fn count_rows(&mut self, rows: &Range<usize>) {
        for &id in &self.sequence.truth.ids[rows.clone()] {
            self.targets[id as usize].rows += 1;
        }
    }

    /// The track that a truth row would keep.
    #[inline(always)]
    fn wanted(&self, row: usize) -> i64 {
        let target = &self.targets[self.sequence.truth.ids[row] as usize];
        if self.rules.forgets && target.time != self.time - 1 { NONE } else { target.track }
    }

    /// One assignment in which continued pairs score more.
    fn most_similar(
        &mut self,
        pairs: &SimilarPairs,
        rows: &Range<usize>,
        columns: &Range<usize>,
        frame: &mut FrameAssignment,
        interrupt: &Interrupt<'_>,
    ) -> Result<()> {
        frame.clear();
        for row in rows.clone() {
            let wanted = self.wanted(row);
            for place in pairs.of(row) {
                let (column, similarity) =
                    (pairs.columns[place] as usize, pairs.similarities[place]);
                if similarity < self.rules.limit {
                    continue;
                }
                let continues = self.sequence.tracks.ids[column] == wanted;
                let score = if continues { CONTINUED_SCORE + similarity } else { similarity };
                if score > 0.0 {
                    frame.push(column - columns.start, score, place);
                }
            }
            frame.end_row();
        }
        frame.solve(columns.len(), Objective::Most(CONTINUED_SCORE + 1.0), interrupt)?;
        for (i, place, score) in frame.pairs() {
            if score > f64::EPSILON {
                let (row, column) = (rows.start + i, pairs.columns[place] as usize);
                let continued = self.sequence.tracks.ids[column] == self.wanted(row);
                self.record(row, column, pairs.similarities[place], continued);
            }
        }
        Ok(())
    }

    /// Keeps the pairs that are still within the distance; the first row that wants a track has it.
    fn fix(
        &mut self,
        pairs: &SimilarPairs,
        rows: &Range<usize>,
        columns: &Range<usize>,
        fixed: &mut Fixed,
    ) {
        fixed.rows.clear();
        fixed.rows.resize(rows.len(), false);
        fixed.columns.clear();
        fixed.columns.resize(columns.len(), false);
        for row in rows.clone() {
            let wanted = self.wanted(row);
            let is_kept = |&place: &usize| {
                self.sequence.tracks.ids[pairs.columns[place] as usize] == wanted
                    && pairs.distances[place] <= self.rules.limit
            };
            let Some(place) = pairs.of(row).find(is_kept) else { continue };
            let column = pairs.columns[place] as usize;
            let taken = &mut fixed.columns[column - columns.start];
            if !std::mem::replace(taken, true) {
                fixed.rows[row - rows.start] = true;
                self.record(row, column, pairs.distances[place], true);
            }
        }
    }

    /// Adds as many pairs as possible to the fixed ones, at the least total distance.
    fn add(
        &mut self,
        pairs: &SimilarPairs,
        rows: &Range<usize>,
        columns: &Range<usize>,
        fixed: &Fixed,
        frame: &mut FrameAssignment,
        interrupt: &Interrupt<'_>,
    ) -> Result<()> {
        frame.clear();
        for (row, is_fixed) in rows.clone().zip(&fixed.rows) {
            for place in pairs.of(row).filter(|_| !is_fixed) {
                let (column, distance) = (pairs.columns[place] as usize, pairs.distances[place]);
                if distance <= self.rules.limit && !fixed.columns[column - columns.start] {
                    frame.push(column - columns.start, distance, place);
                }
            }
            frame.end_row();
        }
        if frame.is_empty() {
            return Ok(());
        }
        // A cost that no assignment takes where it can have one more pair instead.
        let fewer = rows.len().min(columns.len());
        let large = (2 * fewer) as f64 * (frame.largest() + 1.0) + 1.0;
        frame.solve(columns.len(), Objective::Least(large), interrupt)?;
        for (i, place, distance) in frame.pairs() {
            self.record(rows.start + i, pairs.columns[place] as usize, distance, false);
        }
        Ok(())
    }

    /// Writes down a pair and what happens with it.
    fn record(&mut self, row: usize, column: usize, value: f64, continued: bool) {
        let (id, other) = (self.sequence.truth.ids[row], self.sequence.tracks.ids[column]);
        let (target, track) = (&mut self.targets[id as usize], &mut self.tracks[other as usize]);
        let clock = if self.rules.own_frames { target.rows } else { self.time };
        let (is_new_target, is_new_track) = (target.track == NONE, !track.had_a_pair);
        let mut events = 0;
        let mut add = |happens: bool, event: i64| events += if happens { event } else { 0 };
        let switch = !is_new_target && target.track != other;
        let transfer = !continued && track.target != NONE && track.target != id;
        add(continued, event::CONTINUED);
        add(switch, event::SWITCH);
        add(transfer, event::TRANSFER);
        add(switch && is_new_track, event::ASCEND);
        add(transfer && is_new_target, event::MIGRATE);
        add(!is_new_target && clock != target.clock + 1, event::FRAGMENTATION);
        (target.track, target.time, target.clock) = (other, self.time, clock);
        track.had_a_pair = true;
        if !continued {
            track.target = id;
        }
        self.found.partners[row] = column as i64;
        self.found.values[row] = value;
        self.found.events[row] = events;
        self.found.matched[id as usize] += 1;
        self.found.total += value;
    }
}
