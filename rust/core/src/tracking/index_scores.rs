//! CLEAR MOT scores of frames whose list index is the identity, as in `pytcl.performance_evaluation`.
//!
//! In each frame the truth is matched with the estimates at the least total distance over all pairs;
//! then pairs farther apart than the threshold are dropped. Over all frames, with g points of truth,
//!
//! ```text
//! misses          truth points without a pair        false positives  estimates without a pair
//! switches        pairs whose truth index had another estimate index in the remembered frame
//! fragmentations  pairs whose truth index had a pair before, but none in the remembered frame
//! MOTA = 1 - (misses + false positives + switches) / g        MOTP = mean distance of the pairs
//! ```
//!
//! The remembered frame is the last one that had truth. MOTA is 1 without truth, MOTP is 0 without a
//! pair. Bernardin and Stiefelhagen, "Evaluating multiple object tracking performance: the CLEAR MOT
//! metrics", EURASIP J. Image and Video Processing, 2008, doi:10.1155/2008/246309; the paper's own
//! switches follow identities, gate before the assignment and prefer the pairs of the last frame.
//!
//! Ties are broken as SciPy's `linear_sum_assignment` does, and distances are sums of squares in the
//! order of the coordinates, without fused operations. Cost: O(n m) for a frame in which every point
//! has a nearest partner of its own, the dense assignment otherwise.

use super::euclidean_matrix::Distances;
use crate::assignment::dense;
use crate::error::{Error, Result};
use crate::points::{Frames, Points};
use crate::simd::dispatch;
use pulp::{Simd, WithSimd};

const NONE: usize = usize::MAX;

/// Scores of a sequence, and the counts that they are made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotMetrics {
    /// Accuracy: 1 is best, and it has no lower bound.
    pub mota: f64,
    /// Mean distance of the pairs, in the points' unit; 0 is best.
    pub motp: f64,
    /// Pairs whose truth index had another estimate index in the remembered frame.
    pub switches: usize,
    /// Pairs whose truth index had a pair before, but none in the remembered frame.
    pub fragmentations: usize,
    /// Estimates without a pair.
    pub false_positives: usize,
    /// Truth points without a pair.
    pub misses: usize,
}

/// CLEAR MOT scores of `ground_truth` and `estimates`, frame by frame.
///
/// # Errors
/// [`Error::Parameter`] for a threshold that is NaN or negative, [`Error::Length`] for sequences of
/// different lengths, [`Error::Dimension`] for points of different dimensions,
/// [`Error::Infeasible`] where distances overflow.
pub fn mot_metrics(ground_truth: Frames, estimates: Frames, threshold: f64) -> Result<MotMetrics> {
    check(ground_truth, estimates, threshold)?;
    let tally = dispatch(Count { ground_truth, estimates, threshold })?;
    Ok(tally.scores(ground_truth.points()))
}

/// All frames, compiled for the width of the machine.
struct Count<'a> {
    ground_truth: Frames<'a>,
    estimates: Frames<'a>,
    threshold: f64,
}

impl WithSimd for Count<'_> {
    type Output = Result<Tally>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Result<Tally> {
        let (mut tally, mut matching) = (Tally::default(), Matching::default());
        for t in 0..self.ground_truth.len() {
            let (truth, found) = (self.ground_truth.frame(t), self.estimates.frame(t));
            if truth.is_empty() {
                tally.false_positives += found.len();
                continue;
            }
            matching.solve(simd, truth, found)?;
            tally.frame(&matching, found.len(), self.threshold);
        }
        Ok(tally)
    }
}

fn check(ground_truth: Frames, estimates: Frames, threshold: f64) -> Result<()> {
    if threshold.is_nan() || threshold < 0.0 {
        let (argument, requirement) = ("threshold", "at least 0");
        return Err(Error::Parameter { argument, requirement, value: threshold });
    }
    let (expected, found) = (ground_truth.len(), estimates.len());
    if found != expected {
        let (argument, other, unit) = ("estimates", "ground_truth", "frames");
        return Err(Error::Length { argument, found, other, expected, unit });
    }
    let (expected, found) = (ground_truth.dimension(), estimates.dimension());
    if ground_truth.has_no_points() || estimates.has_no_points() || found == expected {
        return Ok(());
    }
    let first = (0..estimates.len()).find(|&t| !estimates.frame(t).is_empty());
    let index = vec![first.unwrap_or(0), 0];
    Err(Error::Dimension { argument: "estimates", index, found, expected })
}

