//! The pairs of truth and track rows of a frame that are similar at all: the sparse input of every
//! score over identities, made in one pass.
//!
//! ```text
//! boxes       similarity = shared area / area of the union         distance = 1 - similarity
//! positions   similarity = max(0, 1 - distance / (2 threshold))     distance = |x - y|
//! matrices    similarity as given, NaN excludes a pair             distance = 1 - similarity
//! ```
//!
//! A pair of similarity 0 is not listed, unless all are asked for (with a threshold so low that it
//! allows them). Sums are taken in NumPy's order and never fused: the same bits everywhere.
//! Cost: O(n m) for a frame of n truth and m track rows, in lanes.

use super::pairwise_sum::pairwise_sum;
use super::sequence::check_offsets;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::simd::{MAX_LANES, dispatch};
use pulp::{Simd, WithSimd};
use std::ops::Range;

/// Boxes of an area up to this are empty.
const EPS: f64 = f64::EPSILON;

/// Where the frames of both sides begin.
#[derive(Debug, Clone, Copy)]
pub struct Offsets<'a> {
    truth: &'a [i64],
    tracks: &'a [i64],
}

impl<'a> Offsets<'a> {
    /// Offsets of both sides, which have so many rows.
    ///
    /// # Errors
    /// [`Error::Offsets`] where they do not rise from 0 to the number of rows, [`Error::Length`] where
    /// one side has more frames.
    pub fn new(truth: &'a [i64], tracks: &'a [i64], rows: [usize; 2]) -> Result<Self> {
        check_offsets("truth", truth, rows[0])?;
        check_offsets("tracks", tracks, rows[1])?;
        let (found, expected) = (tracks.len() - 1, truth.len() - 1);
        if found != expected {
            let (argument, other, unit) = ("tracks", "truth", "frames");
            return Err(Error::Length { argument, found, other, expected, unit });
        }
        Ok(Self { truth, tracks })
    }

    fn frames(&self) -> impl Iterator<Item = (Range<usize>, Range<usize>)> {
        let rows = |starts: &[i64]| starts[0] as usize..starts[1] as usize;
        self.truth.windows(2).map(rows).zip(self.tracks.windows(2).map(rows))
    }
}

/// The pairs found.
#[derive(Debug, Default)]
pub struct Found {
    /// The pairs of truth row `i` are `starts[i] .. starts[i + 1]`.
    pub starts: Vec<i64>,
    /// Their track rows.
    pub columns: Vec<i64>,
    /// Their similarities.
    pub similarities: Vec<f64>,
    /// Their distances.
    pub distances: Vec<f64>,
}

impl Found {
    fn with_rows(rows: usize) -> Self {
        let mut starts = Vec::with_capacity(rows + 1);
        starts.push(0);
        let (columns, similarities) = (Vec::with_capacity(2 * rows), Vec::with_capacity(2 * rows));
        Self { starts, columns, similarities, distances: Vec::with_capacity(2 * rows) }
    }

    #[inline(always)]
    fn push(&mut self, column: usize, similarity: f64, distance: f64) {
        self.columns.push(column as i64);
        self.similarities.push(similarity);
        self.distances.push(distance);
    }

    #[inline(always)]
    fn end_row(&mut self) {
        self.starts.push(self.columns.len() as i64);
    }
}

/// Pairs of boxes that share an area; boxes are left, top, width and height.
///
/// # Errors
/// [`Error::Interrupted`].
pub fn box_pairs(
    truth: &[f64],
    tracks: &[f64],
    offsets: Offsets<'_>,
    keep_all: bool,
    interrupt: &Interrupt<'_>,
) -> Result<Found> {
    dispatch(BoxPairs { truth, tracks, offsets, keep_all, interrupt })
}

struct BoxPairs<'a> {
    truth: &'a [f64],
    tracks: &'a [f64],
    offsets: Offsets<'a>,
    keep_all: bool,
    interrupt: &'a Interrupt<'a>,
}

/// Left, top, right, bottom and area.
#[inline(always)]
fn corners(ltwh: &[f64]) -> [f64; 5] {
    let (l, t) = (ltwh[0], ltwh[1]);
    let (r, b) = (l + ltwh[2], t + ltwh[3]);
    [l, t, r, b, (r - l) * (b - t)]
}

impl WithSimd for BoxPairs<'_> {
    type Output = Result<Found>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Result<Found> {
        let mut found = Found::with_rows(self.truth.len() / 4);
        // Left, top, right, bottom and area of the tracks of a frame, each padded to whole vectors.
        let mut sides: [Vec<f64>; 5] = Default::default();
        for (rows, columns) in self.offsets.frames() {
            self.interrupt.check()?;
            let padded = columns.len().next_multiple_of(MAX_LANES);
            // Padding shares no area with any box.
            for (side, empty) in sides.iter_mut().zip([f64::INFINITY, f64::INFINITY, 0.0, 0.0, 0.0])
            {
                side.clear();
                side.resize(padded, empty);
            }
            let boxes = self.tracks[4 * columns.start..4 * columns.end].chunks_exact(4);
            for (j, ltwh) in boxes.enumerate() {
                for (side, value) in sides.iter_mut().zip(corners(ltwh)) {
                    side[j] = value;
                }
            }
            for ltwh in self.truth[4 * rows.start..4 * rows.end].chunks_exact(4) {
                box_row(simd, corners(ltwh), &sides, &columns, self.keep_all, &mut found);
                found.end_row();
            }
        }
        Ok(found)
    }
}

