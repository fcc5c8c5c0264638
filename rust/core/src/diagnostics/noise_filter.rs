//! The recursion behind `noise_likelihood`, compiled for fixed sizes.
//!
//! States and components are padded with zeros to the next size that was compiled: padded states
//! neither move nor are seen, padded and missing components have H = 0 and the variance 1, so that
//! neither changes the likelihood. All work after the factor of S = L L' is in the coordinates that
//! it whitens, in which S is an identity: with the H and R of these coordinates, G = C H', and for
//! the derivative of anything by factor i an index,
//!
//! - S_i = H C_i H' + c_i R, d_i = -H m_i;
//! - C <- C - G G', C_i <- C_i - G Z_i - (G Z_i)', Z_i = H C_i - S_i G' / 2;
//! - m <- m + G d, m_i <- m_i + C_i H' d + G (d_i - S_i d).

#![allow(clippy::needless_range_loop, reason = "an index is shared by several matrices")]

use super::fixed::{
    Matrix, add_scaled, apply, congruence, dot, dot_first, load, product, product_transposed,
    scaled, subtract,
};
use super::gamma::{LN_TWO_PI, ln_gamma};
use super::noise_log::{NoiseFactors, NoiseLog};
use crate::error::{Error, Result};
use crate::simd;
use pulp::{Simd, WithSimd};

/// What one track gives.
#[derive(Debug, Clone, Default)]
pub(super) struct Track {
    pub(super) densities: Vec<f64>,
    pub(super) gradient: Vec<f64>,
    pub(super) information: Vec<f64>,
    pub(super) whitened: Vec<f64>,
    pub(super) mean: Vec<f64>,
    pub(super) covariance: Vec<f64>,
}

/// The likelihood of one track, by the smallest compiled size that holds it.
pub(super) fn filter(
    log: &NoiseLog<'_>,
    factors: &NoiseFactors<'_>,
    derivatives: bool,
    track: usize,
) -> Result<Track> {
    macro_rules! sized {
        ($($n:literal: $($m:literal)+;)+) => {
            match (log.states, log.components) {
                $($((..=$n, ..=$m) => {
                    simd::dispatch(Run::<$n, $m> { log, factors, derivatives, track })
                })+)+
                _ => Run::<64, 64> { log, factors, derivatives, track }.run(),
            }
        };
    }
    sized!(2: 1 2 4; 4: 1 2 4; 6: 1 2 4; 9: 1 2 4; 16: 4 16; 32: 16;)
}

struct Run<'a, const N: usize, const M: usize> {
    log: &'a NoiseLog<'a>,
    factors: &'a NoiseFactors<'a>,
    derivatives: bool,
    track: usize,
}

impl<const N: usize, const M: usize> WithSimd for Run<'_, N, M> {
    type Output = Result<Track>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Self::Output {
        self.run()
    }
}

/// Mean and covariance of the prediction error, and their derivatives.
struct Belief<const N: usize> {
    mean: [f64; N],
    covariance: Matrix<N, N>,
    means: Vec<[f64; N]>,
    covariances: Vec<Matrix<N, N>>,
}

/// An update in whitened coordinates.
struct Innovation<const N: usize, const M: usize> {
    d: [f64; M],
    h: Matrix<M, N>,
    r: Matrix<M, M>,
    log_determinant: f64,
}

/// H and R of an update without what is missing, and how many components are there.
struct Update<const N: usize, const M: usize> {
    d: [f64; M],
    h: Matrix<M, N>,
    r: Matrix<M, M>,
    absent: [f64; M],
    count: usize,
}

/// Derivatives of an innovation and of its covariance by each factor.
type Slopes<const M: usize> = Vec<([f64; M], Matrix<M, M>)>;