/// What is counted on the way.
#[derive(Default)]
struct Tally {
    switches: usize,
    fragmentations: usize,
    false_positives: usize,
    misses: usize,
    matches: usize,
    distance: f64,
    /// For each truth index, its estimate index in the remembered frame.
    remembered: Vec<usize>,
    /// Whether each truth index was ever matched.
    matched_before: Vec<bool>,
}

impl Tally {
    /// Counts one frame that has truth.
    fn frame(&mut self, matching: &Matching, found: usize, threshold: f64) {
        let truth = matching.partner.len();
        // Grows only: an index beyond this frame's truth is forgotten below.
        self.remembered.resize(self.remembered.len().max(truth), NONE);
        self.matched_before.resize(self.remembered.len(), false);
        let (mut matches, mut distance) = (0, 0.0);
        for (i, (&j, &d)) in matching.partner.iter().zip(&matching.distance).enumerate() {
            let matched = j != NONE && d <= threshold;
            if matched {
                matches += 1;
                distance += d;
                self.compare(i, j);
            }
            self.remembered[i] = if matched { j } else { NONE };
        }
        self.remembered[truth..].fill(NONE);
        self.matches += matches;
        self.distance += distance;
        self.misses += truth - matches;
        self.false_positives += found - matches;
    }

    /// Holds the pair of truth `i` and estimate `j` against the remembered frame.
    fn compare(&mut self, i: usize, j: usize) {
        let before = self.remembered[i];
        self.switches += usize::from(before != NONE && before != j);
        self.fragmentations += usize::from(before == NONE && self.matched_before[i]);
        self.matched_before[i] = true;
    }

    fn scores(&self, truth: usize) -> MotMetrics {
        let wrong = self.misses + self.false_positives + self.switches;
        MotMetrics {
            mota: if truth > 0 { 1.0 - wrong as f64 / truth as f64 } else { 1.0 },
            motp: if self.matches > 0 { self.distance / self.matches as f64 } else { 0.0 },
            switches: self.switches,
            fragmentations: self.fragmentations,
            false_positives: self.false_positives,
            misses: self.misses,
        }
    }
}

/// The matching of one frame, and what the next can use again.
#[derive(Default)]
struct Matching {
    /// The estimate of each truth point, `NONE` where it has none.
    partner: Vec<usize>,
    /// Its distance.
    distance: Vec<f64>,
    costs: Distances,
    nearest: Vec<usize>,
    taken: Vec<bool>,
    packed: Vec<f64>,
    assignment: dense::Workspace,
}

impl Matching {
    /// Matches all of the smaller set at the least total distance.
    #[inline(always)]
    fn solve<S: Simd>(&mut self, simd: S, truth: Points, found: Points) -> Result<()> {
        let swapped = truth.len() > found.len();
        let (rows, columns) = if swapped { (found, truth) } else { (truth, found) };
        self.partner.clear();
        self.partner.resize(truth.len(), NONE);
        self.distance.clear();
        self.distance.resize(truth.len(), 0.0);
        if rows.is_empty() {
            return Ok(());
        }
        self.costs.fill(simd, rows, columns);
        let chosen = if self.every_row_has_a_nearest(columns.len()) {
            &self.nearest
        } else {
            self.costs.pack(&mut self.packed);
            dense::solve(&self.packed, rows.len(), columns.len(), &mut self.assignment)?
        };
        for (row, &column) in chosen.iter().enumerate() {
            let (i, j) = if swapped { (column, row) } else { (row, column) };
            self.partner[i] = j;
            self.distance[i] = self.costs.row(row)[column];
        }
        Ok(())
    }

