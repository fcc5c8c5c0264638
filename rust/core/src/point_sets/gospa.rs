//! The Generalised Optimal Sub-Pattern Assignment metric between two finite sets of points.
//!
//! For sets of m <= n points, order p, cutoff c and 0 < alpha <= 2,
//!
//! ```text
//! GOSPA = ( min over assignments  sum_i min(d_i, c)^p  +  c^p / alpha (n - m) )^(1/p)
//! ```
//!
//! and for alpha = 2, with the pairs of the assignment that are closer than c,
//!
//! ```text
//! GOSPA^p = sum over pairs d^p  +  c^p / 2 (missed + false)
//! ```
//!
//! Rahmathullah, Garcia-Fernandez and Svensson, "Generalized optimal sub-pattern assignment
//! metric", 20th International Conference on Information Fusion, 2017,
//! doi:10.23919/ICIF.2017.8009645, definition 1 and proposition 1.
//!
//! Parts are p-th powers that add up to GOSPA^p; they exist for alpha = 2 and are NaN otherwise.
//! Ties: see `pairs`.

use super::assignment_order;
use super::cost_source::{Distances, Euclidean, Sets};
use super::cutoff::Cutoff;
use super::results::{Gospa, Pair};
use super::workspace::{FRAMES_BETWEEN_CHECKS, Workspace, check_sequences, frames_per_piece};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::points::{Frames, Points};
use crate::{simd, threads};
use pulp::{Simd, WithSimd};

/// Order, cutoff and the price of a point too many, checked.
#[derive(Debug, Clone, Copy)]
struct Setting {
    cutoff: Cutoff,
    alpha: f64,
}

impl Setting {
    fn new(c: f64, p: f64, alpha: f64) -> Result<Self> {
        let refuse =
            |argument, requirement, value| Err(Error::Parameter { argument, requirement, value });
        if !(c > 0.0 && c < f64::INFINITY) {
            return refuse("c", "positive and finite", c);
        }
        if !(1.0..f64::INFINITY).contains(&p) {
            return refuse("p", "at least 1 and finite", p);
        }
        if !(alpha > 0.0 && alpha <= 2.0) {
            return refuse("alpha", "above 0 and at most 2", alpha);
        }
        Ok(Self { cutoff: Cutoff::new(c, p)?, alpha })
    }
}

/// GOSPA between the sets `x` (truth) and `y` (estimates), and its pairs.
///
/// # Errors
/// [`Error::Parameter`] for a parameter out of range, [`Error::Dimension`] for points of different
/// dimensions.
pub fn gospa(
    x: Points,
    y: Points,
    (c, p, alpha): (f64, f64, f64),
    work: &mut Workspace,
    pairs: &mut Vec<Pair>,
    interrupt: &Interrupt<'_>,
) -> Result<Gospa> {
    let setting = Setting::new(c, p, alpha)?;
    simd::dispatch(OneFrame { sets: Euclidean::new(x, y)?, setting, work, pairs, interrupt })
}

/// GOSPA of two sets whose distances are given, and its pairs.
///
/// # Errors
/// [`Error::Parameter`] for a parameter out of range.
pub fn gospa_from_distances(
    sets: Distances,
    (c, p, alpha): (f64, f64, f64),
    work: &mut Workspace,
    pairs: &mut Vec<Pair>,
    interrupt: &Interrupt<'_>,
) -> Result<Gospa> {
    let setting = Setting::new(c, p, alpha)?;
    simd::dispatch(OneFrame { sets, setting, work, pairs, interrupt })
}

/// GOSPA of every pair of sets of two sequences, into `output`.
///
/// # Errors
/// As [`gospa`], and [`Error::Length`] where the sequences are not equally long.
pub fn gospa_over_time(
    x: Frames,
    y: Frames,
    (c, p, alpha): (f64, f64, f64),
    output: &mut [Gospa],
    interrupt: &Interrupt<'_>,
) -> Result<()> {
    let setting = Setting::new(c, p, alpha)?;
    check_sequences(x, y)?;
    threads::fill(output, frames_per_piece(x, y), |first, output| {
        simd::dispatch(ManyFrames { x, y, first, setting, output, interrupt })
    })
}

struct OneFrame<'a, T> {
    sets: T,
    setting: Setting,
    work: &'a mut Workspace,
    pairs: &'a mut Vec<Pair>,
    interrupt: &'a Interrupt<'a>,
}

