//! OSPA(2): the OSPA distance between sets of tracks, over a window that trails the time.
//!
//! For a window W of steps, tracks f and g, and the distance d_t of their states at step t,
//!
//! ```text
//! d(f, g)^q = mean over the t in W at which f or g exists of  min(c, d_t)^q,  c^q where only one exists
//! OSPA(2)^p = ( min over assignments  sum_i d(f_i, g_i)^p  +  c^p (n - m) ) / n
//! ```
//!
//! over the m <= n tracks of either side that exist at some step of W. Beard, Vo and Vo, "A solution
//! for large-scale multi-object tracking", IEEE Trans. Signal Processing 68, 2020,
//! doi:10.1109/TSP.2020.2986136; "OSPA(2): using the OSPA metric to evaluate multi-target tracking
//! performance", ICCAIS 2017, doi:10.1109/ICCAIS.2017.8217598.
//!
//! Two sides without a track are at distance 0, one without and one with at distance c. Distances are
//! powered in units of c, so that no scale overflows.
//!
//! Windows slide: the sum over one is a sum of two parts, the rest of a block of suffix sums and what
//! came after the block, so that each distance is added twice and never subtracted. Cost: O(n m) for
//! each step and window, and one dense assignment for each window.

use super::Trajectories;
use crate::assignment::dense;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::threads;

/// The distance of two states.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Base {
    /// Euclidean.
    Euclidean,
    /// The norm of order p: city-block for p = 1.
    PNorm,
}

/// What fixes the distance.
#[derive(Debug, Clone, Copy)]
pub struct Parameters {
    /// Cutoff, in the unit of the states.
    pub c: f64,
    /// Order over the tracks.
    pub p: f64,
    /// Order over time.
    pub q: f64,
    /// The distance of two states.
    pub base: Base,
}

/// OSPA(2) over one window: `distance^p = localization^p + cardinality^p`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Ospa2 {
    /// The distance, in the unit of the states.
    pub distance: f64,
    /// The part due to the distances of matched tracks.
    pub localization: f64,
    /// The part due to the difference in cardinality.
    pub cardinality: f64,
}

/// Costs kept at a time, so that memory does not grow with the number of windows.
const COSTS: usize = 1 << 18;

/// The windows are cut into about this many parts, for threads to share.
const CHUNKS: usize = 8;

/// Pairs times windows below which a second thread does not pay.
const WORTH_A_THREAD: usize = 20_000;

/// OSPA(2) over each window: `windows` holds the first step of each and the step after its last.
///
/// # Errors
/// [`Error::Parameter`] for a cutoff that is not positive and finite or an order that is not finite
/// and at least 1, [`Error::Dimension`] for states of different dimensions,
/// [`Error::Interrupted`].
pub fn ospa2(
    truth: Trajectories,
    tracks: Trajectories,
    windows: &[[i64; 2]],
    parameters: Parameters,
    interrupt: &Interrupt<'_>,
) -> Result<Vec<Ospa2>> {
    check(&truth, &tracks, parameters)?;
    let problem = Problem { truth, tracks, parameters, interrupt };
    let pairs = (truth.len() * tracks.len()).max(1);
    // Where sums begin depends on the problem alone: the same bits with one thread or with many.
    let chunk = (COSTS / pairs).min(windows.len() / CHUNKS).max(1);
    let mut output = vec![Vec::new(); windows.len().div_ceil(chunk)];
    let least = (WORTH_A_THREAD / (pairs * chunk)).max(1);
    threads::fill_until(&mut output, least, interrupt, |first, piece| {
        let mut work = Workspace::default();
        for (windows, output) in windows.chunks(chunk).skip(first).zip(piece) {
            work.slide(&problem, windows)?;
            *output = windows
                .iter()
                .enumerate()
                .map(|(k, window)| work.distance(&problem, *window, k))
                .collect::<Result<_>>()?;
        }
        Ok(())
    })?;
    Ok(output.concat())
}

/// What stays the same in all windows.
#[derive(Clone, Copy)]
struct Problem<'a> {
    truth: Trajectories<'a>,
    tracks: Trajectories<'a>,
    parameters: Parameters,
    interrupt: &'a Interrupt<'a>,
}

