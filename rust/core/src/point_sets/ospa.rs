//! The Optimal Sub-Pattern Assignment distance between two finite sets of points.
//!
//! For sets of m <= n points, order p and cutoff c, with d the Euclidean distance,
//!
//! ```text
//! OSPA = ( ( min over assignments  sum_i min(d_i, c)^p  +  c^p (n - m) ) / n )^(1/p)
//! ```
//!
//! Schuhmacher, Vo and Vo, "A consistent metric for performance evaluation of multi-object
//! filters", IEEE Trans. Signal Processing 56(8), 2008, doi:10.1109/TSP.2008.920469, equations 3
//! and 4.
//!
//! Two empty sets are at distance 0; an empty and a non-empty one at distance c. With `p`
//! infinite the sum is a maximum, and the distance is c where cardinalities differ. With `c`
//! infinite the distance is infinite where cardinalities differ. Orders below 1 are computed, but
//! do not give a metric.
//!
//! Cost: O(m n) where no two points want the same partner, O(m^2 n) at worst.

use super::cost_source::{Distances, Euclidean, Sets};
use super::cutoff::Cutoff;
use super::results::{Ospa, Pair};
use super::workspace::{FRAMES_BETWEEN_CHECKS, Workspace, check_sequences, frames_per_piece};
use super::{assignment_order, gated_matching, scaled_ospa, sparse_matching, tiny};
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::points::{Frames, Points};
use crate::{simd, threads};
use pulp::{Simd, WithSimd};
use std::ops::RangeInclusive;

/// OSPA of order `p` and cutoff `c` between two sets.
///
/// # Errors
/// [`Error::Parameter`](crate::Error::Parameter) for a cutoff or an order that is not positive,
/// [`Error::Dimension`](crate::Error::Dimension) for points of different dimensions,
/// [`Error::Memory`](crate::Error::Memory) for sets too large,
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn ospa(
    x: Points,
    y: Points,
    c: f64,
    p: f64,
    work: &mut Workspace,
    interrupt: &Interrupt<'_>,
) -> Result<Ospa> {
    let cutoff = Cutoff::new(c, p)?;
    let sets = Euclidean::new(x, y)?;
    if x.len().max(y.len()) <= tiny::LARGEST {
        return of_frame(pulp::Scalar::new(), sets, &cutoff, work, interrupt);
    }
    simd::dispatch(OneFrame { sets, cutoff: &cutoff, work, interrupt })
}

/// OSPA of two sets whose distances are given.
///
/// # Errors
/// [`Error::Parameter`](crate::Error::Parameter) for a cutoff or an order that is not positive.
pub fn ospa_from_distances(
    distances: Distances,
    c: f64,
    p: f64,
    work: &mut Workspace,
    interrupt: &Interrupt<'_>,
) -> Result<Ospa> {
    let cutoff = &Cutoff::new(c, p)?;
    simd::dispatch(OneFrame { sets: distances, cutoff, work, interrupt })
}

/// The pairs of OSPA that are closer than the cutoff, in the order of `x`.
///
/// # Errors
/// As [`ospa`].
pub fn ospa_assignment(
    x: Points,
    y: Points,
    c: f64,
    p: f64,
    work: &mut Workspace,
    interrupt: &Interrupt<'_>,
) -> Result<Vec<Pair>> {
    let cutoff = &Cutoff::new(c, p)?;
    let (sets, mut pairs) = (Euclidean::new(x, y)?, Vec::new());
    if p == f64::INFINITY {
        assignment_order::bottleneck(sets, cutoff, &mut pairs, interrupt)?;
    } else {
        simd::dispatch(Assign { sets, cutoff, work, pairs: &mut pairs, interrupt })?;
    }
    Ok(pairs)
}

