//! Which points are matched.
//!
//! The pairs of the least total of `min(d, c)^p`, without those at the cutoff or beyond, which cost
//! what two points alone cost. Where several matchings cost the same, the one that SciPy's
//! `linear_sum_assignment` finds in the matrix of these costs is taken: its order is known to
//! users and is the same on every machine. The fast matching is used where it is the only one.

use super::cell_grid::check_memory;
use super::cost_source::Sets;
use super::cutoff::Cutoff;
use super::results::Pair;
use super::sparse_matching;
use super::workspace::Workspace;
use crate::assignment::bottleneck;
use crate::assignment::dense::{self, Goal};
use crate::error::Result;
use crate::interrupt::Interrupt;
use pulp::Simd;

/// The pairs closer than the cutoff in the matching of least total, in the order of the rows, and
/// the sum of their costs.
#[inline(always)]
pub(super) fn least_total<S: Simd>(
    simd: S,
    sets: impl Sets,
    cutoff: &Cutoff,
    work: &mut Workspace,
    pairs: &mut Vec<Pair>,
    interrupt: &Interrupt<'_>,
) -> Result<f64> {
    pairs.clear();
    let (m, n) = sets.sizes();
    if m == 0 || n == 0 {
        return Ok(0.0);
    }
    if !has_powers(cutoff) {
        by_hand(sets, cutoff, work, pairs, interrupt)?;
        return Ok(sum(sets, cutoff, pairs));
    }
    if m.max(n) >= sparse_matching::SMALLEST {
        let has_ties = sparse_matching::solve(sets, cutoff, interrupt, |large| {
            pairs.extend(large.pairs());
            large.has_ties((m, n))
        })?;
        if has_ties == Some(true) {
            in_order(sets, cutoff, &mut work.exact, pairs, interrupt)?;
        }
        if has_ties.is_some() {
            pairs.sort_unstable();
            return Ok(sum(sets, cutoff, pairs));
        }
    }
    let (matching, is_flipped) = (&mut work.matching, m > n);
    let wide = if is_flipped { sets.flipped() } else { sets };
    matching.solve::<S, true>(simd, wide, cutoff, interrupt)?;
    if !matching.is_unique(simd, wide, cutoff) {
        in_order(sets, cutoff, &mut work.exact, pairs, interrupt)?;
        return Ok(sum(sets, cutoff, pairs));
    }
    Ok(matching.list(cutoff.most(), is_flipped, pairs))
}

/// Whether squares and powers of distances stay in the range of floats.
#[inline(always)]
fn has_powers(cutoff: &Cutoff) -> bool {
    cutoff.has_square() && (1e-250..=1e250).contains(&cutoff.most())
}

fn sum(sets: impl Sets, cutoff: &Cutoff, pairs: &[Pair]) -> f64 {
    pairs.iter().fold(0.0, |total, &(i, j)| total + sets.cost(i, j, cutoff))
}

/// The same by SciPy's order.
#[cold]
fn in_order(
    sets: impl Sets,
    cutoff: &Cutoff,
    work: &mut dense::Workspace,
    pairs: &mut Vec<Pair>,
    interrupt: &Interrupt<'_>,
) -> Result<()> {
    pairs.clear();
    let costs = matrix(sets, |i, j| sets.cost(i, j, cutoff))?;
    let (m, n) = sets.sizes();
    let columns = dense::solve_until(&costs, m, n, Goal::Least, interrupt, work)?;
    keep_near(sets, cutoff, columns, pairs);
    Ok(())
}

/// The pairs closer than the cutoff in the matching whose largest distance is the smallest.
pub(super) fn bottleneck(
    sets: impl Sets,
    cutoff: &Cutoff,
    pairs: &mut Vec<Pair>,
    interrupt: &Interrupt<'_>,
) -> Result<()> {
    pairs.clear();
    let distances = matrix(sets, |i, j| sets.distance(i, j).min(cutoff.c()).min(f64::MAX))?;
    let (m, n) = sets.sizes();
    if m > 0 && n > 0 {
        let work = &mut bottleneck::Workspace::default();
        let columns = bottleneck::solve_until(&distances, m, n, interrupt, work)?.1;
        keep_near(sets, cutoff, columns, pairs);
    }
    Ok(())
}