impl<const N: usize, const M: usize> Run<'_, N, M> {
    #[inline(always)]
    fn run(&self) -> Result<Track> {
        let log = self.log;
        let (n, m) = (log.states, log.components);
        let rows = log.starts[self.track] as usize..log.starts[self.track + 1] as usize;
        let count = if self.derivatives { self.factors.count() } else { 0 };
        let mut track = Track {
            gradient: vec![0.0; count],
            information: vec![0.0; count * count],
            whitened: vec![0.0; rows.len() * m],
            densities: vec![0.0; rows.len()],
            ..Track::default()
        };
        let mut belief = self.start(count);
        let mut slopes: Slopes<M> = vec![([0.0; M], [[0.0; M]; M]); count];
        for k in rows.clone() {
            if k > rows.start {
                self.predict(&mut belief, k);
            }
            let update = self.update(&belief, k);
            if update.count > 0 {
                let kind = log.types[k] as usize;
                let r = self.factors.measurement[kind];
                let seen = innovation(&belief, &update, r).map_err(|minor| {
                    let argument = "innovation covariances";
                    Error::NotPositiveDefinite { argument, index: vec![k], minor }
                })?;
                let own = log.groups + kind;
                differentiate(&belief, &seen, own, &mut slopes);
                let (density, weight) = self.density(dot(&seen.d, &seen.d), update.count);
                track.densities[k - rows.start] = density - 0.5 * seen.log_determinant;
                add(&seen, weight, &slopes, &mut track);
                let row = (k - rows.start) * m;
                track.whitened[row..row + m].copy_from_slice(&seen.d[..m]);
                self.condition(&mut belief, &update, seen, weight, own, &mut slopes);
            }
            if k + 1 == rows.end {
                track.mean = belief.mean[..n].to_vec();
                let row = |row: &[f64; N]| row[..n].to_vec();
                track.covariance = belief.covariance[..n].iter().flat_map(row).collect();
            }
            let correction = &log.corrections[k * n..(k + 1) * n];
            belief.mean.iter_mut().zip(correction).for_each(|(m, c)| *m -= c);
        }
        if rows.is_empty() {
            track.mean = vec![0.0; n];
            let initial = &log.initial[self.track * n * n..(self.track + 1) * n * n];
            track.covariance = initial.iter().map(|c| c * self.factors.initial).collect();
        }
        Ok(track)
    }

    #[inline(always)]
    fn start(&self, count: usize) -> Belief<N> {
        let n = self.log.states;
        let claimed: Matrix<N, N> = load(&self.log.initial[self.track * n * n..], n, n);
        let mut covariances = vec![[[0.0; N]; N]; count];
        if let Some(last) = covariances.last_mut() {
            *last = claimed;
        }
        let covariance = scaled(&claimed, self.factors.initial);
        Belief { mean: [0.0; N], covariance, means: vec![[0.0; N]; count], covariances }
    }

    #[inline(always)]
    fn predict(&self, belief: &mut Belief<N>, k: usize) {
        let (n, groups) = (self.log.states, self.log.groups);
        let f: Matrix<N, N> = load(&self.log.transitions[k * n * n..], n, n);
        belief.mean = apply(&f, &belief.mean);
        belief.covariance = congruence(&f, &belief.covariance);
        for mean in &mut belief.means {
            *mean = apply(&f, mean);
        }
        for covariance in &mut belief.covariances {
            *covariance = congruence(&f, covariance);
        }
        for (g, &q) in self.factors.process.iter().enumerate() {
            let noise: Matrix<N, N> =
                load(&self.log.process_noises[(k * groups + g) * n * n..], n, n);
            add_scaled(&mut belief.covariance, &noise, q);
            if let Some(slope) = belief.covariances.get_mut(g) {
                add_scaled(slope, &noise, 1.0);
            }
        }
    }

    #[inline(always)]
    fn update(&self, belief: &Belief<N>, k: usize) -> Update<N, M> {
        let (n, m) = (self.log.states, self.log.components);
        let mut h: Matrix<M, N> = load(&self.log.observations[k * m * n..], m, n);
        let mut r: Matrix<M, M> = load(&self.log.measurement_noises[k * m * m..], m, m);
        let (mut d, mut absent, mut count) = ([0.0; M], [1.0; M], 0);
        for i in 0..m {
            let value = self.log.innovations[k * m + i];
            if value.is_nan() {
                continue;
            }
            (absent[i], count) = (0.0, count + 1);
            d[i] = value - dot(&h[i], &belief.mean);
            let period = self.log.periods[k * m + i];
            if !period.is_nan() {
                d[i] -= period * (d[i] / period - 0.5).ceil();
            }
        }
        for i in 0..m {
            if absent[i] > 0.0 {
                (h[i], r[i]) = ([0.0; N], [0.0; M]);
                r.iter_mut().for_each(|row| row[i] = 0.0);
            }
        }
        Update { d, h, r, absent, count }
    }

    /// The log-density of a squared innovation but for its determinant, and its weight.
    #[inline(always)]
    fn density(&self, squared: f64, count: usize) -> (f64, f64) {
        let (v, p) = (self.factors.tail_dof, count as f64);
        if v.is_infinite() {
            return (-0.5 * (squared + p * LN_TWO_PI), 1.0);
        }
        let scale = self.factors.tail_scales[count];
        let constant = ln_gamma(0.5 * (v + p))
            - ln_gamma(0.5 * v)
            - 0.5 * p * (v * std::f64::consts::PI / scale).ln();
        let density = constant - 0.5 * (v + p) * (scale * squared / v).ln_1p();
        (density, scale * (v + p) / (v + scale * squared))
    }

    /// Conditions the belief on an innovation; where its weight is below 1, with R over the weight.
    #[inline(always)]
    fn condition(
        &self,
        belief: &mut Belief<N>,
        update: &Update<N, M>,
        seen: Innovation<N, M>,
        weight: f64,
        own: usize,
        slopes: &mut Slopes<M>,
    ) {
        if weight >= 1.0 {
            return condition(belief, &seen, slopes);
        }
        let (v, p) = (self.factors.tail_dof, update.count as f64);
        let r = self.factors.measurement[own - self.log.groups];
        // The weight falls by W^2 / (v + p) for each unit that d' d rises.
        let falls: Vec<f64> = slopes
            .iter()
            .map(|(d_i, s_i)| -weight * weight * fall(&seen.d, d_i, s_i) / (v + p))
            .collect();
        let Ok(weighted) = innovation(belief, update, r / weight) else {
            return condition(belief, &seen, slopes);
        };
        differentiate(belief, &weighted, usize::MAX, slopes);
        for (i, ((_, s_i), dw)) in slopes.iter_mut().zip(&falls).enumerate() {
            let one = if i == own { 1.0 / weight } else { 0.0 };
            add_scaled(s_i, &weighted.r, one - r * dw / (weight * weight));
        }
        condition(belief, &weighted, slopes);
    }
}

