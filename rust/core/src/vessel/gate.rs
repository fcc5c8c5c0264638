//! Which positions without identity may belong to which tracks.
//!
//! A position z lies in the gate of a track whose predicted position is p where
//! d^2 = (z - p)' S^-1 (z - p) <= gate, with S the sum of the covariances of both. From
//! |z_i - p_i| <= sqrt(gate S_ii) each gate lies in a box of latitude and longitude. The positions
//! are sorted into bands of latitude as high as a median box, by longitude within a band; a track
//! looks only into its segment of the bands that its box touches, so that the cost is that of
//! tracks and neighbours and not of all pairs.
//!
//! A track whose course is nearly unknown (standard deviation above 60 deg) may have gone anywhere
//! within its speed: its covariance gains ((|speed| + its deviation) t)^2 in both directions, which
//! the linearisation about one course cannot see.

use super::earth::{KNOT, degree, wrap_difference};
use super::motion::{Matrix, Motion, STATES, State};
use super::predict::{SQUARE, check};
use crate::error::{Error, Result};

/// Course deviation, deg, above which a straight line says nothing.
const LOST_COURSE: f64 = 60.0;

/// A pair that may belong together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// Index of the position.
    pub position: usize,
    /// Index of the track.
    pub track: usize,
    /// d^2.
    pub distance: f64,
    /// ln det S, S in square degrees.
    pub log_det: f64,
}

/// The predicted position of a track.
struct Place {
    at: [f64; 2],
    /// Covariance of latitude and longitude: two variances and what they share.
    covariance: [f64; 3],
    /// Half the height and width of the box that holds the gate, in degrees.
    reach: [f64; 2],
}

/// The pairs of positions and tracks within the gate, sorted by position, then track.
///
/// `x`, `p` are the tracks' states and covariances, `times` the seconds since, `z` latitudes and
/// longitudes of the positions, `sigmas` their standard deviations in metres, `gate` the bound of
/// d^2.
///
/// # Errors
/// Where lengths differ, a value is not finite, or a parameter is out of range.
pub fn gate(
    tracks: (&[f64], &[f64], &[f64]),
    z: &[f64],
    sigmas: &[f64],
    gate: f64,
    motion: &Motion,
) -> Result<Vec<Pair>> {
    let (x, p, times) = tracks;
    check(x, p, times, motion)?;
    check_positions(z, sigmas, gate)?;
    let widest = widest(z, sigmas);
    let places: Vec<Place> = (0..times.len())
        .map(|i| {
            let x = State::from_column_slice(&x[i * STATES..(i + 1) * STATES]);
            let p = Matrix::from_row_slice(&p[i * SQUARE..(i + 1) * SQUARE]);
            Place::new(&x, &p, times[i], motion, gate, widest)
        })
        .collect();
    let bands = Bands::new(z, &places);
    let mut pairs = Vec::new();
    for (track, place) in places.iter().enumerate() {
        bands.visit(place, |position| {
            let (distance, log_det) = place.distance(&z[2 * position..], sigmas[position]);
            if distance <= gate {
                pairs.push(Pair { position, track, distance, log_det });
            }
        });
    }
    pairs.sort_unstable_by_key(|pair| (pair.position, pair.track));
    Ok(pairs)
}

/// Variances of a position's latitude and longitude.
fn variances(latitude: f64, sigma: f64) -> [f64; 2] {
    let here = degree(latitude);
    [(sigma / here.north) * (sigma / here.north), (sigma / here.east) * (sigma / here.east)]
}

/// The largest of these over all positions.
fn widest(z: &[f64], sigmas: &[f64]) -> [f64; 2] {
    z.chunks_exact(2).zip(sigmas).fold([0.0, 0.0], |widest, (z, &sigma)| {
        let [north, east] = variances(z[0], sigma);
        [f64::max(widest[0], north), f64::max(widest[1], east)]
    })
}

impl Place {
    fn new(x: &State, p: &Matrix, time: f64, motion: &Motion, gate: f64, widest: [f64; 2]) -> Self {
        let at = motion.predict(x, p, time);
        let mut covariance = [at.p[(0, 0)], at.p[(1, 1)], at.p[(0, 1)]];
        if at.p[(3, 3)] > LOST_COURSE * LOST_COURSE {
            let anywhere = (at.x[2].abs() + at.p[(2, 2)].sqrt()) * KNOT * time;
            let [north, east] = variances(at.x[0], anywhere);
            covariance[0] += north;
            covariance[1] += east;
        }
        // A hair wider than the bound, so that rounding loses no pair.
        let reach = |i: usize| (gate * (covariance[i] + widest[i])).sqrt() * (1.0 + 1e-9) + 1e-12;
        Self { at: [at.x[0], at.x[1]], covariance, reach: [reach(0), reach(1)] }
    }