/// Lists the pairs of one box.
#[inline(always)]
fn box_row<S: Simd>(
    simd: S,
    row: [f64; 5],
    sides: &[Vec<f64>; 5],
    columns: &Range<usize>,
    keep_all: bool,
    found: &mut Found,
) {
    let [l, t, r, b, area] = row.map(
        #[inline(always)]
        |value| simd.splat_f64s(value),
    );
    let [ls, ts, rs, bs, areas] = [0, 1, 2, 3, 4].map(
        #[inline(always)]
        |k| S::as_simd_f64s(&sides[k]).0,
    );
    let (zero, eps) = (simd.splat_f64s(0.0), simd.splat_f64s(EPS));
    for (block, first) in (0..columns.len()).step_by(S::F64_LANES).enumerate() {
        let width = simd.sub_f64s(simd.min_f64s(r, rs[block]), simd.max_f64s(l, ls[block]));
        let height = simd.sub_f64s(simd.min_f64s(b, bs[block]), simd.max_f64s(t, ts[block]));
        let shared = simd.mul_f64s(simd.max_f64s(width, zero), simd.max_f64s(height, zero));
        let any = simd.first_true_m64s(simd.less_than_f64s(zero, shared)) < S::F64_LANES;
        if !any && !keep_all {
            continue;
        }
        let union = simd.sub_f64s(simd.add_f64s(area, areas[block]), shared);
        let smallest = simd.min_f64s(simd.min_f64s(area, areas[block]), union);
        let is_box = simd.less_than_f64s(eps, smallest);
        let iou = simd.select_f64s(is_box, simd.div_f64s(shared, union), zero);
        let mut lanes = [0.0; MAX_LANES];
        S::as_mut_simd_f64s(&mut lanes).0[0] = iou;
        let count = S::F64_LANES.min(columns.len() - first);
        for (j, &similarity) in lanes[..count].iter().enumerate() {
            if similarity > 0.0 || keep_all {
                found.push(columns.start + first + j, similarity, 1.0 - similarity);
            }
        }
    }
}

/// Pairs of positions in `dimension` coordinates that are nearer than twice the threshold.
///
/// # Errors
/// [`Error::Interrupted`].
pub fn position_pairs(
    truth: &[f64],
    tracks: &[f64],
    dimension: usize,
    offsets: Offsets<'_>,
    threshold: f64,
    interrupt: &Interrupt<'_>,
) -> Result<Found> {
    let point = |i: usize| i * dimension..(i + 1) * dimension;
    let mut found = Found::with_rows(*offsets.truth.last().unwrap_or(&0) as usize);
    let mut squares = vec![0.0; dimension];
    let reach = 2.0 * threshold;
    // Farther than this has a similarity of 0, whatever the rounding.
    let far = reach * reach * (1.0 + 1e-9);
    for (rows, columns) in offsets.frames() {
        interrupt.check()?;
        for i in rows {
            let x = &truth[point(i)];
            for j in columns.clone() {
                let y = &tracks[point(j)];
                for (square, (a, b)) in squares.iter_mut().zip(x.iter().zip(y)) {
                    *square = (a - b) * (a - b);
                }
                let square = pairwise_sum(&squares);
                if square > far {
                    continue;
                }
                let distance = square.sqrt();
                let similarity = 1.0 - distance / reach;
                if similarity > 0.0 {
                    found.push(j, similarity, distance);
                }
            }
            found.end_row();
        }
    }
    Ok(found)
}

/// Pairs of the matrices of all frames, one after another and row by row.
///
/// # Errors
/// [`Error::Length`] where there are more or fewer elements than pairs of rows;
/// [`Error::Interrupted`].
pub fn matrix_pairs(
    matrices: &[f64],
    offsets: Offsets<'_>,
    keep_all: bool,
    interrupt: &Interrupt<'_>,
) -> Result<Found> {
    let expected = offsets.frames().map(|(rows, columns)| rows.len() * columns.len()).sum();
    if matrices.len() != expected {
        let (argument, found, unit) = ("matrices", matrices.len(), "elements");
        return Err(Error::Length { argument, found, other: "frames", expected, unit });
    }
    let mut found = Found::with_rows(*offsets.truth.last().unwrap_or(&0) as usize);
    let mut rest = matrices;
    for (rows, columns) in offsets.frames() {
        interrupt.check()?;
        for _ in rows {
            let (row, after) = rest.split_at(columns.len());
            rest = after;
            for (j, &similarity) in columns.clone().zip(row) {
                if similarity > 0.0 {
                    found.push(j, similarity, 1.0 - similarity);
                } else if keep_all {
                    // An excluded pair has a similarity of 0, and is farther than any threshold.
                    let distance = if similarity.is_nan() { f64::INFINITY } else { 1.0 };
                    found.push(j, 0.0, distance);
                }
            }
            found.end_row();
        }
    }
    Ok(found)
}