/// Adds the derivatives of the log-density of an innovation of this weight.
#[inline(always)]
fn add<const N: usize, const M: usize>(
    seen: &Innovation<N, M>,
    weight: f64,
    slopes: &Slopes<M>,
    track: &mut Track,
) {
    let parameters = slopes.len();
    for (i, (d_i, s_i)) in slopes.iter().enumerate() {
        let trace: f64 = (0..M).map(|a| s_i[a][a]).sum();
        track.gradient[i] -= 0.5 * (weight * fall(&seen.d, d_i, s_i) + trace);
        for (j, (d_j, s_j)) in slopes[..=i].iter().enumerate() {
            let shared: f64 = (0..M).map(|a| dot(&s_i[a], &s_j[a])).sum();
            let information = 0.5 * shared + dot(d_i, d_j);
            track.information[i * parameters + j] += information;
            if i != j {
                track.information[j * parameters + i] += information;
            }
        }
    }
}

/// The derivative of d' d (whitened) by a factor: 2 d' d_i - d' S_i d.
#[inline(always)]
fn fall<const M: usize>(d: &[f64; M], d_i: &[f64; M], s_i: &Matrix<M, M>) -> f64 {
    2.0 * dot(d, d_i) - dot(d, &apply(s_i, d))
}

/// Whitens an update by S = H C H' + r R; the size of the first bad leading minor otherwise.
#[inline(always)]
fn innovation<const N: usize, const M: usize>(
    belief: &Belief<N>,
    update: &Update<N, M>,
    r: f64,
) -> std::result::Result<Innovation<N, M>, usize> {
    let mut s = product_transposed(&product(&update.h, &belief.covariance), &update.h);
    add_scaled(&mut s, &update.r, r);
    for i in 0..M {
        s[i][i] += update.absent[i];
    }
    let mut seen = Innovation { d: update.d, h: update.h, r: update.r, log_determinant: 0.0 };
    let mut determinant = 1.0;
    for j in 0..M {
        let pivot = s[j][j] - dot_first(&s[j], &s[j], j);
        if pivot <= 0.0 || pivot.is_nan() {
            return Err(j + 1);
        }
        let root = pivot.sqrt();
        s[j][j] = root;
        determinant *= pivot;
        // One logarithm for a few pivots: their product stays in range.
        if j % 4 == 3 || j + 1 == M {
            seen.log_determinant += determinant.ln();
            determinant = 1.0;
        }
        for i in j + 1..M {
            s[i][j] = (s[i][j] - dot_first(&s[i], &s[j], j)) / root;
        }
    }
    for i in 0..M {
        for j in 0..i {
            seen.d[i] -= s[i][j] * seen.d[j];
            subtract(&mut seen.h, i, j, s[i][j]);
            subtract(&mut seen.r, i, j, s[i][j]);
        }
        let inverse = 1.0 / s[i][i];
        seen.d[i] *= inverse;
        seen.h[i].iter_mut().for_each(|h| *h *= inverse);
        seen.r[i].iter_mut().for_each(|r| *r *= inverse);
    }
    // And R from the right.
    for row in &mut seen.r {
        for i in 0..M {
            row[i] = (row[i] - dot_first(row, &s[i], i)) / s[i][i];
        }
    }
    Ok(seen)
}