fn check(truth: &Trajectories, tracks: &Trajectories, parameters: Parameters) -> Result<()> {
    let Parameters { c, p, q, .. } = parameters;
    if !(c > 0.0 && c < f64::INFINITY) {
        return Err(Error::Parameter {
            argument: "c",
            requirement: "positive and finite",
            value: c,
        });
    }
    for (argument, value) in [("p", p), ("q", q)] {
        if !(1.0..f64::INFINITY).contains(&value) {
            let requirement = "finite and at least 1";
            return Err(Error::Parameter { argument, requirement, value });
        }
    }
    let (expected, found) = (truth.states.dimension(), tracks.states.dimension());
    if truth.steps.is_empty() || tracks.steps.is_empty() || found == expected {
        return Ok(());
    }
    let first = (0..tracks.len()).find(|&j| !tracks.steps(j).is_empty());
    let index = vec![first.unwrap_or(0), 0];
    Err(Error::Dimension { argument: "tracks", index, found, expected })
}

#[derive(Default)]
struct Workspace {
    /// The steps at which either of a pair exists, and the q-th powers of their distances there.
    steps: Vec<i64>,
    powers: Vec<f64>,
    /// Suffix sums of a block of powers.
    suffixes: Vec<f64>,
    /// The p-th powers of the distances of all pairs: for each window a matrix.
    costs: Vec<f64>,
    rows: Vec<usize>,
    columns: Vec<usize>,
    chosen: Vec<f64>,
    assignment: dense::Workspace,
}

impl Workspace {
    /// The costs of all pairs in all windows.
    fn slide(&mut self, problem: &Problem, windows: &[[i64; 2]]) -> Result<()> {
        let (n, m) = (problem.truth.len(), problem.tracks.len());
        let order = problem.parameters.p / problem.parameters.q;
        self.costs.clear();
        self.costs.resize(n * m * windows.len(), 0.0);
        let from = windows.iter().map(|w| w[0]).min().unwrap_or(0);
        let to = windows.iter().map(|w| w[1]).max().unwrap_or(0);
        for i in 0..n {
            problem.interrupt.check()?;
            for j in 0..m {
                self.compare(problem, i, j, [from, to]);
                let mut sliding = Sliding::default();
                for (k, window) in windows.iter().enumerate() {
                    let mean = sliding.mean(*window, &self.steps, &self.powers, &mut self.suffixes);
                    let cost = if order == 1.0 { mean } else { mean.powf(order) };
                    self.costs[(k * n + i) * m + j] = cost;
                }
            }
        }
        Ok(())
    }

    /// The distances of one pair at every step of a window at which either exists.
    fn compare(&mut self, problem: &Problem, i: usize, j: usize, window: [i64; 2]) {
        self.steps.clear();
        self.powers.clear();
        let (f, g) = (problem.truth.steps(i), problem.tracks.steps(j));
        let ([mut a, a_end], [mut b, b_end]) = (within(f, window), within(g, window));
        while a < a_end || b < b_end {
            let (s, t) = (next(f, a, a_end), next(g, b, b_end));
            self.steps.push(s.min(t));
            self.powers.push(if s == t {
                problem.parameters.power(problem.truth.state(i, a), problem.tracks.state(j, b))
            } else {
                1.0
            });
            a += usize::from(s <= t);
            b += usize::from(t <= s);
        }
    }

    /// OSPA of the tracks that exist in a window, the `k`-th of those in `costs`.
    fn distance(&mut self, problem: &Problem, window: [i64; 2], k: usize) -> Result<Ospa2> {
        existing(&problem.truth, window, &mut self.rows);
        existing(&problem.tracks, window, &mut self.columns);
        let (n, m) = (self.rows.len(), self.columns.len());
        let all = problem.tracks.len();
        self.chosen.clear();
        for &i in &self.rows {
            let row = &self.costs[(k * problem.truth.len() + i) * all..][..all];
            self.chosen.extend(self.columns.iter().map(|&j| row[j]));
        }
        let (goal, interrupt) = (dense::Goal::Least, problem.interrupt);
        let pairs = dense::solve_until(&self.chosen, n, m, goal, interrupt, &mut self.assignment)?;
        let matched = pairs.iter().enumerate().filter(|(_, j)| **j < m);
        let total: f64 = matched.map(|(i, &j)| self.chosen[i * m + j]).sum();
        Ok(problem.parameters.distance(total, n, m))
    }
}

