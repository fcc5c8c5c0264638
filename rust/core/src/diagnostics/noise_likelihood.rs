//! The likelihood of factors on the noises that a filter claims, from its log alone.
//!
//! A linear filter's innovations are a linear function of the initial error, the process noise and
//! the measurement noise, with the filter's own gains. With e the true minus the predicted state,
//! with mean m and covariance C given the innovations so far, an update k of measurement type t and
//! the corrections c that the filter applied (its gain times its innovation), the log-likelihood of
//! "the process noises are q_g times Q_g, the measurement noise is r_t times R" is a sum over the
//! updates of
//!
//! - prediction: m <- F m, C <- F C F' + sum over g of q_g Q_g;
//! - innovation: d = nu - H m ~ N(0, S), S = H C H' + r_t R;
//! - conditioning: m <- m + C H' S^-1 d, C <- C - C H' S^-1 H C, then m <- m - c.
//!
//! At q = r = 1 it is what the filter claims. A track starts from m = 0 and `initial_factor` times
//! its initial covariance. A component of nu that is NaN is not used; its correction still counts.
//! A component with a period is an angle, and its d is wrapped.
//!
//! The score (gradient) and the information matrix with respect to q, r and the initial factor come
//! by forward differentiation; the information is the sum of
//! tr(S^-1 S_i S^-1 S_j) / 2 + d_i' S^-1 d_j, whose expectation is Fisher's. Mehra (1970),
//! doi:10.1109/TAC.1970.1099422; Harvey (1989), Forecasting, structural time series models and the
//! Kalman filter, 3.4.5.
//!
//! With `tail_dof` = v finite the innovations have Student's t distribution instead: a squared d of
//! delta = d' S^-1 d with p components counts with the weight W = s (v + p) / (v + s delta),
//! s = `tail_scales[p]`, and where W < 1 the update conditions with R / W instead of R.
//!
//! Cost: linear in updates; n^3 for each update and parameter. Threads over tracks.

use super::noise_filter::{Track, filter};
pub use super::noise_log::{NoiseFactors, NoiseLog};
use super::segmentation::check_starts;
use crate::error::{Error, Result};
use crate::threads;

/// The largest number of states, and of components of a measurement.
pub const LARGEST: usize = 64;

/// What the likelihood is, and what goes with it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct NoiseLikelihood {
    /// `(updates,)`: log-density of each innovation given those before; 0 where there is none.
    pub densities: Vec<f64>,
    /// `(tracks, parameters)`: derivatives of a track's sum by process, measurement and initial factors.
    pub gradients: Vec<f64>,
    /// `(tracks, parameters, parameters)`: information matrices.
    pub informations: Vec<f64>,
    /// `(updates, m)`: d whitened by the Cholesky factor of S; 0 where a component is missing.
    pub whitened: Vec<f64>,
    /// `(tracks, n)`: mean of the last prediction error, before the filter's last correction.
    pub means: Vec<f64>,
    /// `(tracks, n, n)`: its covariance, given all innovations.
    pub covariances: Vec<f64>,
}

/// The log-likelihood, update by update; without `derivatives` gradients and informations are empty.
///
/// # Errors
/// If sizes do not fit, something is not finite, a type has no factor, a factor is negative, there
/// are more than [`LARGEST`] states or components, or an innovation covariance is not positive
/// definite at these factors.
pub fn noise_likelihood(
    log: &NoiseLog<'_>,
    factors: &NoiseFactors<'_>,
    derivatives: bool,
) -> Result<NoiseLikelihood> {
    check(log, factors)?;
    let mut tracks = vec![Track::default(); log.starts.len() - 1];
    threads::fill(&mut tracks, 8, |first, piece| {
        piece.iter_mut().enumerate().try_for_each(|(i, track)| {
            *track = filter(log, factors, derivatives, first + i)?;
            Ok(())
        })
    })?;
    Ok(gathered(&tracks))
}

fn gathered(tracks: &[Track]) -> NoiseLikelihood {
    let flat = |part: fn(&Track) -> &[f64]| tracks.iter().flat_map(part).copied().collect();
    NoiseLikelihood {
        densities: flat(|track| &track.densities),
        gradients: flat(|track| &track.gradient),
        informations: flat(|track| &track.information),
        whitened: flat(|track| &track.whitened),
        means: flat(|track| &track.mean),
        covariances: flat(|track| &track.covariance),
    }
}

