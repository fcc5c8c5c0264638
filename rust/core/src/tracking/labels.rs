//! Purity, fragmentation and switches of pairs (true label, estimated label).
//!
//! For observations i = 1 .. n with true label t_i and estimated label e_i, in the order of time,
//!
//! ```text
//! purity        = 1/n sum over labels e of max over labels t of |{i : e_i = e, t_i = t}|
//! fragmentation = number of changes of e_i along the observations of one t, over all t
//! switches      = number of changes of t_i along the observations of one e, over all e
//! ```
//!
//! The names are those of `pytcl.performance_evaluation`. CLEAR MOT's identity switch is the second
//! (Bernardin and Stiefelhagen, 2008, doi:10.1155/2008/246309); the third is also called a transfer.
//! Purity of nothing is 1, and nothing has no change.
//!
//! Cost: one pass for each number where the labels span a range not much longer than the list, one
//! look into a hash table for each label otherwise. Times that do not rise cost a stable sort.

use crate::error::{Error, Result};
use std::borrow::Cow;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// The share of observations that carry the most frequent true label of their estimated label.
///
/// # Errors
/// [`Error::Length`] for label lists of different lengths.
pub fn track_purity(true_labels: &[i64], estimated_labels: &[i64]) -> Result<f64> {
    check_labels(true_labels, estimated_labels)?;
    if true_labels.is_empty() {
        return Ok(1.0);
    }
    let (true_ids, estimated_ids) = (Ids::new(true_labels), Ids::new(estimated_labels));
    let (tracks, starts) = grouped(&true_ids, &estimated_ids);
    let mut counts = vec![0u32; true_ids.count];
    let correct: u64 =
        starts.windows(2).map(|w| u64::from(most_frequent(&tracks[w[0]..w[1]], &mut counts))).sum();
    Ok(correct as f64 / true_labels.len() as f64)
}

/// How often the estimated label of a true label changes.
///
/// # Errors
/// [`Error::Length`] for lists of different lengths.
pub fn track_fragmentation(
    true_labels: &[i64],
    estimated_labels: &[i64],
    time_indices: Option<&[i64]>,
) -> Result<usize> {
    check_labels(true_labels, estimated_labels)?;
    let order = order_of(time_indices, true_labels)?;
    Ok(changes(&arranged(true_labels, &order), &arranged(estimated_labels, &order)))
}

/// How often the true label of an estimated label changes.
///
/// # Errors
/// [`Error::Length`] for lists of different lengths.
pub fn identity_switches(
    true_labels: &[i64],
    estimated_labels: &[i64],
    time_indices: Option<&[i64]>,
) -> Result<usize> {
    check_labels(true_labels, estimated_labels)?;
    let order = order_of(time_indices, true_labels)?;
    Ok(changes(&arranged(estimated_labels, &order), &arranged(true_labels, &order)))
}

fn check_labels(true_labels: &[i64], estimated_labels: &[i64]) -> Result<()> {
    let (expected, found) = (true_labels.len(), estimated_labels.len());
    if found == expected {
        return Ok(());
    }
    let (argument, other, unit) = ("estimated_labels", "true_labels", "labels");
    Err(Error::Length { argument, found, other, expected, unit })
}

/// The observations in the order of time, equal times in the order given; `None` where they
/// stand so already.
fn order_of(times: Option<&[i64]>, true_labels: &[i64]) -> Result<Option<Vec<usize>>> {
    let Some(times) = times else {
        return Ok(None);
    };
    let (expected, found) = (true_labels.len(), times.len());
    if found != expected {
        let (argument, other, unit) = ("time_indices", "true_labels", "times");
        return Err(Error::Length { argument, found, other, expected, unit });
    }
    if times.is_sorted() {
        return Ok(None);
    }
    let mut order: Vec<usize> = (0..found).collect();
    order.sort_by_key(|&i| times[i]);
    Ok(Some(order))
}

fn arranged<'a>(labels: &'a [i64], order: &Option<Vec<usize>>) -> Cow<'a, [i64]> {
    match order {
        None => Cow::Borrowed(labels),
        Some(order) => Cow::Owned(order.iter().map(|&i| labels[i]).collect()),
    }
}

/// How often the value of a key differs from the value that the same key had before.
fn changes(keys: &[i64], values: &[i64]) -> usize {
    let pairs = keys.iter().zip(values);
    match Range::of(keys) {
        Some(range) => {
            // (value, whether there is one)
            let mut last = vec![(0, false); range.count];
            pairs.fold(0, |changes, (&key, &value)| {
                let (before, seen) = std::mem::replace(&mut last[range.id(key)], (value, true));
                changes + usize::from(seen & (before != value))
            })
        }
        None => {
            let mut last = Table::default();
            pairs
                .filter(|&(&key, &value)| last.insert(key, value).is_some_and(|v| v != value))
                .count()
        }
    }
}