impl Parameters {
    /// The q-th power of the distance of two states in units of c, cut off.
    #[inline]
    fn power(&self, x: &[f64], y: &[f64]) -> f64 {
        let differences = x.iter().zip(y).map(|(x, y)| (x - y).abs() / self.c);
        let ratio = if self.base == Base::Euclidean || self.p == 2.0 {
            differences.map(|d| d * d).sum::<f64>().sqrt()
        } else {
            differences.map(|d| d.powf(self.p)).sum::<f64>().powf(1.0 / self.p)
        };
        // A ratio that is not a number has overflowed.
        if ratio < 1.0 { ratio.powf(self.q) } else { 1.0 }
    }

    /// OSPA of `n` and `m` tracks matched at a total cost, which is in units of c^p.
    fn distance(&self, total: f64, n: usize, m: usize) -> Ospa2 {
        let most = n.max(m);
        if most == 0 {
            return Ospa2::default();
        }
        let missing = n.abs_diff(m) as f64;
        let root = |sum: f64| self.c * (sum / most as f64).powf(1.0 / self.p);
        Ospa2 {
            distance: root(total + missing),
            localization: root(total),
            cardinality: root(missing),
        }
    }
}

/// The trajectories that exist in a window.
fn existing(trajectories: &Trajectories, window: [i64; 2], output: &mut Vec<usize>) {
    output.clear();
    output.extend((0..trajectories.len()).filter(|&i| {
        let [from, to] = within(trajectories.steps(i), window);
        from < to
    }));
}

/// The places of the steps that lie in a window.
#[inline]
fn within(steps: &[i64], window: [i64; 2]) -> [usize; 2] {
    let from = steps.partition_point(|&step| step < window[0]);
    [from, steps.partition_point(|&step| step < window[1]).max(from)]
}

#[inline]
fn next(steps: &[i64], at: usize, end: usize) -> i64 {
    if at < end { steps[at] } else { i64::MAX }
}

/// A mean over windows that move forwards, without subtraction.
#[derive(Default)]
struct Sliding {
    /// The values in the window.
    from: usize,
    to: usize,
    /// Suffix sums are kept of the values `block - suffixes.len() .. block`.
    block: usize,
    /// The sum of the values `block .. to`.
    after: f64,
}

impl Sliding {
    /// The mean over the values whose steps lie in the window; 0 where there is none.
    fn mean(
        &mut self,
        window: [i64; 2],
        steps: &[i64],
        values: &[f64],
        suffixes: &mut Vec<f64>,
    ) -> f64 {
        let [from, to] = within(steps, window);
        if from < self.from || to < self.to || from >= self.block {
            self.begin(from, to, values, suffixes);
        } else {
            self.after += values[self.to..to].iter().sum::<f64>();
        }
        (self.from, self.to) = (from, to);
        if from == to {
            return 0.0;
        }
        let before = if from < self.block { suffixes[self.block - 1 - from] } else { 0.0 };
        (before + self.after) / (to - from) as f64
    }

    /// Makes `from .. to` the block.
    fn begin(&mut self, from: usize, to: usize, values: &[f64], suffixes: &mut Vec<f64>) {
        suffixes.clear();
        suffixes.extend(values[from..to].iter().rev().scan(0.0, |sum, value| {
            *sum += value;
            Some(*sum)
        }));
        (self.block, self.after) = (to, 0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sliding_means_are_means() {
        let steps: Vec<i64> = (0..40).map(|i| 2 * i + i % 3).collect();
        let values: Vec<f64> = (0..40).map(|i| f64::from(i * i % 7)).collect();
        let (mut sliding, mut suffixes) = (Sliding::default(), Vec::new());
        for k in 0..200i64 {
            // Forwards with windows of changing length, and once more from the start.
            let window = [k % 100 - k % 5 - 9, k % 100];
            let inside =
                steps.iter().zip(&values).filter(|(s, _)| (window[0]..window[1]).contains(s));
            let expected: Vec<f64> = inside.map(|(_, v)| *v).collect();
            let mean = expected.iter().sum::<f64>() / expected.len().max(1) as f64;
            assert!((sliding.mean(window, &steps, &values, &mut suffixes) - mean).abs() < 1e-12);
        }
    }

    #[test]
    fn a_step_that_does_not_rise_is_named() {
        let states = crate::Frames::new("truth", &[0.0; 4], &[0, 1, 4], 1).unwrap();
        let error = Trajectories::new("truth", states, &[5, 1, 2, 2]).unwrap_err();
        assert_eq!(error.to_string(), "truth[1]: steps must rise");
        let error = Trajectories::new("truth", states, &[5]).unwrap_err();
        assert_eq!(error.to_string(), "truth: starts must rise from 0 to 1, the number of points");
    }
}
