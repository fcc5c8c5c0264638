//! The constant-turn-rate motion of a vessel on the local plane: state, Jacobian, process noise.
//!
//! State x = (latitude deg, longitude deg, speed kt, course deg from north, turn rate deg/s). Over a
//! time t, with k = metres per second in a knot, r = radians in a degree, the turned angle 2 h,
//!
//! h = turn r t / 2, a = course r + h, L = k speed t, S = sin h / h,
//! north = L S cos a, east = L S sin a
//!
//! in metres: the chord of the arc, without a branch where the turn rate is zero. Latitude and
//! longitude move by north / m_N(latitude) and east / m_E(mid-latitude). A turn rate that decays
//! with time constant tau turns by T = tau (1 - exp(-t / tau)) instead of t, and the mean heading is
//! that after M = tau (1 - T / t) instead of t / 2: h = turn r T / 2, a = course r + turn r M.
//!
//! Process noise (continuous, of densities q_a along the track, q_w on the turn rate, q_c on the
//! course) is the integral of the straight-line linearisation: with f(u) the response, after a time
//! u, of (cross-track metres, course, turn rate) to a kick of the turn rate,
//! f = (v g2(u), g1(u), g0(u)), Q = q_w int_0^t f f' du: in closed form for a constant turn rate
//! (g0 = 1, g1 = u, g2 = u^2/2; Bar-Shalom, Li and Kirubarajan, *Estimation with Applications to
//! Tracking and Navigation*, 2001, section 6.2, doi:10.1002/0471221279), by Gauss-Legendre
//! quadrature, exact to rounding, where it decays. Long times are cut into pieces, over each of
//! which the linearisation is fair.

use super::earth::{Degree, KNOT, RADIAN, degree, wrap_course, wrap_difference};
use nalgebra::{SMatrix, SVector};

/// How many states.
pub const STATES: usize = 5;

/// Latitude, longitude, speed, course, turn rate.
pub type State = SVector<f64, STATES>;
/// A covariance or a Jacobian of the state.
pub type Matrix = SMatrix<f64, STATES, STATES>;

/// Longest time, in seconds, over which the noise of a straight line is added in one piece.
const LONGEST_PIECE: f64 = 600.0;

/// How a vessel is expected to move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Density of the acceleration along the track, m^2/s^3.
    pub acceleration: f64,
    /// Density of the turn acceleration, (deg/s)^2/s.
    pub turn: f64,
    /// Density of a random walk of the course, deg^2/s.
    pub course: f64,
    /// Time constant, in seconds, with which a turn rate decays; infinite for a constant one.
    pub decay: f64,
}

/// A state carried forward.
#[derive(Debug, Clone, Copy)]
pub struct Prediction {
    /// The state.
    pub x: State,
    /// Its covariance.
    pub p: Matrix,
    /// The Jacobian of the state with respect to the one it came from.
    pub f: Matrix,
}

impl Motion {
    /// Carries a state and its covariance forward by `time` seconds.
    pub fn predict(&self, x: &State, p: &Matrix, time: f64) -> Prediction {
        let mut at = Prediction { x: *x, p: *p, f: Matrix::identity() };
        let pieces = self.pieces(time);
        let piece = time / pieces as f64;
        for _ in 0..pieces {
            let (arc, q) = (Arc::new(&at.x, piece, self.decay), self.noise(&at.x, piece));
            let f = arc.jacobian();
            at = Prediction { x: arc.end(&at.x), p: f * at.p * f.transpose() + q, f: f * at.f };
        }
        at.p = (at.p + at.p.transpose()) * 0.5;
        at
    }

    /// The state after `time` seconds without noise.
    pub fn advance(&self, x: &State, time: f64) -> State {
        let pieces = self.pieces(time);
        let piece = time / pieces as f64;
        (0..pieces).fold(*x, |x, _| Arc::new(&x, piece, self.decay).end(&x))
    }