    /// d^2 and ln det S of a position.
    fn distance(&self, z: &[f64], sigma: f64) -> (f64, f64) {
        let [north, east] = variances(z[0], sigma);
        let (a, b, c) = (self.covariance[0] + north, self.covariance[1] + east, self.covariance[2]);
        let (y0, y1) = (z[0] - self.at[0], wrap_difference(z[1] - self.at[1]));
        // L D L' of a 2 x 2 matrix: no cancellation where one variance is far the larger.
        let slope = c / a;
        let rest = b - slope * c;
        let y1 = y1 - slope * y0;
        (y0 * y0 / a + y1 * y1 / rest, (a * rest).ln())
    }
}

/// Positions by band of latitude, then by longitude.
struct Bands {
    height: f64,
    sorted: Vec<(i64, f64, usize)>,
}

impl Bands {
    fn new(z: &[f64], places: &[Place]) -> Self {
        let mut heights: Vec<f64> = places.iter().map(|place| place.reach[0]).collect();
        let middle = heights.len() / 2;
        let height = match heights.as_mut_slice() {
            [] => 1.0,
            heights => *heights.select_nth_unstable_by(middle, f64::total_cmp).1,
        };
        let height = height.clamp(1e-6, 180.0);
        let mut sorted: Vec<(i64, f64, usize)> = z
            .chunks_exact(2)
            .enumerate()
            .map(|(i, z)| ((z[0] / height).floor() as i64, wrap_difference(z[1]), i))
            .collect();
        sorted.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        Self { height, sorted }
    }

    /// Calls `visit` with every position in the box of a track.
    fn visit(&self, place: &Place, mut visit: impl FnMut(usize)) {
        let ([latitude, longitude], [north, east]) = (place.at, place.reach);
        let first = ((latitude - north) / self.height).floor() as i64;
        let last = ((latitude + north) / self.height).floor() as i64;
        let mut rest = &self.sorted[self.sorted.partition_point(|entry| entry.0 < first)..];
        // Band by band of those that have positions, so that a huge box costs no more than all.
        while let Some(&(band, ..)) = rest.first().filter(|entry| entry.0 <= last) {
            let (row, after) = rest.split_at(rest.partition_point(|entry| entry.0 == band));
            rest = after;
            for (from, to) in segments(longitude, east) {
                let start = row.partition_point(|entry| entry.1 < from);
                row[start..].iter().take_while(|entry| entry.1 <= to).for_each(|e| visit(e.2));
            }
        }
    }
}

/// The segment of longitudes within `reach`, cut where it crosses the antimeridian.
fn segments(longitude: f64, reach: f64) -> [(f64, f64); 2] {
    let (none, all) = ((1.0, 0.0), (-180.0, 180.0));
    let (from, to) = (longitude - reach, longitude + reach);
    if reach >= 180.0 {
        [all, none]
    } else if from < -180.0 {
        [(-180.0, to), (from + 360.0, 180.0)]
    } else if to > 180.0 {
        [(from, 180.0), (-180.0, to - 360.0)]
    } else {
        [(from, to), none]
    }
}

fn check_positions(z: &[f64], sigmas: &[f64], gate: f64) -> Result<()> {
    if z.len() != 2 * sigmas.len() {
        let (argument, found, other) = ("z", z.len() / 2, "sigmas");
        let (expected, unit) = (sigmas.len(), "positions");
        return Err(Error::Length { argument, found, other, expected, unit });
    }
    if let Some(i) = z.iter().position(|v| !v.is_finite()) {
        return Err(Error::NotFinite { argument: "z", index: vec![i / 2, i % 2], value: z[i] });
    }
    let requirement = "positive and finite";
    if let Some(i) = sigmas.iter().position(|s| !(*s > 0.0 && s.is_finite())) {
        let value = sigmas[i];
        return Err(Error::Element { argument: "sigmas", index: vec![i], requirement, value });
    }
    if gate > 0.0 && gate.is_finite() {
        return Ok(());
    }
    Err(Error::Parameter { argument: "gate", requirement, value: gate })
}
