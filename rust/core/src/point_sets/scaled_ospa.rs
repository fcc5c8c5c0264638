//! OSPA where powers of distances would leave the range of floats, and for infinite order.
//!
//! Everything is measured in units of the bottleneck distance `b`, the smallest possible largest
//! distance of a matched pair. In these units the least total lies between 1 and the number of
//! pairs, whatever the order: what is far below 1 is lost without loss, and what is above the
//! number of pairs is never chosen.

use super::cell_grid::check_memory;
use super::cost_source::Sets;
use super::cutoff::Cutoff;
use super::results::Ospa;
use crate::assignment::bottleneck;
use crate::assignment::dense::{self, Goal};
use crate::error::Result;
use crate::interrupt::Interrupt;

/// OSPA of two sets, not more rows than columns and at least one, at any order and any scale.
#[cold]
pub(super) fn ospa(sets: impl Sets, cutoff: &Cutoff, interrupt: &Interrupt<'_>) -> Result<Ospa> {
    let (m, n) = sets.sizes();
    check_memory(m, n)?;
    let mut distances = truncated_distances(sets, cutoff.c());
    let unit = bottleneck::solve_until(&distances, m, n, interrupt, &mut Default::default())?.0;
    let total = if unit == 0.0 || cutoff.p() == f64::INFINITY {
        (unit > 0.0).into()
    } else {
        distances.iter_mut().for_each(|d| *d = (*d / unit).powf(cutoff.p()).min(2.0 * n as f64));
        least_total(&distances, m, n, interrupt)?
    };
    Ok(combine(unit, total, m, n, cutoff))
}

/// The three results from a total in units of `unit^p`.
fn combine(unit: f64, total: f64, m: usize, n: usize, cutoff: &Cutoff) -> Ospa {
    let root = |sum: f64| (sum / n as f64).powf(1.0 / cutoff.p());
    let localization = if unit == 0.0 { 0.0 } else { unit * root(total) };
    if m == n {
        return Ospa { distance: localization, localization, cardinality: 0.0 };
    }
    let (c, alone) = (cutoff.c(), (n - m) as f64);
    let both = if c == f64::INFINITY { alone } else { alone + (unit / c).powf(cutoff.p()) * total };
    Ospa { distance: c * root(both), localization, cardinality: c * root(alone) }
}

fn truncated_distances(sets: impl Sets, c: f64) -> Vec<f64> {
    let (m, n) = sets.sizes();
    let pairs = (0..m).flat_map(|i| (0..n).map(move |j| (i, j)));
    pairs.map(|(i, j)| sets.distance(i, j).min(c).min(f64::MAX)).collect()
}

fn least_total(costs: &[f64], m: usize, n: usize, interrupt: &Interrupt<'_>) -> Result<f64> {
    let mut work = dense::Workspace::default();
    let columns = dense::solve_until(costs, m, n, Goal::Least, interrupt, &mut work)?;
    Ok(columns.iter().enumerate().map(|(i, j)| costs[i * n + j]).sum())
}