/// Where the cutoff is infinite, or powers leave the range of floats.
#[cold]
fn by_hand(
    sets: impl Sets,
    cutoff: &Cutoff,
    work: &mut Workspace,
    pairs: &mut Vec<Pair>,
    interrupt: &Interrupt<'_>,
) -> Result<()> {
    let (m, n) = sets.sizes();
    let stays = |i, j| (0.0..=1e250).contains(&sets.cost(i, j, cutoff));
    if cutoff.c() == f64::INFINITY && (0..m).all(|i| (0..n).all(|j| stays(i, j))) {
        return in_order(sets, cutoff, &mut work.exact, pairs, interrupt);
    }
    let costs = scaled_costs(sets, cutoff, interrupt)?;
    let columns = dense::solve_until(&costs, m, n, Goal::Least, interrupt, &mut work.exact)?;
    keep_near(sets, cutoff, columns, pairs);
    Ok(())
}

/// Costs in units of the bottleneck distance, or of the largest distance below the cutoff where
/// the bottleneck is not: what is above the number of points is never chosen.
fn scaled_costs(sets: impl Sets, cutoff: &Cutoff, interrupt: &Interrupt<'_>) -> Result<Vec<f64>> {
    let (m, n) = sets.sizes();
    let c = cutoff.c().min(f64::MAX);
    let mut distances = matrix(sets, |i, j| sets.distance(i, j).min(c))?;
    let work = &mut bottleneck::Workspace::default();
    let bottleneck = bottleneck::solve_until(&distances, m, n, interrupt, work)?.0;
    let near = distances.iter().copied().filter(|d| *d < c);
    let unit = if bottleneck < c { bottleneck } else { near.fold(0.0, f64::max) };
    let ratio = |d: f64| (d / unit.max(f64::MIN_POSITIVE)).powf(cutoff.p());
    distances.iter_mut().for_each(|d| *d = ratio(*d).min(2.0 * (m + n) as f64));
    Ok(distances)
}

fn matrix(sets: impl Sets, value: impl Fn(usize, usize) -> f64 + Copy) -> Result<Vec<f64>> {
    let (m, n) = sets.sizes();
    check_memory(m, n)?;
    Ok((0..m).flat_map(|i| (0..n).map(move |j| value(i, j))).collect())
}

fn keep_near(sets: impl Sets, cutoff: &Cutoff, columns: &[usize], pairs: &mut Vec<Pair>) {
    let matched = columns.iter().enumerate().filter(|(_, j)| **j != usize::MAX);
    pairs.extend(matched.map(|(i, j)| (i, *j)).filter(|&(i, j)| sets.distance(i, j) < cutoff.c()));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::point_sets::cost_source::Euclidean;
    use crate::point_sets::gospa::gospa;
    use crate::points::Points;
    use crate::simd::{Width, set_width};

    /// Points on a grid of so many steps: many distances are equal where these are few.
    fn points(n: usize, d: usize, steps: u64, state: &mut u64) -> Vec<f64> {
        let next = |_| {
            *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            ((*state >> 33) % steps) as f64
        };
        (0..n * d).map(next).collect()
    }

    #[test]
    fn ties_fall_in_scipys_order_on_every_width() {
        let (mut state, mut work) = (1, Workspace::default());
        for case in 0..600 {
            let (m, n, d) = (1 + case % 11, 1 + case % 17, 1 + case % 5);
            let steps = [3, 12, 1 << 20][case % 3];
            let (x, y) = (points(m, d, steps, &mut state), points(n, d, steps, &mut state));
            let x = Points::new("X", &x, d).unwrap();
            let y = Points::new("Y", &y, d).unwrap();
            let (c, p) = (0.4 * steps as f64, [1.0, 2.0, 3.0, 4.0][case % 4]);
            let (cutoff, sets) = (Cutoff::new(c, p).unwrap(), Euclidean { x, y });
            let (mut expected, never) = (Vec::new(), Interrupt::never());
            in_order(sets, &cutoff, &mut work.exact, &mut expected, &never).unwrap();
            for width in [Width::Scalar, Width::V3, Width::Widest] {
                set_width(width);
                let mut pairs = Vec::new();
                let found = gospa(x, y, (c, p, 2.0), &mut work, &mut pairs, &never).unwrap();
                assert_eq!(pairs, expected, "{m} {n} {d} {steps} {p}");
                let total = sum(sets, &cutoff, &expected);
                assert!((found.localization - total).abs() <= 1e-13 * total);
            }
        }
    }
}