fn check(log: &NoiseLog<'_>, factors: &NoiseFactors<'_>) -> Result<()> {
    let (n, m, updates) = (log.states, log.components, log.types.len());
    for (argument, value) in [("states", n), ("components", m)] {
        if value > LARGEST {
            let value = value as f64;
            return Err(Error::Parameter { argument, requirement: "at most 64", value });
        }
    }
    check_starts("innovations", log.starts, updates)?;
    let tracks = log.starts.len() - 1;
    for (argument, values, size, rows, other, unit) in [
        ("innovations", log.innovations, m, updates, "types", "updates"),
        ("observations", log.observations, m * n, updates, "types", "updates"),
        ("measurement_noises", log.measurement_noises, m * m, updates, "types", "updates"),
        ("transitions", log.transitions, n * n, updates, "types", "updates"),
        ("process_noises", log.process_noises, log.groups * n * n, updates, "types", "updates"),
        ("corrections", log.corrections, n, updates, "types", "updates"),
        ("periods", log.periods, m, updates, "types", "updates"),
        ("initial", log.initial, n * n, tracks, "starts", "tracks"),
    ] {
        let found = values.len().checked_div(size).unwrap_or(rows);
        if values.len() != size * rows {
            return Err(Error::Length { argument, found, other, expected: rows, unit });
        }
        let nan_allowed = matches!(argument, "innovations" | "periods");
        let bad = |v: &f64| if nan_allowed { v.is_infinite() } else { !v.is_finite() };
        if all_finite(values) {
            continue;
        }
        if let Some(i) = values.iter().position(bad) {
            return Err(Error::NotFinite { argument, index: vec![i / size], value: values[i] });
        }
    }
    check_factors(log, factors)
}

/// Whether all values are finite, in code that compiles to vector instructions.
fn all_finite(values: &[f64]) -> bool {
    const EXPONENT: u64 = 0x7ff0_0000_0000_0000;
    let bad = |v: &f64| u64::from(v.to_bits() & EXPONENT == EXPONENT);
    values.iter().map(bad).fold(0, |any, bad| any | bad) == 0
}

fn check_factors(log: &NoiseLog<'_>, factors: &NoiseFactors<'_>) -> Result<()> {
    for (argument, found, other, expected, unit) in [
        ("process_factors", factors.process.len(), "process_noises", log.groups, "groups"),
        ("tail_scales", factors.tail_scales.len(), "innovations", log.components + 1, "sizes"),
    ] {
        if found != expected {
            return Err(Error::Length { argument, found, other, expected, unit });
        }
    }
    let count = factors.measurement.len();
    if let Some(k) = log.types.iter().position(|&t| t < 0 || t >= count as i64) {
        let (argument, value) = ("types", log.types[k] as f64);
        let requirement = "an index of measurement_factors";
        return Err(Error::Element { argument, index: vec![k], requirement, value });
    }
    for (argument, values) in [
        ("process_factors", factors.process),
        ("measurement_factors", factors.measurement),
        ("initial_factor", &[factors.initial][..]),
    ] {
        if let Some(&value) = values.iter().find(|v| !(v.is_finite() && **v >= 0.0)) {
            return Err(Error::Parameter { argument, requirement: "at least 0", value });
        }
    }
    if factors.tail_dof > 0.0 {
        return Ok(());
    }
    let value = factors.tail_dof;
    Err(Error::Parameter { argument: "tail_dof", requirement: "positive", value })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scalar<'a>(innovations: &'a [f64], ones: &'a [f64], starts: &'a [i64]) -> NoiseLog<'a> {
        NoiseLog {
            innovations,
            observations: ones,
            measurement_noises: ones,
            types: &[0, 0],
            transitions: ones,
            process_noises: ones,
            corrections: &[0.0, 0.0],
            periods: &[f64::NAN, f64::NAN],
            initial: &ones[..1],
            starts,
            states: 1,
            components: 1,
            groups: 1,
        }
    }

    fn factors(q: &[f64]) -> NoiseFactors<'_> {
        let (tail_dof, tail_scales) = (f64::INFINITY, &[1.0, 1.0]);
        NoiseFactors { process: q, measurement: &[1.0], initial: 1.0, tail_dof, tail_scales }
    }

    #[test]
    fn two_updates_of_a_random_walk_have_their_joint_density() {
        // Without corrections nu = (e + v, e + w + v'): covariance [[2, 1], [1, 3]].
        let log = scalar(&[1.0, -0.5], &[1.0, 1.0], &[0, 2]);
        let found = noise_likelihood(&log, &factors(&[1.0]), true).unwrap();
        let form = (3.0 + 2.0 * 0.5 + 2.0 * 0.25) / 5.0;
        let expected = -0.5 * (form + 5f64.ln() + 2.0 * (2.0 * std::f64::consts::PI).ln());
        assert!((found.densities.iter().sum::<f64>() - expected).abs() < 1e-13);
        assert_eq!(found.gradients.len(), 3);
    }

    #[test]
    fn tracks_are_independent_and_wrong_arguments_are_named() {
        let ones = [1.0, 1.0];
        let mut log = scalar(&[1.0, f64::NAN], &ones, &[0, 1, 2]);
        log.initial = &ones;
        let found = noise_likelihood(&log, &factors(&[1.0]), false).unwrap();
        assert_eq!((found.means.len(), found.densities[1]), (2, 0.0));
        let error = noise_likelihood(&log, &factors(&[-1.0]), false).unwrap_err();
        assert_eq!(error.to_string(), "process_factors must be at least 0, got -1.0");
        log.corrections = &[0.0];
        let error = noise_likelihood(&log, &factors(&[1.0]), false).unwrap_err();
        assert_eq!(error.to_string(), "corrections has 1 updates, types has 2");
    }
}