/// OSPA of every pair of sets of two sequences, into `output`.
///
/// # Errors
/// As [`ospa`], and [`Error::Length`](crate::Error::Length) where the sequences are not equally
/// long.
pub fn ospa_over_time(
    x: Frames,
    y: Frames,
    c: f64,
    p: f64,
    output: &mut [f64],
    interrupt: &Interrupt<'_>,
) -> Result<()> {
    let cutoff = Cutoff::new(c, p)?;
    check_sequences(x, y)?;
    debug_assert_eq!(output.len(), x.len());
    threads::fill(output, frames_per_piece(x, y), |first, output| {
        simd::dispatch(ManyFrames { x, y, first, cutoff: &cutoff, output, interrupt })
    })
}

struct OneFrame<'a, T> {
    sets: T,
    cutoff: &'a Cutoff,
    work: &'a mut Workspace,
    interrupt: &'a Interrupt<'a>,
}

impl<T: Sets> WithSimd for OneFrame<'_, T> {
    type Output = Result<Ospa>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        of_frame(simd, self.sets, self.cutoff, self.work, self.interrupt)
    }
}

struct Assign<'a> {
    sets: Euclidean<'a>,
    cutoff: &'a Cutoff,
    work: &'a mut Workspace,
    pairs: &'a mut Vec<Pair>,
    interrupt: &'a Interrupt<'a>,
}

impl WithSimd for Assign<'_> {
    type Output = Result<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        assignment_order::least_total(
            simd,
            self.sets,
            self.cutoff,
            self.work,
            self.pairs,
            self.interrupt,
        )
    }
}

struct ManyFrames<'a> {
    x: Frames<'a>,
    y: Frames<'a>,
    first: usize,
    cutoff: &'a Cutoff,
    output: &'a mut [f64],
    interrupt: &'a Interrupt<'a>,
}

impl WithSimd for ManyFrames<'_> {
    type Output = Result<()>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let work = &mut Workspace::default();
        for (t, output) in (self.first..).zip(self.output) {
            let sets = Euclidean { x: self.x.frame(t), y: self.y.frame(t) };
            if t.is_multiple_of(FRAMES_BETWEEN_CHECKS) {
                self.interrupt.check()?;
            }
            *output = of_frame(simd, sets, self.cutoff, work, self.interrupt)?.distance;
        }
        Ok(())
    }
}

#[inline(always)]
fn of_frame<S: Simd>(
    simd: S,
    sets: impl Sets,
    cutoff: &Cutoff,
    work: &mut Workspace,
    interrupt: &Interrupt<'_>,
) -> Result<Ospa> {
    let (m, n) = sets.sizes();
    let (sets, m, n) = if m > n { (sets.flipped(), n, m) } else { (sets, m, n) };
    if n == 0 {
        return Ok(Ospa { distance: 0.0, localization: 0.0, cardinality: 0.0 });
    }
    if m == 0 {
        return Ok(Ospa { distance: cutoff.c(), localization: 0.0, cardinality: cutoff.c() });
    }
    if cutoff.p() == f64::INFINITY || !cutoff.has_square() {
        return scaled_ospa::ospa(sets, cutoff, interrupt);
    }
    if n >= sparse_matching::SMALLEST
        && let Some(result) = of_large_frame(sets, cutoff, interrupt)?
    {
        return Ok(result);
    }
    let total = least_total(simd, sets, cutoff, &mut work.matching, interrupt)?;
    let result = from_total(total, m, n, cutoff);
    let is_exact =
        total_is_exact(total, result.localization) || (total == 0.0 && sets.zero_is_exact(cutoff));
    if is_exact && (m == n || missing_is_exact(cutoff)) {
        return Ok(result);
    }
    scaled_ospa::ospa(sets, cutoff, interrupt)
}

