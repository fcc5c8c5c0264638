//! Matrices of distances between two sets, other than Euclidean ones.
//!
//! | metric | distance of points a, b |
//! | --- | --- |
//! | Manhattan | sum of the absolute differences |
//! | haversine | great-circle distance of (latitude, longitude) in degrees, in metres: `2 R asin(sqrt(h))` with `h = sin^2((b1 - a1)/2) + cos a1 cos b1 sin^2((b2 - a2)/2)` and R = 6 371 008.8 m, the mean radius of the Earth |
//! | Mahalanobis | `sqrt((b - a)' P^-1 (b - a))`, with one covariance P for all or one for each point of the first set |
//!
//! The first two and Mahalanobis with one covariance are metrics; with a covariance per point the
//! triangle inequality fails.

use crate::arrays::Array;
use crate::error::{Error, Result};
use crate::points::Points;

/// Mean radius of the Earth in metres (IUGG).
pub const EARTH_RADIUS: f64 = 6_371_008.8;

/// Asymmetry, relative to the standard deviations, up to which a covariance counts as symmetric.
const SYMMETRY: f64 = 1e-8;

/// The distances of all pairs by `distance`, row by row.
fn matrix(x: Points, y: Points, distance: impl Fn(&[f64], &[f64]) -> f64) -> Vec<f64> {
    let rows = 0..x.len();
    rows.flat_map(|i| (0..y.len()).map(move |j| (i, j)))
        .map(|(i, j)| distance(x.point(i), y.point(j)))
        .collect()
}

/// Checks that all points have the same dimension.
pub(super) fn check_dimensions(x: Points, y: Points) -> Result<()> {
    let (expected, found) = (x.dimension(), y.dimension());
    if x.is_empty() || y.is_empty() || found == expected {
        return Ok(());
    }
    Err(Error::Dimension { argument: "Y", index: vec![0], found, expected })
}

/// Manhattan distances.
///
/// # Errors
/// [`Error::Dimension`] for points of different dimensions.
pub fn manhattan(x: Points, y: Points) -> Result<Vec<f64>> {
    check_dimensions(x, y)?;
    Ok(matrix(x, y, |a, b| a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>() + 0.0))
}

/// Great-circle distances in metres of points (latitude, longitude) in degrees.
///
/// # Errors
/// [`Error::Dimension`] for points that are not two numbers.
pub fn haversine(x: Points, y: Points) -> Result<Vec<f64>> {
    require_dimension(x, y, 2)?;
    Ok(matrix(x, y, |a, b| great_circle([a[0], a[1]], [b[0], b[1]])))
}

fn great_circle(a: [f64; 2], b: [f64; 2]) -> f64 {
    let half_sine = |k: usize| ((b[k] - a[k]).to_radians() / 2.0).sin();
    let (north, east) = (half_sine(0), half_sine(1));
    let parallel = a[0].to_radians().cos() * b[0].to_radians().cos();
    2.0 * EARTH_RADIUS * (north * north + parallel * east * east).clamp(0.0, 1.0).sqrt().asin()
}

/// Mahalanobis distances with one covariance for all points, or one for each point of `x`:
/// `covariances` has shape `(1, d, d)` or `(n, d, d)`.
///
/// # Errors
/// [`Error::Shape`] for covariances that do not fit, [`Error::Dimension`] for points that do not;
/// [`Error::NotFinite`], [`Error::NotSymmetric`] and [`Error::NotPositiveDefinite`] name the
/// covariance.
pub fn mahalanobis(x: Points, y: Points, covariances: Array) -> Result<Vec<f64>> {
    let &[count, d, columns] = covariances.shape() else {
        return Err(covariances.misshapen("(n, d, d)"));
    };
    if columns != d || d == 0 || (count != 1 && count != x.len()) {
        return Err(covariances.misshapen("(d, d) or one such for each point of X"));
    }
    require_dimension(x, y, d)?;
    let factors = (0..count)
        .map(|k| factor(&covariances.values()[k * d * d..(k + 1) * d * d], d, k, count))
        .collect::<Result<Vec<_>>>()?;
    let mut distances = Vec::with_capacity(x.len() * y.len());
    for i in 0..x.len() {
        let lower = &factors[if count == 1 { 0 } else { i }];
        distances.extend((0..y.len()).map(|j| whitened_length(lower, x.point(i), y.point(j))));
    }
    Ok(distances)
}

/// Checks that all points have `expected` coordinates.
fn require_dimension(x: Points, y: Points, expected: usize) -> Result<()> {
    for (argument, points) in [("X", x), ("Y", y)] {
        if !points.is_empty() && points.dimension() != expected {
            let (index, found) = (vec![0], points.dimension());
            return Err(Error::Dimension { argument, index, found, expected });
        }
    }
    Ok(())
}

/// The lower triangular L with L L' = P, row by row.
fn factor(p: &[f64], d: usize, which: usize, count: usize) -> Result<Vec<f64>> {
    let (argument, index) = ("covariances", if count == 1 { Vec::new() } else { vec![which] });
    if let Some(at) = p.iter().position(|value| !value.is_finite()) {
        let index = index.into_iter().chain([at / d, at % d]).collect();
        return Err(Error::NotFinite { argument, index, value: p[at] });
    }
    let mut lower = vec![0.0; d * d];
    for i in 0..d {
        for j in 0..=i {
            let (a, b) = (p[i * d + j], p[j * d + i]);
            if (a - b).abs() > SYMMETRY * (p[i * d + i] * p[j * d + j]).abs().sqrt() {
                return Err(Error::NotSymmetric { argument, index, row: j, column: i });
            }
            let known: f64 = (0..j).map(|k| lower[i * d + k] * lower[j * d + k]).sum();
            let rest = (a + b) / 2.0 - known;
            if i != j {
                lower[i * d + j] = rest / lower[j * d + j];
            } else if rest > 0.0 {
                lower[i * d + i] = rest.sqrt();
            } else {
                return Err(Error::NotPositiveDefinite { argument, index, minor: i + 1 });
            }
        }
    }
    Ok(lower)
}

/// The length of z with L z = b - a.
fn whitened_length(lower: &[f64], a: &[f64], b: &[f64]) -> f64 {
    let d = a.len();
    let mut z = vec![0.0; d];
    for i in 0..d {
        let known: f64 = (0..i).map(|k| lower[i * d + k] * z[k]).sum();
        z[i] = (b[i] - a[i] - known) / lower[i * d + i];
    }
    z.iter().map(|z| z * z).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(values: &[f64]) -> Points<'_> {
        Points::new("X", values, 2).unwrap()
    }

    #[test]
    fn a_quarter_of_a_meridian() {
        let d = haversine(points(&[0.0, 0.0]), points(&[90.0, 0.0])).unwrap();
        assert!((d[0] - EARTH_RADIUS * std::f64::consts::FRAC_PI_2).abs() < 1e-6);
    }

    #[test]
    fn whitening_by_a_covariance() {
        let p = Array::new("covariances", &[4.0, 0.0, 0.0, 9.0], &[1, 2, 2]).unwrap();
        let d = mahalanobis(points(&[1.0, 1.0]), points(&[3.0, 4.0]), p).unwrap();
        assert_eq!(d, [2.0f64.sqrt()]);
        let wrong = Array::new("covariances", &[1.0, 2.0, 2.0, 1.0], &[1, 2, 2]).unwrap();
        let error = mahalanobis(points(&[0.0, 0.0]), points(&[]), wrong).unwrap_err();
        assert_eq!(error.to_string(), "covariances is not positive definite (leading minor 2)");
    }
}
