//! Sums of values and of squared differences, over lanes.
//!
//! Long sums are added in blocks, each with several partial sums in every lane: faster than one
//! after the other, and closer to the exact sum.

use crate::simd;
use crate::simd::transpose::{self, Load, WithLanes, store};
use pulp::{Simd, WithSimd};

/// Elements that are added before their sum joins the total.
const BLOCK: usize = 2048;

/// The sum of all values.
pub(crate) fn sum(values: &[f64]) -> f64 {
    blocks(values.len()).map(|(from, to)| simd::dispatch(Sum(&values[from..to]))).sum()
}

/// The sum of the squared differences, or of the squares where there is no `second`.
pub(crate) fn squares(first: &[f64], second: Option<&[f64]>) -> f64 {
    let part = |(from, to)| {
        let second = second.map(|values| &values[from..to]);
        simd::dispatch(Squares { first: &first[from..to], second })
    };
    blocks(first.len()).map(part).sum()
}

fn blocks(length: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..length).step_by(BLOCK).map(move |from| (from, length.min(from + BLOCK)))
}

struct Sum<'a>(&'a [f64]);

impl WithSimd for Sum<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let (vectors, rest) = S::as_simd_f64s(self.0);
        let mut sums = [simd.splat_f64s(0.0); 4];
        for (i, &x) in vectors.iter().enumerate() {
            sums[i % 4] = simd.add_f64s(sums[i % 4], x);
        }
        reduced(simd, sums) + rest.iter().sum::<f64>()
    }
}

struct Squares<'a> {
    first: &'a [f64],
    second: Option<&'a [f64]>,
}

impl WithSimd for Squares<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let mut sums = [simd.splat_f64s(0.0); 4];
        let (x, x_rest) = S::as_simd_f64s(self.first);
        let Some(second) = self.second else {
            for (i, &x) in x.iter().enumerate() {
                sums[i % 4] = simd.mul_add_e_f64s(x, x, sums[i % 4]);
            }
            return reduced(simd, sums) + x_rest.iter().map(|x| x * x).sum::<f64>();
        };
        let (y, y_rest) = S::as_simd_f64s(second);
        for (i, (&x, &y)) in x.iter().zip(y).enumerate() {
            let e = simd.sub_f64s(x, y);
            sums[i % 4] = simd.mul_add_e_f64s(e, e, sums[i % 4]);
        }
        let rest: f64 = x_rest.iter().zip(y_rest).map(|(x, y)| (x - y) * (x - y)).sum();
        reduced(simd, sums) + rest
    }
}

#[inline(always)]
fn reduced<S: Simd>(simd: S, sums: [S::f64s; 4]) -> f64 {
    let [a, b, c, d] = sums;
    simd.reduce_sum_f64s(simd.add_f64s(simd.add_f64s(a, b), simd.add_f64s(c, d)))
}

/// Adds the squared difference of every element to its place in `output`.
pub(crate) fn add_squares(first: &[f64], second: Option<&[f64]>, output: &mut [f64]) {
    simd::dispatch(AddSquares { first, second, output });
}

struct AddSquares<'a> {
    first: &'a [f64],
    second: Option<&'a [f64]>,
    output: &'a mut [f64],
}

impl WithSimd for AddSquares<'_> {
    type Output = ();

    /// The compiler makes vectors of these loops by itself: they reduce nothing.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let rows = self.first.chunks_exact(self.output.len());
        match self.second {
            None => rows.for_each(|x| add(x.iter().copied(), self.output)),
            Some(second) => {
                for (x, y) in rows.zip(second.chunks_exact(self.output.len())) {
                    add(x.iter().zip(y).map(|(x, y)| x - y), self.output);
                }
            }
        }
    }
}

#[inline(always)]
fn add(errors: impl Iterator<Item = f64>, output: &mut [f64]) {
    for (sum, e) in output.iter_mut().zip(errors) {
        *sum += e * e;
    }
}

/// The sum of squared differences of each short row, where rows are of one to nine elements.
pub(crate) fn short_rows(width: usize, first: &[f64], second: Option<&[f64]>, output: &mut [f64]) {
    match width {
        1 => transpose::dispatch(Rows::<1> { first, second, output }),
        2 => transpose::dispatch(Rows::<2> { first, second, output }),
        3 => transpose::dispatch(Rows::<3> { first, second, output }),
        4 => transpose::dispatch(Rows::<4> { first, second, output }),
        5 => transpose::dispatch(Rows::<5> { first, second, output }),
        6 => transpose::dispatch(Rows::<6> { first, second, output }),
        7 => transpose::dispatch(Rows::<7> { first, second, output }),
        8 => transpose::dispatch(Rows::<8> { first, second, output }),
        9 => transpose::dispatch(Rows::<9> { first, second, output }),
        _ => {}
    }
}

struct Rows<'a, const E: usize> {
    first: &'a [f64],
    second: Option<&'a [f64]>,
    output: &'a mut [f64],
}

impl<const E: usize> WithLanes for Rows<'_, E> {
    type Output = ();

    #[inline(always)]
    fn with_lanes<S: Simd, L: Load<S>>(self, simd: S, load: L) {
        let width = S::F64_LANES;
        let whole = self.output.len() / width * width;
        let (blocks, rest) = self.output.split_at_mut(whole);
        let (mut e, mut y) = ([simd.splat_f64s(0.0); E], [simd.splat_f64s(0.0); E]);
        for (b, output) in blocks.chunks_exact_mut(width).enumerate() {
            let from = b * width * E;
            load.load(simd, &self.first[from..], &mut e);
            if let Some(second) = self.second {
                load.load(simd, &second[from..], &mut y);
                for i in 0..E {
                    e[i] = simd.sub_f64s(e[i], y[i]);
                }
            }
            let mut sum = simd.mul_f64s(e[0], e[0]);
            for e in &e[1..] {
                sum = simd.mul_add_e_f64s(*e, *e, sum);
            }
            store(sum, output);
        }
        for (k, sum) in rest.iter_mut().enumerate() {
            let row = (whole + k) * E..(whole + k + 1) * E;
            *sum = squares_of(&self.first[row.clone()], self.second.map(|y| &y[row]));
        }
    }
}

#[inline(always)]
fn squares_of(first: &[f64], second: Option<&[f64]>) -> f64 {
    match second {
        None => first.iter().map(|x| x * x).sum(),
        Some(second) => first.iter().zip(second).map(|(x, y)| (x - y) * (x - y)).sum(),
    }
}
