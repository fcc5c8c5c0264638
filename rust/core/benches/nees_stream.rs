//! NEES of many small covariances against the time to read the same bytes once.
//!
//! `cargo bench -p trackmetrics-core --bench nees_stream [-- avx2]` prints, for each dimension, the
//! time of a covariance and the ratio to a plain sum over the same memory. Both run on one thread,
//! in turn; medians of many rounds.

use pulp::{Simd, WithSimd};
use std::hint::black_box;
use std::time::Instant;
use trackmetrics_core::Array;
use trackmetrics_core::consistency::quadratic_form::{Residuals, Rules, quadratic_forms};
use trackmetrics_core::simd::{self, Width};
use trackmetrics_core::threads::set_threads;

const COUNT: usize = 100_000;
const ROUNDS: usize = 41;

/// A sum with enough partial sums to keep the memory busy.
struct Stream<'a>(&'a [f64]);

impl WithSimd for Stream<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let (vectors, _) = S::as_simd_f64s(self.0);
        let mut sums = [simd.splat_f64s(0.0); 16];
        for chunk in vectors.chunks_exact(16) {
            for (sum, &x) in sums.iter_mut().zip(chunk) {
                *sum = simd.add_f64s(*sum, x);
            }
        }
        sums.into_iter().map(|sum| simd.reduce_sum_f64s(sum)).sum()
    }
}

/// Numbers that look random, between -1 and 1.
fn numbers(count: usize, seed: u64) -> Vec<f64> {
    let mut state = seed;
    let next = |_| {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    (0..count).map(next).collect()
}

/// Symmetric, and positive definite by their diagonals.
fn covariances(d: usize) -> Vec<f64> {
    let mut values = numbers(COUNT * d * d, 1);
    for matrix in values.chunks_exact_mut(d * d) {
        for i in 0..d {
            matrix[i * d + i] = d as f64 + 0.5;
            for j in 0..i {
                matrix[j * d + i] = matrix[i * d + j];
            }
        }
    }
    values
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn timed<T>(work: impl FnOnce() -> T) -> f64 {
    let start = Instant::now();
    black_box(work());
    start.elapsed().as_secs_f64()
}

fn measure(d: usize) {
    let (x, y, p) = (numbers(COUNT * d, 2), numbers(COUNT * d, 3), covariances(d));
    let (states, matrices) = ([COUNT, d], [COUNT, d, d]);
    let (Ok(truth), Ok(estimate), Ok(covariance)) = (
        Array::new("x", &x, &states),
        Array::new("y", &y, &states),
        Array::new("p", &p, &matrices),
    ) else {
        return;
    };
    let residuals = Residuals::Between { truth, estimate };
    let (mut ours, mut stream) = (vec![], vec![]);
    for _ in 0..ROUNDS {
        ours.push(timed(|| quadratic_forms(residuals, covariance, &Rules::default())));
        stream.push(timed(|| {
            [&x, &y, &p].into_iter().map(|values| simd::dispatch(Stream(values))).sum::<f64>()
        }));
    }
    let (ours, stream) = (median(ours), median(stream));
    let bytes = 8.0 * (x.len() + y.len() + p.len()) as f64;
    println!(
        "d = {d}: {:7.2} ns a covariance, {:5.1} GB/s, {:5.2} times the stream",
        ours / COUNT as f64 * 1e9,
        bytes / ours / 1e9,
        ours / stream
    );
}

fn main() {
    if std::env::args().any(|argument| argument == "avx2") {
        simd::set_width(Width::V3);
    }
    set_threads(1);
    println!("{COUNT} covariances, {}", simd::width());
    (1..=9).for_each(measure);
}
