//! A few runs at once, reduced to one node of the tree while their numbers are at hand.
//!
//! Steps go side by side in the lanes. As many steps as there are lanes, of all runs of the group, are
//! a [`Tile`]: it is loaded, its forms are computed, and each column is added up over the runs
//! pairwise, as the tree of run numbers does, so that only the sum of the group is written. What
//! comes out has the same bits for every width of the vectors, and as if each run had been a group of
//! its own.

use super::histogram::BINS;
use super::reduce_large_dimension;
use super::run_block::{Group, Output};
use super::step_block::{RunSums, Tile};
use crate::consistency::batched_ldl::{Block, widest};
use crate::consistency::quadratic_form::SYMMETRY;
use crate::error::Result;
use crate::simd::Width;
use crate::simd::transpose::{Load, WithLanes, dispatch};
use pulp::Simd;

/// The most runs of a group: more do not stay in the innermost cache.
const MOST_RUNS: usize = 4;
/// The most states whose covariances are factored in the lanes.
const MOST_STATES: usize = 9;

/// How many runs a group has that begins at `start` and ends before `stop`: a power of two that
/// `start` is a multiple of.
pub(super) fn runs_together(start: u64, stop: u64, dimension: usize) -> usize {
    let most = if dimension > MOST_STATES { 1 } else { MOST_RUNS };
    let level = start.trailing_zeros().min((stop - start).ilog2()).min(most.ilog2());
    1 << level
}

/// Fills the row and the sums of the runs of a group, and counts.
pub(super) fn reduce(group: Group<'_>, output: Output<'_>) -> Result<()> {
    match group.batch.dimension() {
        1 => dispatch(Small::<1>(group, output)),
        2 => dispatch(Small::<2>(group, output)),
        3 => dispatch(Small::<3>(group, output)),
        4 => dispatch(Small::<4>(group, output)),
        5 => dispatch(Small::<5>(group, output)),
        6 => dispatch(Small::<6>(group, output)),
        7 => dispatch(Small::<7>(group, output)),
        8 => dispatch(Small::<8>(group, output)),
        9 => dispatch(Small::<9>(group, output)),
        _ => reduce_large_dimension::reduce(&group, output),
    }
}

/// States of `D` numbers.
struct Small<'a, const D: usize>(Group<'a>, Output<'a>);

impl<const D: usize> WithLanes for Small<'_, D> {
    type Output = Result<()>;

    const WIDEST: Width = widest(D);

    #[inline(always)]
    fn with_lanes<S: Simd, L: Load<S>>(self, simd: S, load: L) -> Result<()> {
        let Self(group, output) = self;
        let steps = group.batch.steps;
        let mut settled: Option<Vec<f64>> = None;
        let mut block = Block::<S, L, D>::new(simd, load, SYMMETRY);
        let mut tile = Tile::<S, D, MOST_RUNS>::new(simd);
        let mut sums = RunSums::new(simd);
        for step in (0..steps).step_by(S::F64_LANES) {
            tile.go_to(simd, step, S::F64_LANES.min(steps - step));
            for run in 0..group.runs {
                tile.load(simd, load, &mut block, &group, run);
            }
            if settled.is_none() && tile.is_doubtful(simd, &group) {
                settled = Some(group.batch.forms(group.first, group.runs)?);
            }
            if let Some(settled) = &settled {
                tile.settle(settled, steps);
            }
            tile.decide_what_counts(simd);
            tile.write_forms(simd, group.levels.decibels, output.row, steps);
            tile.write_states(simd, output.row, steps);
            tile.count_under(simd, group.levels.thresholds, output.counts, steps);
            tile.count_bins(group.runs, &mut output.histogram[step * BINS..]);
            sums.add(simd, &tile);
        }
        sums.finish(output.of_runs);
        Ok(())
    }
}
