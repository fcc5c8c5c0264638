//! Root mean square errors over any axes.
//!
//! ```text
//! rmse = sqrt( mean over the axes of (truth - estimate)^2 )
//! ```
//!
//! NaN propagates: a mean over an unknown error is unknown. A mean over nothing is an error.
//!
//! Neighbouring axes that are both averaged, or both kept, are one axis to the loops.

use crate::arrays::{Array, unravel};
use crate::error::{Error, Result};
use crate::simd;
use crate::simd::sums::{add_squares, short_rows, squares};
use pulp::{Simd, WithSimd};

/// The longest row that is summed with many rows side by side.
const SHORT: usize = 9;

/// Root mean squares of `truth - estimate`, or of `truth` where there is no estimate, over `axes`
/// (`None` for all), and the shape of the result: the axes that are left.
///
/// # Errors
/// [`Error::Shape`] where shapes differ, [`Error::Axis`], [`Error::Empty`].
pub fn rmse(
    truth: Array,
    estimate: Option<Array>,
    axes: Option<&[i64]>,
) -> Result<(Vec<f64>, Vec<usize>)> {
    if let Some(estimate) = &estimate {
        estimate.require_shape(&truth)?;
    }
    let averaged = averaged(truth.shape(), axes)?;
    let lengths = || truth.shape().iter().copied().zip(averaged.iter().copied());
    let count: usize = lengths().filter(|axis| axis.1).map(|axis| axis.0).product();
    if count == 0 {
        return Err(Error::Empty { argument: truth.argument() });
    }
    let shape: Vec<usize> = lengths().filter(|axis| !axis.1).map(|axis| axis.0).collect();
    let mut output = vec![0.0; shape.iter().product()];
    let groups = merged(lengths());
    if !output.is_empty() {
        add(&groups, truth.values(), estimate.map(|array| array.values()), &mut output);
    }
    simd::dispatch(RootMeans { sums: &mut output, count: count as f64 });
    Ok((output, shape))
}

/// Roots of sums over a count.
struct RootMeans<'a> {
    sums: &'a mut [f64],
    count: f64,
}

impl WithSimd for RootMeans<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.sums.iter_mut().for_each(|sum| *sum = (*sum / self.count).sqrt());
    }
}

/// Which axes are averaged.
fn averaged(shape: &[usize], axes: Option<&[i64]>) -> Result<Vec<bool>> {
    let count = shape.len();
    let Some(axes) = axes else {
        return Ok(vec![true; count]);
    };
    let mut averaged = vec![false; count];
    for &found in axes {
        let axis = if found < 0 { found.saturating_add(count as i64) } else { found };
        match usize::try_from(axis).ok().and_then(|axis| averaged.get_mut(axis)) {
            Some(chosen) if !*chosen => *chosen = true,
            _ => return Err(Error::Axis { found, axes: count }),
        }
    }
    Ok(averaged)
}

/// Runs of axes that are all averaged, or all kept, as one axis each.
fn merged(axes: impl Iterator<Item = (usize, bool)>) -> Vec<(usize, bool)> {
    let mut groups: Vec<(usize, bool)> = vec![];
    for (length, averaged) in axes.filter(|axis| axis.0 != 1) {
        match groups.last_mut() {
            Some(last) if last.1 == averaged => last.0 *= length,
            _ => groups.push((length, averaged)),
        }
    }
    groups
}

/// Adds the squares to the sums of the kept axes.
fn add(groups: &[(usize, bool)], first: &[f64], second: Option<&[f64]>, output: &mut [f64]) {
    match *groups {
        [] | [(_, true)] => output[0] += squares(first, second),
        [(_, false)] => add_squares(first, second, output),
        [(_, true), (_, false)] => add_rows(first, second, output),
        [(rows, false), (width, true)] if width <= SHORT => {
            let mut sums = vec![0.0; rows];
            short_rows(width, first, second, &mut sums);
            output.iter_mut().zip(sums).for_each(|(total, sum)| *total += sum);
        }
        [(length, averaged), ref inner @ ..] => {
            let size = first.len() / length;
            let kept = if averaged { 0 } else { output.len() / length };
            for i in 0..length {
                let part = i * size..(i + 1) * size;
                let place =
                    if averaged { &mut *output } else { &mut output[i * kept..(i + 1) * kept] };
                add(inner, &first[part.clone()], second.map(|values| &values[part]), place);
            }
        }
    }
}

/// Sums over rows. Short rows are taken several at a time, so that a vector is filled.
fn add_rows(first: &[f64], second: Option<&[f64]>, output: &mut [f64]) {
    let width = output.len();
    let together = (64 / width).max(1);
    let mut sums = vec![0.0; together * width];
    let whole = first.len() / sums.len() * sums.len();
    add_squares(&first[..whole], second.map(|values| &values[..whole]), &mut sums);
    for row in sums.chunks_exact(width) {
        output.iter_mut().zip(row).for_each(|(total, sum)| *total += sum);
    }
    add_squares(&first[whole..], second.map(|values| &values[whole..]), output);
}

/// Root mean square of the components `indices` of states `(..., d)`, over everything.
///
/// # Errors
/// [`Error::Shape`] where shapes differ, [`Error::Index`] for an index outside the state,
/// [`Error::Empty`] where there are no states or no indices.
pub fn rmse_of(
    truth: Array,
    estimate: Array,
    argument: &'static str,
    indices: &[i64],
) -> Result<f64> {
    let Some(&d) = truth.shape().last() else {
        return Err(truth.misshapen("(..., d)"));
    };
    estimate.require_shape(&truth)?;
    if indices.is_empty() {
        return Err(Error::Empty { argument });
    }
    let mut columns = Vec::with_capacity(indices.len());
    for (place, &found) in indices.iter().enumerate() {
        let column = if found < 0 { found.saturating_add(d as i64) } else { found };
        match usize::try_from(column) {
            Ok(column) if column < d => columns.push(column),
            _ => return Err(Error::Index { argument, place, found, length: d }),
        }
    }
    truth.require_elements()?;
    let mut totals = vec![0.0; d];
    add_rows(truth.values(), Some(estimate.values()), &mut totals);
    let sum: f64 = columns.iter().map(|&column| totals[column]).sum();
    let count = truth.values().len() / d * columns.len();
    Ok((sum / count as f64).sqrt())
}

/// `sigma` standard deviations of every state: `(..., d)` of covariances `(..., d, d)`.
///
/// # Errors
/// [`Error::Shape`] for what is not square, [`Error::Element`] for the first variance that is
/// negative, NaN or infinite, [`Error::Parameter`] for a `sigma` that is not finite.
pub fn error_bounds(covariances: Array, sigma: f64) -> Result<Vec<f64>> {
    let [.., rows, d] = *covariances.shape() else {
        return Err(covariances.misshapen("(..., d, d)"));
    };
    if rows != d {
        return Err(covariances.misshapen("(..., d, d)"));
    }
    if !sigma.is_finite() {
        return Err(Error::Parameter { argument: "sigma", requirement: "finite", value: sigma });
    }
    let size = (d * d).max(1);
    let diagonals = covariances
        .values()
        .chunks_exact(size)
        .enumerate()
        .flat_map(|(k, p)| (0..d).map(move |i| (k * size + i * (d + 1), p[i * (d + 1)])));
    diagonals
        .map(|(place, variance)| {
            if variance.is_finite() && variance >= 0.0 {
                return Ok(sigma * variance.sqrt());
            }
            Err(Error::Element {
                argument: covariances.argument(),
                index: unravel(place, covariances.shape()),
                requirement: "finite and at least 0",
                value: variance,
            })
        })
        .collect()
}
