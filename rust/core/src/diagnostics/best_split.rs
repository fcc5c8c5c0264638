//! What the best cut of a consistent sequence gains by coincidence.
//!
//! For each of many drawn sequences of chi-square values with one common scale, the largest gain in
//! likelihood over all places where it can be cut in two (see `segmentation`). A quantile of these
//! is the penalty that a cut of real data must exceed: exact for every length and every pattern of
//! degrees of freedom, and free of the scale.

use super::likelihood::best;
use crate::error::{Error, Result};
use crate::{simd, threads};
use pulp::{Simd, WithSimd};

/// The gain of the best cut of each row of `draws`, a `(rows, dof.len())` array, with `least`
/// values or more on either side; 0 where a row is too short to be cut.
///
/// # Errors
/// If a draw or a degree of freedom is not finite, a degree of freedom not positive, or `draws` is
/// not a whole number of rows.
pub fn best_split_gains(draws: &[f64], dof: &[f64], least: usize) -> Result<Vec<f64>> {
    let n = dof.len();
    check(draws, dof)?;
    let rows = draws.len().checked_div(n).unwrap_or(0);
    let mut gains = vec![0.0; rows];
    let least = least.max(1);
    if n < 2 * least {
        return Ok(gains);
    }
    let dofs: Vec<f64> = cumulated(dof);
    threads::fill(&mut gains, 1 + 20_000 / n, |first, piece| {
        let mut sums = vec![0.0; n];
        for (i, gain) in piece.iter_mut().enumerate() {
            let row = &draws[(first + i) * n..(first + i + 1) * n];
            *gain = simd::dispatch(BestSplit { row, dofs: &dofs, least, sums: &mut sums });
        }
        Ok(())
    })?;
    Ok(gains)
}

fn check(draws: &[f64], dof: &[f64]) -> Result<()> {
    if let Some(index) = draws.iter().position(|d| !d.is_finite()) {
        return Err(Error::NotFinite {
            argument: "draws",
            index: vec![index],
            value: draws[index],
        });
    }
    if let Some(&value) = dof.iter().find(|&&m| !(m.is_finite() && m > 0.0)) {
        return Err(Error::Parameter { argument: "dof", requirement: "positive", value });
    }
    if (dof.is_empty() && !draws.is_empty())
        || (!dof.is_empty() && !draws.len().is_multiple_of(dof.len()))
    {
        return Err(Error::Length {
            argument: "draws",
            found: draws.len(),
            other: "dof",
            expected: dof.len(),
            unit: "values",
        });
    }
    Ok(())
}

fn cumulated(values: &[f64]) -> Vec<f64> {
    values
        .iter()
        .scan(0.0, |sum, value| {
            *sum += value;
            Some(*sum)
        })
        .collect()
}

struct BestSplit<'a> {
    row: &'a [f64],
    /// Cumulated degrees of freedom.
    dofs: &'a [f64],
    least: usize,
    sums: &'a mut [f64],
}

impl WithSimd for BestSplit<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let Self { row, dofs, least, sums } = self;
        let mut sum = 0.0;
        for (cumulated, value) in sums.iter_mut().zip(row) {
            sum += value;
            *cumulated = sum;
        }
        let n = row.len();
        let dof = dofs[n - 1];
        for (cut, m) in sums[least - 1..n - least].iter_mut().zip(&dofs[least - 1..n - least]) {
            *cut = best(*cut, *m) + best(sum - *cut, dof - *m);
        }
        let largest = sums[least - 1..n - least].iter().copied().fold(f64::NEG_INFINITY, f64::max);
        largest - best(sum, dof)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnostics::segmentation::scale_partitions;

    #[test]
    fn the_best_cut_gains_what_two_segments_do() {
        let dof: Vec<f64> = (0..40).map(|k| f64::from(1 + k % 3)).collect();
        let draws: Vec<f64> = (0..120).map(|k| f64::from(1 + k * k % 17)).collect();
        let gains = best_split_gains(&draws, &dof, 2).unwrap();
        for (row, gain) in draws.chunks(40).zip(&gains) {
            let partitions = scale_partitions(row, &dof, &[0, 40], 2, 2).unwrap();
            assert!((partitions[0].gains[1] - gain).abs() < 1e-9);
        }
    }

    #[test]
    fn short_rows_gain_nothing() {
        assert_eq!(best_split_gains(&[1.0, 2.0, 3.0], &[1.0; 3], 2).unwrap(), [0.0]);
        assert_eq!(best_split_gains(&[], &[], 2).unwrap(), [0.0; 0]);
        assert!(best_split_gains(&[1.0], &[], 2).is_err());
    }
}