impl<T: Sets> WithSimd for OneFrame<'_, T> {
    type Output = Result<Gospa>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        of_frame(simd, self.sets, &self.setting, self.work, self.pairs, self.interrupt)
    }
}

struct ManyFrames<'a> {
    x: Frames<'a>,
    y: Frames<'a>,
    first: usize,
    setting: Setting,
    output: &'a mut [Gospa],
    interrupt: &'a Interrupt<'a>,
}

impl WithSimd for ManyFrames<'_> {
    type Output = Result<()>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let (mut work, mut pairs) = (Workspace::default(), Vec::new());
        for (t, output) in (self.first..).zip(self.output) {
            let sets = Euclidean { x: self.x.frame(t), y: self.y.frame(t) };
            if t.is_multiple_of(FRAMES_BETWEEN_CHECKS) {
                self.interrupt.check()?;
            }
            *output = of_frame(simd, sets, &self.setting, &mut work, &mut pairs, self.interrupt)?;
        }
        Ok(())
    }
}

#[inline(always)]
fn of_frame<S: Simd>(
    simd: S,
    sets: impl Sets,
    setting: &Setting,
    work: &mut Workspace,
    pairs: &mut Vec<Pair>,
    interrupt: &Interrupt<'_>,
) -> Result<Gospa> {
    let cutoff = &setting.cutoff;
    let localization = assignment_order::least_total(simd, sets, cutoff, work, pairs, interrupt)?;
    let (m, n) = sets.sizes();
    let (missed_count, false_count) = (m - pairs.len(), n - pairs.len());
    let parts = Gospa {
        distance: 0.0,
        localization,
        missed: times(missed_count as f64, cutoff.most() / 2.0),
        false_alarms: times(false_count as f64, cutoff.most() / 2.0),
        missed_count,
        false_count,
    };
    let far = m.min(n) - pairs.len();
    let alone = far as f64 + m.abs_diff(n) as f64 / setting.alpha;
    let distance = distance(sets, cutoff, pairs, localization, alone);
    Ok(if setting.alpha == 2.0 {
        Gospa { distance, ..parts }
    } else {
        let none = f64::NAN;
        Gospa { distance, localization: none, missed: none, false_alarms: none, ..parts }
    })
}

/// A count times a price, which may have overflowed: nothing costs nothing.
#[inline(always)]
fn times(count: f64, price: f64) -> f64 {
    if count == 0.0 { 0.0 } else { count * price }
}

/// The p-th root of the total, `alone` being in units of c^p.
#[inline(always)]
fn distance(
    sets: impl Sets,
    cutoff: &Cutoff,
    pairs: &[Pair],
    localization: f64,
    alone: f64,
) -> f64 {
    let total = localization + times(alone, cutoff.most());
    let is_exact = cutoff.has_square() && (1e-250..=1e250).contains(&total);
    if is_exact { cutoff.root(total) } else { scaled_distance(sets, cutoff, pairs, alone) }
}

/// The same in units of the largest distance that counts.
#[cold]
fn scaled_distance(sets: impl Sets, cutoff: &Cutoff, pairs: &[Pair], alone: f64) -> f64 {
    let distances = || pairs.iter().map(|&(i, j)| sets.distance(i, j));
    let least = if alone > 0.0 { cutoff.c() } else { 0.0 };
    let unit = distances().fold(least, f64::max);
    if unit == 0.0 {
        return 0.0;
    }
    let sum: f64 = distances().map(|d| (d / unit).powf(cutoff.p())).sum();
    unit * (sum + times(alone, (cutoff.c() / unit).powf(cutoff.p()))).powf(1.0 / cutoff.p())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_pair_one_missed_two_false() {
        let x = Points::new("X", &[0.0, 10.0], 1).unwrap();
        let y = Points::new("Y", &[3.0, 30.0, 50.0], 1).unwrap();
        let mut pairs = Vec::new();
        let result = gospa(
            x,
            y,
            (5.0, 2.0, 2.0),
            &mut Workspace::default(),
            &mut pairs,
            &Interrupt::never(),
        )
        .unwrap();
        assert_eq!(pairs, [(0, 0)]);
        assert_eq!((result.missed_count, result.false_count), (1, 2));
        assert_eq!((result.localization, result.missed, result.false_alarms), (9.0, 12.5, 25.0));
        assert_eq!(result.distance, 46.5f64.sqrt());
    }
}