    /// Whether each row in turn finds one of its cheapest columns free; the first such is `nearest`.
    ///
    /// These are the steps of the dense solver, its ties included, as long as no dual is changed.
    fn every_row_has_a_nearest(&mut self, columns: usize) -> bool {
        self.nearest.clear();
        self.taken.clear();
        self.taken.resize(columns, false);
        self.costs.least().iter().enumerate().all(|(i, &least)| {
            let row = self.costs.row(i).iter().zip(&self.taken);
            let free = row.into_iter().position(|(&cost, &taken)| cost == least && !taken);
            free.filter(|_| least < f64::INFINITY).is_some_and(|column| {
                self.taken[column] = true;
                self.nearest.push(column);
                true
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames of points on a line.
    fn scores(truth: &[&[f64]], estimates: &[&[f64]], threshold: f64) -> Result<MotMetrics> {
        let pack = |frames: &[&[f64]]| {
            let mut starts = vec![0i64];
            starts.extend(frames.iter().scan(0, |n, f| {
                *n += f.len() as i64;
                Some(*n)
            }));
            (frames.concat(), starts)
        };
        let ((x, xs), (y, ys)) = (pack(truth), pack(estimates));
        mot_metrics(
            Frames::new("ground_truth", &x, &xs, 1)?,
            Frames::new("estimates", &y, &ys, 1)?,
            threshold,
        )
    }

    #[test]
    fn the_gate_comes_after_the_assignment() {
        let s = scores(&[&[0.0, 10.0]], &[&[9.0, 100.0]], 10.0).unwrap();
        assert_eq!((s.motp, s.misses, s.false_positives), (9.0, 1, 1));
    }

    #[test]
    fn a_frame_without_truth_keeps_the_memory_and_one_without_estimates_does_not() {
        let (swapped, both) = (&[5.0, 0.0][..], &[0.0, 5.0][..]);
        let kept = scores(&[both, &[], both], &[both, &[7.0], swapped], 1.0).unwrap();
        assert_eq!((kept.switches, kept.fragmentations, kept.false_positives), (2, 0, 1));
        let lost = scores(&[both, both, both], &[both, &[], swapped], 1.0).unwrap();
        assert_eq!((lost.switches, lost.fragmentations, lost.misses), (0, 2, 2));
    }

    #[test]
    fn a_truth_index_that_was_absent_is_forgotten() {
        let s =
            scores(&[&[0.0, 5.0], &[0.0], &[0.0, 5.0]], &[&[0.0, 5.0], &[0.0], &[5.0, 0.0]], 1.0);
        assert_eq!(s.map(|s| (s.switches, s.fragmentations)), Ok((1, 1)));
    }

    #[test]
    fn nothing_has_full_accuracy() {
        let s = scores(&[&[], &[]], &[&[1.0], &[]], 1.0).unwrap();
        assert_eq!((s.mota, s.motp, s.false_positives), (1.0, 0.0, 1));
        assert_eq!(scores(&[], &[], 1.0).unwrap().mota, 1.0);
    }

    #[test]
    fn bad_arguments_are_named() {
        let text = |e: Error| e.to_string();
        for (threshold, message) in [
            (f64::NAN, "threshold must be at least 0, got nan"),
            (-1.0, "threshold must be at least 0, got -1.0"),
        ] {
            assert_eq!(scores(&[], &[], threshold).map_err(text), Err(message.into()));
        }
        assert_eq!(
            scores(&[&[]], &[], 1.0).map_err(text),
            Err("estimates has 0 frames, ground_truth has 1".into())
        );
        assert_eq!(scores(&[&[1e300]], &[&[-1e300]], 1.0), Err(Error::Infeasible));
    }

    #[test]
    fn the_short_way_is_the_dense_solver() {
        // Tie-rich integers from a small generator.
        let mut state = 1u64;
        let mut next = |below: u64| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) % below
        };
        let mut matching = Matching::default();
        let mut short = 0;
        for _ in 0..5000 {
            let (rows, columns) = (1 + next(4) as usize, 4 + next(2) as usize);
            let mut points = |n: usize| -> Vec<f64> { (0..n).map(|_| next(12) as f64).collect() };
            let (x, y) = (points(rows), points(columns));
            let sets = [Points::new("x", &x, 1).unwrap(), Points::new("y", &y, 1).unwrap()];
            matching.solve(pulp::Scalar::new(), sets[0], sets[1]).unwrap();
            let mut costs = Vec::new();
            matching.costs.pack(&mut costs);
            assert!(
                costs
                    .iter()
                    .enumerate()
                    .all(|(k, c)| (x[k / columns] - y[k % columns]).abs() == *c)
            );
            let solved = dense::solve(&costs, rows, columns, &mut matching.assignment);
            assert_eq!(solved, Ok(&matching.partner[..]), "{costs:?}");
            short += usize::from(matching.every_row_has_a_nearest(columns));
        }
        assert!(short > 1000);
    }
}