    /// Into how many pieces a time is cut: none longer than [`LONGEST_PIECE`] or the quarter of the
    /// time constant, in which the turn rate changes too much for one chord.
    fn pieces(&self, time: f64) -> usize {
        let longest = LONGEST_PIECE.min(self.decay / 4.0);
        // A bound for absurd settings; a track is deleted long before.
        (time / longest).ceil().clamp(1.0, 1e4) as usize
    }

    /// The covariance that the noise adds over `time` seconds, in one piece.
    pub fn noise(&self, x: &State, time: f64) -> Matrix {
        let (t, v, a) = (time, x[2] * KNOT, self.acceleration);
        let [xx, xc, xw, cc, cw, ww] = self.turning(t);
        let (q, c) = (self.turn * RADIAN * RADIAN, self.course * RADIAN * RADIAN);
        let along = a * t * t * t / 3.0;
        let along_speed = a * t * t / 2.0;
        let across = v * v * (q * xx + c * t * t * t / 3.0);
        let across_course = v * (q * xc + c * t * t / 2.0);
        let across_rate = v * q * xw;
        let [ahead, right] = directions(x, t, self.decay);
        let mut noise = Matrix::zeros();
        for i in 0..2 {
            for j in i..2 {
                noise[(i, j)] = ahead[i] * ahead[j] * along + right[i] * right[j] * across;
            }
            noise[(i, 2)] = ahead[i] * along_speed / KNOT;
            noise[(i, 3)] = right[i] * across_course / RADIAN;
            noise[(i, 4)] = right[i] * across_rate / RADIAN;
        }
        noise[(2, 2)] = a * t / (KNOT * KNOT);
        noise[(3, 3)] = self.turn * cc + self.course * t;
        noise[(3, 4)] = self.turn * cw;
        noise[(4, 4)] = self.turn * ww;
        noise.fill_lower_triangle_with_upper_triangle();
        noise
    }

    /// The integrals of g2 g2, g2 g1, g2 g0, g1 g1, g1 g0, g0 g0 over `time`.
    fn turning(&self, time: f64) -> [f64; 6] {
        let t = time;
        if self.decay.is_infinite() {
            let (t2, t3) = (t * t, t * t * t);
            return [t2 * t3 / 20.0, t2 * t2 / 8.0, t3 / 6.0, t3 / 3.0, t2 / 2.0, t];
        }
        let mut integrals = [0.0; 6];
        for (node, weight) in NODES.into_iter().zip(WEIGHTS) {
            let [g0, g1, g2] = response(node * t, self.decay);
            let products = [g2 * g2, g2 * g1, g2 * g0, g1 * g1, g1 * g0, g0 * g0];
            for (integral, product) in integrals.iter_mut().zip(products) {
                *integral += weight * t * product;
            }
        }
        integrals
    }
}

/// Nodes of the Gauss-Legendre quadrature of order 5 on [0, 1] (Abramowitz and Stegun, table 25.4).
const NODES: [f64; 5] =
    [0.046910077030668004, 0.23076534494715845, 0.5, 0.7692346550528415, 0.953089922969332];
/// Its weights.
const WEIGHTS: [f64; 5] = [
    0.11846344252809454,
    0.23931433524968324,
    0.28444444444444444,
    0.23931433524968324,
    0.11846344252809454,
];

/// Turn rate, course and the integral of the course, a time `u` after a kick of the turn rate.
fn response(u: f64, decay: f64) -> [f64; 3] {
    [(-u / decay).exp(), turned_time(u, decay), u * mean_time(u, decay)]
}

/// The time for which a constant turn rate would turn as far.
#[inline]
fn turned_time(time: f64, decay: f64) -> f64 {
    if decay.is_infinite() { time } else { -decay * (-time / decay).exp_m1() }
}

/// The time after which the heading is the mean heading.
#[inline]
fn mean_time(time: f64, decay: f64) -> f64 {
    let r = time / decay;
    if decay.is_infinite() {
        0.5 * time
    } else if r < 1e-3 {
        // 1 - T / t loses its digits here: its series.
        time * (0.5 - r / 6.0 + r * r / 24.0)
    } else {
        decay * (1.0 - turned_time(time, decay) / time)
    }
}

