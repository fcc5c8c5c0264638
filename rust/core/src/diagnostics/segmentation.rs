//! Where the scale of a sequence of chi-square values changes.
//!
//! A value c_k with m_k degrees of freedom, times an unknown scale that is constant within each
//! segment. For every number of segments from 1 to `most` the partition is found that maximises the
//! likelihood, that is the sum over segments of -M ln(N / M) with N the sum of the c and M the sum
//! of the m (see `likelihood`): the optimal partition by dynamic programming,
//!
//! best(s, b) = max over a of best(s - 1, a) - M(a, b) ln(N(a, b) / M(a, b))
//!
//! (see `optimal`), each segment of `least` values or more. Jackson et al. (2005), doi:10.1109/LSP.2001.838216. The
//! gain of a partition is what it has over one segment. How many segments there are is decided by
//! who calls, since the number of segments costs a penalty that the caller draws.
//!
//! Ties go to the earlier cut. Cost: most n^2 / 2 additions and n^2 / 2 logarithms. Above `FINE`
//! values cuts are first sought on a grid of `FINE` blocks and then moved to where they are best
//! between the blocks on either side.

use super::likelihood::best;
use super::optimal::{Optimal, Work};
pub use super::partitions::Partitions;
use crate::error::{Error, Result};
use crate::{simd, threads};

/// The largest number of blocks between which cuts are sought.
pub const FINE: usize = 1024;

/// The best partitions of many sequences, one behind the other, into 1 to `most` segments.
///
/// Sequence i is `values[starts[i]..starts[i + 1]]`.
///
/// # Errors
/// If a value is not finite or negative, a degree of freedom not positive, the lengths differ,
/// `starts` do not rise to the number of values, or `least` or `most` is 0.
pub fn scale_partitions(
    values: &[f64],
    dof: &[f64],
    starts: &[i64],
    least: usize,
    most: usize,
) -> Result<Vec<Partitions>> {
    check(values, dof, starts, least, most)?;
    let mut output = vec![Partitions::default(); starts.len() - 1];
    threads::fill(&mut output, 4, |first, piece| {
        let mut work = Work::default();
        for (i, partitions) in piece.iter_mut().enumerate() {
            let range = starts[first + i] as usize..starts[first + i + 1] as usize;
            *partitions = partition(&values[range.clone()], &dof[range], least, most, &mut work);
        }
        Ok(())
    })?;
    Ok(output)
}

/// Many partitions as two arrays: gains `(k, most)` and cuts `(k, most, most - 1)`, -1 where there
/// is none.
pub fn flatten(partitions: &[Partitions], most: usize) -> (Vec<f64>, Vec<i64>) {
    let gains = partitions.iter().flat_map(|p| p.gains.iter().copied()).collect();
    let mut cuts = Vec::with_capacity(partitions.len() * most * most.saturating_sub(1));
    for cuts_of in partitions.iter().flat_map(|p| &p.cuts) {
        cuts.extend(cuts_of.iter().map(|&cut| cut as i64));
        cuts.extend(std::iter::repeat_n(-1, most - 1 - cuts_of.len()));
    }
    (gains, cuts)
}

fn check(values: &[f64], dof: &[f64], starts: &[i64], least: usize, most: usize) -> Result<()> {
    check_values(values, dof)?;
    check_starts("values", starts, values.len())?;
    for (argument, count) in [("least", least), ("most", most)] {
        if count == 0 {
            return Err(Error::Parameter { argument, requirement: "at least 1", value: 0.0 });
        }
    }
    Ok(())
}

/// Values are finite and not negative, and each has a positive number of degrees of freedom.
pub(super) fn check_values(values: &[f64], dof: &[f64]) -> Result<()> {
    if dof.len() != values.len() {
        let (found, expected) = (dof.len(), values.len());
        return Err(Error::Length {
            argument: "dof",
            found,
            other: "values",
            expected,
            unit: "values",
        });
    }
    for (index, (&value, &m)) in values.iter().zip(dof).enumerate() {
        if !value.is_finite() {
            return Err(Error::NotFinite { argument: "values", index: vec![index], value });
        }
        if value < 0.0 {
            return Err(Error::Parameter { argument: "values", requirement: "at least 0", value });
        }
        if !m.is_finite() {
            return Err(Error::NotFinite { argument: "dof", index: vec![index], value: m });
        }
        if m <= 0.0 {
            return Err(Error::Parameter { argument: "dof", requirement: "positive", value: m });
        }
    }
    Ok(())
}

/// Offsets rise from 0 to `count`.
pub(super) fn check_starts(argument: &'static str, starts: &[i64], count: usize) -> Result<()> {
    let rising = starts.windows(2).all(|pair| pair[0] <= pair[1]);
    if starts.first() != Some(&0) || starts.last() != Some(&(count as i64)) || !rising {
        return Err(Error::Offsets { argument, points: count });
    }
    Ok(())
}