/// The true ids sorted by estimated id, and where each estimated id's begin: a counting sort.
fn grouped(true_ids: &Ids, estimated_ids: &Ids) -> (Vec<u32>, Vec<usize>) {
    let mut starts = vec![0; estimated_ids.count + 1];
    for &e in &estimated_ids.ids {
        starts[e as usize + 1] += 1;
    }
    for e in 0..estimated_ids.count {
        starts[e + 1] += starts[e];
    }
    let mut next = starts.clone();
    let mut tracks = vec![0; true_ids.ids.len()];
    for (&e, &t) in estimated_ids.ids.iter().zip(&true_ids.ids) {
        let place = &mut next[e as usize];
        tracks[*place] = t;
        *place += 1;
    }
    (tracks, starts)
}

/// The count of the most frequent id; `counts` is all zero before and after.
fn most_frequent(ids: &[u32], counts: &mut [u32]) -> u32 {
    let mut most = 0;
    for &id in ids {
        counts[id as usize] += 1;
        most = most.max(counts[id as usize]);
    }
    for &id in ids {
        counts[id as usize] = 0;
    }
    most
}

/// Labels as ids below `count`.
struct Ids {
    ids: Vec<u32>,
    count: usize,
}

impl Ids {
    fn new(labels: &[i64]) -> Self {
        if let Some(range) = Range::of(labels) {
            let ids = labels.iter().map(|&label| range.id(label) as u32).collect();
            return Self { ids, count: range.count };
        }
        let mut table = Table::default();
        let ids = labels
            .iter()
            .map(|&label| {
                let next = table.len() as i64;
                *table.entry(label).or_insert(next) as u32
            })
            .collect();
        Self { ids, count: table.len() }
    }
}

/// Labels that span so short a range that an array indexed by them is worth its memory.
struct Range {
    first: i64,
    count: usize,
}

impl Range {
    /// Arrays of this many elements are made whatever the number of labels.
    const SHORT: u64 = 1 << 12;

    fn of(labels: &[i64]) -> Option<Self> {
        let (first, last) = labels
            .iter()
            .fold((i64::MAX, i64::MIN), |(least, most), &l| (least.min(l), most.max(l)));
        if labels.is_empty() {
            return Some(Self { first: 0, count: 0 });
        }
        let longest = Self::SHORT.max(labels.len() as u64).min(u64::from(u32::MAX));
        let span = last.abs_diff(first);
        (span < longest).then(|| Self { first, count: span as usize + 1 })
    }

    #[inline]
    fn id(&self, label: i64) -> usize {
        label.wrapping_sub(self.first) as usize
    }
}

type Table = HashMap<i64, i64, BuildHasherDefault<Mixed>>;

/// Both halves of the product with an odd constant: every bit of a label reaches every bit of the
/// hash, so that labels in even steps do not fall together.
#[derive(Default)]
struct Mixed(u64);

impl Hasher for Mixed {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.write_u64(u64::from(byte)));
    }

    fn write_i64(&mut self, value: i64) {
        self.write_u64(value as u64);
    }

    fn write_u64(&mut self, value: u64) {
        let product = u128::from(self.0 ^ value) * 0x9e37_79b9_7f4a_7c15;
        self.0 = (product >> 64) as u64 ^ product as u64;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: [i64; 6] = [0, 0, 0, 1, 1, 1];
    const E: [i64; 6] = [0, 0, 1, 1, 0, 1];

    #[test]
    fn ids_of_any_size_count_alike() {
        for step in [1, 1 << 40, i64::MAX] {
            let (t, e) = (T.map(|l| l.wrapping_mul(step)), E.map(|l| l.wrapping_mul(step)));
            assert_eq!(track_purity(&t, &e), Ok(4.0 / 6.0));
            assert_eq!(track_fragmentation(&t, &e, None), Ok(3));
            assert_eq!(identity_switches(&t, &e, None), Ok(2));
        }
    }

    #[test]
    fn the_widest_range_of_labels_does_not_overflow() {
        let labels = [i64::MIN, i64::MAX, 0, i64::MIN];
        assert_eq!(track_purity(&labels, &labels), Ok(1.0));
        assert_eq!(track_fragmentation(&labels, &[1, 1, 1, 2], None), Ok(1));
    }

    #[test]
    fn equal_times_keep_their_order() {
        let (t, e) = ([0; 6], [0, 0, 1, 0, 1, 1]);
        assert_eq!(track_fragmentation(&t, &e, Some(&[1, 0, 1, 1, 0, 0])), Ok(4));
    }

    #[test]
    fn lists_of_different_lengths_are_refused() {
        let text = |e: Error| e.to_string();
        assert_eq!(
            track_purity(&[1], &[]).map_err(text),
            Err("estimated_labels has 0 labels, true_labels has 1".into())
        );
        assert_eq!(
            identity_switches(&[1], &[1], Some(&[])).map_err(text),
            Err("time_indices has 0 times, true_labels has 1".into())
        );
    }
}