/// Degrees of latitude and longitude in a metre along the chord, and in one to its right.
fn directions(x: &State, time: f64, decay: f64) -> [[f64; 2]; 2] {
    let (sin, cos) = ((x[3] + x[4] * mean_time(time, decay)) * RADIAN).sin_cos();
    let Degree { north, east, .. } = degree(x[0]);
    [[cos / north, sin / east], [-sin / north, cos / east]]
}

/// The arc of one step.
struct Arc {
    turned: f64,
    mean: f64,
    remaining: f64,
    sin: f64,
    cos: f64,
    /// L S in metres, and its derivatives by speed and by h.
    chord: f64,
    chord_by_speed: f64,
    chord_by_half: f64,
    start: Degree,
    middle: Degree,
    north: f64,
    east: f64,
}

impl Arc {
    #[inline]
    fn new(x: &State, time: f64, decay: f64) -> Self {
        let turned = turned_time(time, decay);
        let mean = mean_time(time, decay);
        let (sin, cos) = ((x[3] + x[4] * mean) * RADIAN).sin_cos();
        let (s, slope) = sinc(0.5 * x[4] * RADIAN * turned);
        let chord_by_speed = KNOT * time * s;
        let chord = chord_by_speed * x[2];
        let start = degree(x[0]);
        let north = chord * cos / start.north;
        let middle = degree(x[0] + 0.5 * north);
        Self {
            turned,
            mean,
            remaining: if decay.is_infinite() { 1.0 } else { (-time / decay).exp() },
            sin,
            cos,
            chord,
            chord_by_speed,
            chord_by_half: KNOT * time * x[2] * slope,
            start,
            middle,
            north,
            east: chord * sin / middle.east,
        }
    }

    #[inline]
    fn end(&self, x: &State) -> State {
        State::new(
            x[0] + self.north,
            wrap_difference(x[1] + self.east),
            x[2],
            wrap_course(x[3] + x[4] * self.turned),
            x[4] * self.remaining,
        )
    }

    /// Rows of latitude and longitude by the chain rule; `middle` depends on the latitude's change.
    #[inline]
    fn jacobian(&self) -> Matrix {
        let (half, mean) = (0.5 * self.turned * RADIAN, self.mean * RADIAN);
        let (sin, cos, chord) = (self.sin, self.cos, self.chord);
        let north = [
            self.chord_by_speed * cos,
            -chord * sin * RADIAN,
            self.chord_by_half * cos * half - chord * sin * mean,
        ];
        let east = [
            self.chord_by_speed * sin,
            chord * cos * RADIAN,
            self.chord_by_half * sin * half + chord * cos * mean,
        ];
        let mut f = Matrix::identity();
        f[(0, 0)] = 1.0 - self.north * self.start.north_slope / self.start.north;
        let by_middle = -self.east * self.middle.east_slope / self.middle.east;
        f[(1, 0)] = by_middle * 0.5 * (1.0 + f[(0, 0)]);
        for i in 0..3 {
            f[(0, i + 2)] = north[i] / self.start.north;
            f[(1, i + 2)] = east[i] / self.middle.east + by_middle * 0.5 * f[(0, i + 2)];
        }
        f[(3, 4)] = self.turned;
        f[(4, 4)] = self.remaining;
        f
    }
}