fn partition(
    values: &[f64],
    dof: &[f64],
    least: usize,
    most: usize,
    work: &mut Work,
) -> Partitions {
    let stride = values.len().div_ceil(FINE).max(1);
    if stride == 1 {
        return optimal(values, dof, least, most, work);
    }
    let blocks = values.len() / stride;
    let coarse = |data: &[f64]| -> Vec<f64> {
        let end = |i: usize| if i + 1 == blocks { data.len() } else { (i + 1) * stride };
        (0..blocks).map(|i| data[i * stride..end(i)].iter().sum()).collect()
    };
    let mut partitions = optimal(&coarse(values), &coarse(dof), least.div_ceil(stride), most, work);
    for (gain, cuts) in partitions.gains.iter_mut().zip(&mut partitions.cuts) {
        cuts.iter_mut().for_each(|cut| *cut *= stride);
        if gain.is_finite() {
            *gain = refine(values, dof, least, stride, cuts);
        }
    }
    partitions
}

/// Moves each cut, twice in turn, to the best place within a stride; the gain after that.
fn refine(values: &[f64], dof: &[f64], least: usize, stride: usize, cuts: &mut [usize]) -> f64 {
    let n = values.len();
    let likelihood = |a: usize, b: usize| best(values[a..b].iter().sum(), dof[a..b].iter().sum());
    for round in 0..2 * cuts.len() {
        let j = round % cuts.len();
        let before = if j == 0 { 0 } else { cuts[j - 1] };
        let after = if j + 1 == cuts.len() { n } else { cuts[j + 1] };
        let low = (cuts[j].saturating_sub(stride)).max(before + least);
        let high = (cuts[j] + stride).min(after.saturating_sub(least));
        let (mut left, mut right) = (sums(values, dof, before, low), sums(values, dof, low, after));
        let mut largest = f64::NEG_INFINITY;
        for place in low..=high {
            let gain = best(left.0, left.1) + best(right.0, right.1);
            if gain > largest {
                (largest, cuts[j]) = (gain, place);
            }
            if place < n {
                left = (left.0 + values[place], left.1 + dof[place]);
                right = ((right.0 - values[place]).max(0.0), right.1 - dof[place]);
            }
        }
    }
    let ends = cuts.iter().copied().chain([n]);
    let begins = [0].into_iter().chain(cuts.iter().copied());
    begins.zip(ends).map(|(a, b)| likelihood(a, b)).sum::<f64>() - likelihood(0, n)
}

fn sums(values: &[f64], dof: &[f64], from: usize, to: usize) -> (f64, f64) {
    let range = from.min(to)..to;
    (values[range.clone()].iter().sum(), dof[range].iter().sum())
}

fn optimal(values: &[f64], dof: &[f64], least: usize, most: usize, work: &mut Work) -> Partitions {
    simd::dispatch(Optimal { values, dof, least, most, work })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(values: &[f64], least: usize, most: usize) -> Partitions {
        let dof = vec![2.0; values.len()];
        scale_partitions(values, &dof, &[0, values.len() as i64], least, most).unwrap().remove(0)
    }

    #[test]
    fn a_step_is_cut_where_it_stands() {
        let values: Vec<f64> = (0..30).map(|k| if k < 12 { 2.0 } else { 20.0 }).collect();
        let found = run(&values, 2, 4);
        assert_eq!(found.cuts[1], [12]);
        let whole = 60.0 * (384.0f64 / 60.0).ln();
        let parts = 36.0 * 10f64.ln();
        assert!((found.gains[1] - (whole - parts)).abs() < 1e-9);
    }

    #[test]
    fn long_sequences_are_cut_at_the_very_value() {
        let values: Vec<f64> = (0..5000).map(|k| if k < 3217 { 2.0 } else { 3.0 }).collect();
        assert_eq!(run(&values, 2, 2).cuts[1], [3217]);
    }

    #[test]
    fn short_sequences_have_no_cut() {
        let found = run(&[1.0, 2.0, 3.0], 2, 3);
        assert_eq!(found.gains, [0.0, f64::NEG_INFINITY, f64::NEG_INFINITY]);
        assert_eq!(run(&[], 2, 1).gains, [0.0]);
    }

    #[test]
    fn wrong_arguments_are_named() {
        let wrong = |values: &[f64], dof: &[f64], starts: &[i64]| {
            scale_partitions(values, dof, starts, 2, 4).unwrap_err().to_string()
        };
        assert_eq!(wrong(&[f64::NAN], &[1.0], &[0, 1]), "values[0] is not finite: nan");
        assert_eq!(wrong(&[1.0], &[0.0], &[0, 1]), "dof must be positive, got 0.0");
        assert_eq!(wrong(&[1.0], &[], &[0, 1]), "dof has 0 values, values has 1");
        assert!(wrong(&[1.0], &[1.0], &[]).starts_with("values: starts must rise"));
    }
}