/// Derivatives of an innovation and its covariance; `own` is the factor of its R.
#[inline(always)]
fn differentiate<const N: usize, const M: usize>(
    belief: &Belief<N>,
    seen: &Innovation<N, M>,
    own: usize,
    slopes: &mut Slopes<M>,
) {
    let parts = belief.means.iter().zip(&belief.covariances);
    for (i, ((mean, covariance), slope)) in parts.zip(slopes).enumerate() {
        slope.0 = apply(&seen.h, mean).map(|x| -x);
        slope.1 = product_transposed(&product(&seen.h, covariance), &seen.h);
        if i == own {
            add_scaled(&mut slope.1, &seen.r, 1.0);
        }
    }
}

/// Conditions the belief on an innovation.
#[inline(always)]
fn condition<const N: usize, const M: usize>(
    belief: &mut Belief<N>,
    seen: &Innovation<N, M>,
    slopes: &Slopes<M>,
) {
    let gain = product(&seen.h, &belief.covariance); // G'
    let parts = belief.means.iter_mut().zip(&mut belief.covariances);
    for ((mean, covariance), (d_i, s_i)) in parts.zip(slopes) {
        let seen_slope = product(&seen.h, covariance);
        let mut z = product(s_i, &gain);
        for a in 0..M {
            for b in 0..N {
                z[a][b] = seen_slope[a][b] - 0.5 * z[a][b];
            }
        }
        let pull = apply(s_i, &seen.d);
        for a in 0..M {
            for b in 0..N {
                mean[b] += seen_slope[a][b] * seen.d[a] + gain[a][b] * (d_i[a] - pull[a]);
            }
        }
        for a in 0..M {
            for i in 0..N {
                for j in 0..N {
                    covariance[i][j] -= gain[a][i] * z[a][j] + z[a][i] * gain[a][j];
                }
            }
        }
    }
    for a in 0..M {
        for i in 0..N {
            belief.mean[i] += gain[a][i] * seen.d[a];
            for j in 0..N {
                belief.covariance[i][j] -= gain[a][i] * gain[a][j];
            }
        }
    }
}
