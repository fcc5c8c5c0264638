//! Identity scores: how often each target and track are near each other, and the assignment of whole
//! tracks to targets with the largest total.
//!
//! Ristani, Solera, Zou, Cucchiara and Tomasi, "Performance measures and a data set for multi-target,
//! multi-camera tracking", ECCV workshops, 2016, doi:10.1007/978-3-319-48881-3_2.
//!
//! Only targets and tracks that ever meet are listed. Counts are whole numbers, so that the total is
//! exact; of several assignments with it the sparse solver's is returned.

use super::meetings::{Meetings, NONE};
use super::sequence::{Sequence, SimilarPairs};
use crate::assignment::sparse;
use crate::error::Result;
use crate::interrupt::Interrupt;

/// Targets and tracks that meet, and their assignment.
#[derive(Debug, PartialEq)]
pub struct Identities {
    /// The target of each meeting, rising.
    pub targets: Vec<i64>,
    /// The track of each meeting, in the order in which the target met them.
    pub tracks: Vec<i64>,
    /// In how many frames they are near each other.
    pub counts: Vec<i64>,
    /// The track assigned to each target, -1 for none.
    pub assigned: Vec<i64>,
    /// Sum of the counts of the assigned pairs.
    pub true_positives: i64,
}

/// Which pairs are near.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Near {
    /// Those of at least this similarity.
    Similarity(f64),
    /// Those of at most this distance.
    Distance(f64),
}

/// Counts the meetings and assigns tracks to targets.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn identities(
    sequence: &Sequence,
    pairs: &SimilarPairs,
    near: Near,
    interrupt: &Interrupt<'_>,
) -> Result<Identities> {
    let meetings = Meetings::new(sequence, pairs, |pair| match near {
        Near::Similarity(least) => pairs.similarities[pair] >= least,
        Near::Distance(largest) => pairs.distances[pair] <= largest,
    });
    let mut counts = vec![0i64; meetings.len()];
    for &meeting in meetings.of_pair.iter().filter(|&&meeting| meeting != NONE) {
        counts[meeting as usize] += 1;
    }
    // Above every count: each meeting is better than none.
    let alone = counts.iter().max().map_or(1, |most| most + 1) as f64;
    let costs = counts.iter().map(|&count| alone - count as f64).collect();
    let Meetings { starts, tracks, .. } = meetings;
    let targets = starts.windows(2).enumerate();
    let targets = targets.flat_map(|(i, range)| vec![i as i64; range[1] - range[0]]).collect();
    let listed = tracks.iter().map(|&track| i64::from(track)).collect();
    let table = sparse::Pairs { starts, columns: tracks, costs };
    let matching = sparse::solve(&table, sequence.tracks.names, alone, interrupt)?;
    let gain = matching.cost_of_row().iter().map(|cost| (alone - cost) as i64).sum();
    let track = |&column: &u32| if column == sparse::NONE { -1 } else { i64::from(column) };
    let assigned = matching.column_of_row().iter().map(track).collect();
    Ok(Identities { targets, tracks: listed, counts, assigned, true_positives: gain })
}
