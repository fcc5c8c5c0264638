//! When a cumulative sum test for a change of scale first raises its alarm.
//!
//! The log-likelihood ratio of scale s against 1 of a chi-square value c with m degrees of freedom
//! is l = -(m / 2) ln s + (c / 2) (1 - 1 / s). The alarm is at the first value at which the sum of
//! the l has risen by more than h above its lowest so far; the change began at the last value before
//! which it was lowest. Page (1954), doi:10.1093/biomet/41.1-2.100.
//!
//! Cost: a few operations a value.

use super::segmentation::{check_starts, check_values};
use crate::error::{Error, Result};

/// The first alarm of each of many sequences, one behind the other: its place and where the rise
/// began, counted within the sequence.
///
/// Sequence i is `values[starts[i]..starts[i + 1]]`; its threshold is ln(length / `alpha`).
///
/// # Errors
/// If a value is not finite or negative, a degree of freedom not positive, the lengths differ,
/// `starts` do not rise to the number of values, or `scale` or `alpha` is not positive.
pub fn first_alarms(
    values: &[f64],
    dof: &[f64],
    starts: &[i64],
    scale: f64,
    alpha: f64,
) -> Result<Vec<Option<(usize, usize)>>> {
    check_values(values, dof)?;
    check_starts("values", starts, values.len())?;
    for (argument, value) in [("scale", scale), ("alpha", alpha)] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(Error::Parameter { argument, requirement: "positive", value });
        }
    }
    let (half_log, half_gain) = (scale.ln() / 2.0, (1.0 - 1.0 / scale) / 2.0);
    let alarm = |pair: &[i64]| {
        let range = pair[0] as usize..pair[1] as usize;
        let threshold = (range.len() as f64 / alpha).ln();
        let rises = values[range.clone()].iter().zip(&dof[range]);
        first_alarm(rises.map(|(value, m)| value * half_gain - m * half_log), threshold)
    };
    Ok(starts.windows(2).map(alarm).collect())
}

fn first_alarm(rises: impl Iterator<Item = f64>, threshold: f64) -> Option<(usize, usize)> {
    let (mut sum, mut lowest, mut onset) = (0.0, 0.0, 0);
    for (k, rise) in rises.enumerate() {
        if sum <= lowest {
            (lowest, onset) = (sum, k);
        }
        sum += rise;
        if sum - lowest > threshold {
            return Some((k, onset));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rise_is_called_with_where_it_began() {
        let values: Vec<f64> = (0..40).map(|k| if k < 25 { 1.0 } else { 20.0 }).collect();
        let found = first_alarms(&values, &[2.0; 40], &[0, 25, 25, 40], 2.5, 0.01).unwrap();
        assert_eq!(found[..2], [None, None]);
        let rise = 6.0 - 2.5f64.ln();
        let needed = (1500f64.ln() / rise) as usize;
        assert_eq!(found[2], Some((needed, 0)));
        let whole = first_alarms(&values, &[2.0; 40], &[0, 40], 2.5, 0.01).unwrap();
        assert_eq!(whole[0].unwrap().1, 25);
    }

    #[test]
    fn wrong_arguments_are_named() {
        let wrong = |values: &[f64], scale: f64, alpha: f64| {
            first_alarms(values, &[1.0], &[0, 1], scale, alpha).unwrap_err().to_string()
        };
        assert_eq!(wrong(&[-1.0], 2.0, 0.1), "values must be at least 0, got -1.0");
        assert_eq!(wrong(&[1.0], f64::NAN, 0.1), "scale must be positive, got nan");
        assert_eq!(wrong(&[1.0], 2.0, 0.0), "alpha must be positive, got 0.0");
        assert_eq!(wrong(&[1.0, 2.0], 2.0, 0.1), "dof has 1 values, values has 2");
    }
}