/// sin h / h and its derivative.
#[inline]
fn sinc(h: f64) -> (f64, f64) {
    if h.abs() < 1e-2 {
        let h2 = h * h;
        return (
            1.0 - h2 / 6.0 * (1.0 - h2 / 20.0 * (1.0 - h2 / 42.0)),
            -h / 3.0 * (1.0 - h2 / 10.0 * (1.0 - h2 / 28.0)),
        );
    }
    let (sin, cos) = h.sin_cos();
    (sin / h, (h * cos - sin) / (h * h))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const CONSTANT: Motion =
        Motion { acceleration: 1e-3, turn: 1e-7, course: 1e-6, decay: f64::INFINITY };

    fn states() -> impl Strategy<Value = State> {
        (-85.0..85.0, -180.0..180.0, 0.0..40.0, 0.0..360.0, -1.0..1.0)
            .prop_map(|(lat, lon, sog, cog, rate)| State::new(lat, lon, sog, cog, rate))
    }

    /// Difference of two states, angles wrapped.
    fn difference(a: &State, b: &State) -> State {
        let mut d = a - b;
        d[1] = wrap_difference(d[1]);
        d[3] = wrap_difference(d[3]);
        d
    }

    proptest! {
        #[test]
        fn the_jacobian_is_that_of_central_differences(
            x in states(), time in 0.1f64..300.0, decay in prop_oneof![Just(f64::INFINITY), 50.0..5000.0]
        ) {
            let motion = Motion { decay, ..CONSTANT };
            let f = motion.predict(&x, &Matrix::zeros(), time).f;
            for j in 0..STATES {
                let h = [1e-4, 1e-3, 1e-3, 1e-3, 1e-5][j];
                let (mut above, mut below) = (x, x);
                above[j] += h;
                below[j] -= h;
                let column =
                    difference(&motion.advance(&above, time), &motion.advance(&below, time)) / (2.0 * h);
                // A degree of latitude is 60 nautical miles: rows in comparable units.
                for i in 0..STATES {
                    let unit = if i < 2 { 1.0 / 60.0 } else { 1.0 };
                    let error = (column[i] - f[(i, j)]).abs();
                    let size = column[i].abs().max(unit * 1e-2);
                    prop_assert!(error <= 2e-5 * size, "{i} {j}: {} {}", column[i], f[(i, j)]);
                }
            }
        }

        #[test]
        fn noise_over_two_halves_is_noise_over_the_whole(x in states(), time in 1.0f64..200.0) {
            // On a straight line the closed form is exact, so that its pieces add up.
            let x = State::new(x[0] * 0.5, x[1], x[2], x[3], 0.0);
            for decay in [f64::INFINITY, 1000.0] {
                let motion = Motion { decay, ..CONSTANT };
                let whole = motion.noise(&x, time);
                let half = motion.noise(&x, time / 2.0);
                let f = Arc::new(&x, time / 2.0, decay).jacobian();
                let both = f * half * f.transpose() + half;
                for i in 0..STATES {
                    let scale = whole[(i, i)].sqrt();
                    for j in 0..STATES {
                        let size = scale * whole[(j, j)].sqrt();
                        let error = (both[(i, j)] - whole[(i, j)]).abs();
                        prop_assert!(error <= 2e-3 * size + 1e-30, "{i} {j} {decay}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_slow_decay_is_no_decay() {
        let x = State::new(50.0, -1.0, 12.0, 30.0, 0.01);
        let slow = Motion { decay: 1e12, ..CONSTANT };
        let (a, b) = (slow.noise(&x, 100.0), CONSTANT.noise(&x, 100.0));
        assert!((a - b).abs().iter().zip(b.iter()).all(|(e, size)| *e <= 1e-9 * size.abs()));
        assert!((slow.advance(&x, 100.0) - CONSTANT.advance(&x, 100.0)).norm() < 1e-9);
    }

    #[test]
    fn a_full_circle_ends_where_it_began() {
        let x = State::new(60.0, 5.0, 10.0, 0.0, 1.0);
        let end = CONSTANT.advance(&x, 360.0);
        assert!((end[0] - x[0]).abs() < 1e-9 && (end[1] - x[1]).abs() < 1e-9);
        // Half of it is a diameter of 2 v / w to starboard, in metres.
        let half = CONSTANT.advance(&x, 180.0);
        let across = (half[1] - x[1]) * degree(60.0).east;
        assert!((across - 2.0 * 10.0 * KNOT / RADIAN).abs() < 0.1, "{across}");
    }
}