/// The same by near pairs; `None` where the dense matching is the better way.
#[cold]
fn of_large_frame(
    sets: impl Sets,
    cutoff: &Cutoff,
    interrupt: &Interrupt<'_>,
) -> Result<Option<Ospa>> {
    let (m, n) = sets.sizes();
    let result = sparse_matching::solve(sets, cutoff, interrupt, |large| {
        let total = large.total();
        let result = from_total(total, m, n, cutoff);
        let is_zero = || total == 0.0 && large.pairs().all(|(i, j)| sets.distance(i, j) == 0.0);
        let is_exact = total_is_exact(total, result.localization) || is_zero();
        (is_exact && (m == n || missing_is_exact(cutoff))).then_some(result)
    })?;
    match result {
        Some(None) => scaled_ospa::ospa(sets, cutoff, interrupt).map(Some),
        found => Ok(found.flatten()),
    }
}

/// The least total cost of matching every row with a column; not more rows than columns.
#[inline(always)]
pub(super) fn least_total<S: Simd>(
    simd: S,
    sets: impl Sets,
    cutoff: &Cutoff,
    work: &mut gated_matching::Workspace,
    interrupt: &Interrupt<'_>,
) -> Result<f64> {
    if sets.sizes().1 <= tiny::LARGEST {
        return Ok(sets.tiny_total(cutoff));
    }
    work.solve::<S, false>(simd, sets, cutoff, interrupt)?;
    Ok(work.total())
}

/// The three results from the least total cost of `m <= n` pairs.
#[inline(always)]
fn from_total(total: f64, m: usize, n: usize, cutoff: &Cutoff) -> Ospa {
    let root = |sum: f64| cutoff.root(sum / n as f64);
    let localization = root(total);
    if m == n {
        return Ospa { distance: localization, localization, cardinality: 0.0 };
    }
    let missing = cutoff.most() * (n - m) as f64;
    Ospa { distance: root(total + missing), localization, cardinality: root(missing) }
}

/// Powers in this range keep their digits, and so do sums and quotients of a few of them.
const POWERS: RangeInclusive<f64> = 1e-250..=1e250;

/// Whether no power and no square that matters to the total has left the range of floats.
#[inline(always)]
fn total_is_exact(total: f64, localization: f64) -> bool {
    POWERS.contains(&total) && (1e-100..=1e140).contains(&localization)
}

#[inline(always)]
fn missing_is_exact(cutoff: &Cutoff) -> bool {
    cutoff.c() == f64::INFINITY || POWERS.contains(&cutoff.most())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Width, set_width};

    fn points(n: usize, d: usize, seed: u64) -> Vec<f64> {
        let mut state = seed;
        let next = |_| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f64 / 1000.0
        };
        (0..n * d).map(next).collect()
    }

    #[test]
    fn the_same_bits_on_every_width() {
        for (n, m, d) in [(4, 4, 2), (9, 13, 1), (17, 17, 3), (40, 33, 4), (20, 20, 6)] {
            let (x, y) = (points(n, d, 1), points(m, d, 2));
            let x = Points::new("X", &x, d).unwrap();
            let y = Points::new("Y", &y, d).unwrap();
            for p in [1.0, 2.0, 4.0] {
                let results = [Width::Scalar, Width::V3, Width::Widest].map(|width| {
                    set_width(width);
                    ospa(x, y, 5000.0, p, &mut Workspace::default(), &Interrupt::never()).unwrap()
                });
                assert_eq!(results[0], results[1], "{n} {m} {d} {p}");
                assert_eq!(results[0], results[2], "{n} {m} {d} {p}");
            }
        }
    }

    #[test]
    fn one_thread_or_two_give_the_same_bits() {
        let frames = 20_000;
        let (x, y) = (points(frames * 5, 2, 3), points(frames * 5, 2, 4));
        let starts: Vec<i64> = (0..=frames as i64).map(|t| 5 * t).collect();
        let x = Frames::new("X_sequence", &x, &starts, 2).unwrap();
        let y = Frames::new("Y_sequence", &y, &starts, 2).unwrap();
        let results = [1, 2].map(|count| {
            threads::set_threads(count);
            let mut output = vec![0.0; frames];
            ospa_over_time(x, y, 2000.0, 2.0, &mut output, &Interrupt::never()).unwrap();
            output
        });
        threads::set_threads(0);
        assert_eq!(results[0], results[1]);
    }
}
