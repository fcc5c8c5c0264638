//! L D L' of many small covariances at once, one in each lane.
//!
//! Right-looking: as soon as a column is finished, it is subtracted from what is right of it. The
//! residual rides along as one more row, so that the factor is never stored. Lanes whose covariance
//! is not clearly positive definite, not symmetric or not finite come out as NaN, and are left to
//! [`Judge`](super::checked_ldl::Judge).

// The indices are those of the formula: rows and columns of a triangle.
#![allow(clippy::needless_range_loop)]

use super::checked_ldl::doubtful_pivot;
use crate::simd::Width;
use crate::simd::transpose::{Load, WithLanes, store};
use pulp::Simd;

/// Which covariance belongs to a residual.
#[derive(Debug, Clone, Copy)]
pub(super) enum Matrices<'a> {
    /// One each.
    Own(&'a [f64]),
    /// The same for all, factored: L below the diagonal, and the pivots' inverses.
    Shared { lower: &'a [f64], inverses: &'a [f64] },
}

/// The forms of consecutive residuals of `D` numbers; `E` is `D` squared.
pub(super) struct Forms<'a, const D: usize, const E: usize> {
    pub(super) first: &'a [f64],
    pub(super) second: Option<&'a [f64]>,
    pub(super) matrices: Matrices<'a>,
    pub(super) symmetry: f64,
    pub(super) output: &'a mut [f64],
}

/// From five dimensions on a covariance does not fit into registers, and half as many at a time are as
/// fast on Intel and faster on AMD.
pub(crate) const fn widest(dimension: usize) -> Width {
    if dimension < 5 { Width::Widest } else { Width::V3 }
}

impl<const D: usize, const E: usize> WithLanes for Forms<'_, D, E> {
    /// Whether no lane was left in doubt.
    type Output = bool;

    const WIDEST: Width = widest(D);

    #[inline(always)]
    fn with_lanes<S: Simd, L: Load<S>>(self, simd: S, load: L) -> bool {
        let Self { first, second, matrices, symmetry, output } = self;
        let mut block = Block::<S, L, D>::new(simd, load, symmetry);
        let mut total = simd.splat_f64s(0.0);
        let (whole, rest) = output.split_at_mut(output.len() / S::F64_LANES * S::F64_LANES);
        for (b, output) in whole.chunks_exact_mut(S::F64_LANES).enumerate() {
            let k = b * S::F64_LANES;
            let second = second.map(|values| &values[k * D..]);
            let matrices = matrices.from(k * E);
            let forms = block.forms(&first[k * D..], second, matrices, S::F64_LANES);
            total = simd.add_f64s(total, forms);
            store(forms, output);
        }
        if !rest.is_empty() {
            let k = whole.len();
            let second = second.map(|values| &values[k * D..]);
            let forms = block.forms(&first[k * D..], second, matrices.from(k * E), rest.len());
            total = simd.add_f64s(total, forms);
            store(forms, rest);
        }
        // One NaN makes the sum NaN.
        simd.reduce_sum_f64s(total).is_finite()
    }
}

impl Matrices<'_> {
    #[inline(always)]
    fn from(self, element: usize) -> Self {
        match self {
            Self::Own(p) => Self::Own(&p[element..]),
            shared => shared,
        }
    }
}

/// How many elements ahead the memory is asked for covariances: it does not see by itself that rows
/// are read in order.
const AHEAD: usize = 1024;

/// Starts a cache line: a vector across two lines costs twice, and is slow to read again.
#[repr(align(64))]
pub(crate) struct Aligned<T>(pub(crate) T);

/// As many residuals as there are lanes, and what they are computed with.
pub(crate) struct Block<S: Simd, L, const D: usize> {
    simd: S,
    load: L,
    symmetry: f64,
    /// The covariances; the lower triangle is eaten up.
    p: Aligned<[[S::f64s; D]; D]>,
    /// The residuals, then L^-1 times them.
    z: Aligned<[S::f64s; D]>,
    /// What is subtracted from them.
    y: Aligned<[S::f64s; D]>,
}

impl<S: Simd, L: Load<S>, const D: usize> Block<S, L, D> {
    #[inline(always)]
    pub(crate) fn new(simd: S, load: L, symmetry: f64) -> Self {
        let zero = simd.splat_f64s(0.0);
        let (p, z, y) = (Aligned([[zero; D]; D]), Aligned([zero; D]), Aligned([zero; D]));
        Self { simd, load, symmetry, p, z, y }
    }

    /// The forms of the first `count` residuals, at most as many as there are lanes.
    #[inline(always)]
    fn forms(
        &mut self,
        first: &[f64],
        second: Option<&[f64]>,
        matrices: Matrices,
        count: usize,
    ) -> S::f64s {
        self.load_residuals(first, second, count);
        match matrices {
            Matrices::Own(p) => {
                self.load_covariances(p, count);
                self.own(&p[AHEAD.min(p.len())..])
            }
            Matrices::Shared { lower, inverses } => self.shared(lower, inverses),
        }
    }

    /// The first `count` residuals, or the difference of two.
    #[inline(always)]
    pub(crate) fn load_residuals(&mut self, first: &[f64], second: Option<&[f64]>, count: usize) {
        self.load(first, count, |block| &mut block.z.0);
        if let Some(second) = second {
            self.load(second, count, |block| &mut block.y.0);
            for i in 0..D {
                self.z.0[i] = self.simd.sub_f64s(self.z.0[i], self.y.0[i]);
            }
        }
    }

    /// The first `count` covariances.
    #[inline(always)]
    pub(crate) fn load_covariances(&mut self, p: &[f64], count: usize) {
        self.load(p, count, |block| block.p.0.as_flattened_mut());
    }

    #[inline(always)]
    fn load(&mut self, records: &[f64], count: usize, to: impl Fn(&mut Self) -> &mut [S::f64s]) {
        let (simd, load) = (self.simd, self.load);
        match count == S::F64_LANES {
            true => load.load(simd, records, to(self)),
            false => load.load_some(simd, records, count, to(self)),
        }
    }

    /// The residuals that were loaded.
    #[inline(always)]
    pub(crate) fn residuals(&mut self) -> &mut [S::f64s; D] {
        &mut self.z.0
    }

    /// The diagonals of the covariances that were loaded.
    #[inline(always)]
    pub(crate) fn variances(&self) -> [S::f64s; D] {
        std::array::from_fn(|j| self.p.0[j][j])
    }

    /// The forms of what was loaded, with a covariance each; NaN where there is doubt. The memory is
    /// asked for the covariances `next` meanwhile.
    #[inline(always)]
    pub(crate) fn own(&mut self, next: &[f64]) -> S::f64s {
        let simd = self.simd;
        let share = S::F64_LANES * D;
        let mut fair = self.average();
        let mut form = simd.splat_f64s(0.0);
        let least = simd.splat_f64s(doubtful_pivot(D));
        let mut bounds = [form; D];
        for j in 0..D {
            bounds[j] = simd.mul_f64s(least, self.p.0[j][j]);
        }
        // One step a line, so that in each the loops have constant bounds.
        macro_rules! eliminate {
            ($($j:literal)*) => { $( if $j < D {
                fair = simd.and_m64s(fair, simd.greater_than_f64s(self.p.0[$j][$j], bounds[$j]));
                form = self.eliminate($j, form);
                // A share at a time: all at once would wait for each other.
                let next = next.get($j * share..($j + 1) * share).unwrap_or_default();
                self.load.fetch(simd, next);
            } )* };
        }
        eliminate!(0 1 2 3 4 5 6 7 8);
        self.or_nan(fair, form)
    }

    /// Subtracts column `j` from what is right of it, and adds its part to the form.
    #[inline(always)]
    fn eliminate(&mut self, j: usize, form: S::f64s) -> S::f64s {
        let (simd, p, z) = (self.simd, &mut self.p.0, &mut self.z.0);
        let inverse = simd.div_f64s(simd.splat_f64s(1.0), p[j][j]);
        let scaled = simd.mul_f64s(z[j], inverse);
        for i in j + 1..D {
            z[i] = simd.negate_mul_add_e_f64s(p[i][j], scaled, z[i]);
            let factor = simd.mul_f64s(p[i][j], inverse);
            for k in j + 1..=i {
                p[i][k] = simd.negate_mul_add_e_f64s(factor, p[k][j], p[i][k]);
            }
        }
        simd.mul_add_e_f64s(z[j], scaled, form)
    }

    /// With one factored covariance.
    #[inline(always)]
    fn shared(&mut self, lower: &[f64], inverses: &[f64]) -> S::f64s {
        let (simd, z) = (self.simd, &mut self.z.0);
        let (lower, inverses) = (&lower[..D * D], &inverses[..D]);
        let mut form = simd.splat_f64s(0.0);
        for j in 0..D {
            let scaled = simd.mul_f64s(z[j], simd.splat_f64s(inverses[j]));
            form = simd.mul_add_e_f64s(z[j], scaled, form);
            for i in j + 1..D {
                let factor = simd.splat_f64s(lower[i * D + j]);
                z[i] = simd.negate_mul_add_e_f64s(factor, z[j], z[i]);
            }
        }
        self.or_nan(simd.equal_f64s(form, form), form)
    }

    /// NaN in the lanes that are not `fair`, or where the form is infinite.
    #[inline(always)]
    fn or_nan(&self, fair: S::m64s, form: S::f64s) -> S::f64s {
        let simd = self.simd;
        let finite = simd.less_than_f64s(form, simd.splat_f64s(f64::INFINITY));
        simd.select_f64s(simd.and_m64s(fair, finite), form, simd.splat_f64s(f64::NAN))
    }

    /// Averages the two triangles where they differ at all; returns the lanes that are symmetric.
    #[inline(always)]
    fn average(&mut self) -> S::m64s {
        let (simd, p) = (self.simd, &self.p.0);
        let zero = simd.splat_u64s(0);
        let mut differing = zero;
        for i in 0..D {
            for j in 0..i {
                let below = simd.transmute_u64s_f64s(p[i][j]);
                let above = simd.transmute_u64s_f64s(p[j][i]);
                differing = simd.or_u64s(differing, simd.xor_u64s(below, above));
            }
        }
        let different = simd.greater_than_u64s(differing, zero);
        if simd.first_true_m64s(different) >= S::F64_LANES {
            return simd.equal_u64s(differing, zero);
        }
        self.average_differing()
    }

    #[inline(always)]
    fn average_differing(&mut self) -> S::m64s {
        let (simd, p) = (self.simd, &mut self.p.0);
        let (half, symmetry) = (simd.splat_f64s(0.5), simd.splat_f64s(self.symmetry));
        let mut deviations = [half; D];
        for i in 0..D {
            deviations[i] = simd.sqrt_f64s(simd.abs_f64s(p[i][i]));
        }
        let mut symmetric = simd.equal_f64s(half, half);
        for i in 0..D {
            let scale = simd.mul_f64s(symmetry, deviations[i]);
            for j in 0..i {
                let difference = simd.sub_f64s(p[j][i], p[i][j]);
                let bound = simd.mul_f64s(scale, deviations[j]);
                let within = simd.less_than_or_equal_f64s(simd.abs_f64s(difference), bound);
                symmetric = simd.and_m64s(symmetric, within);
                p[i][j] = simd.mul_add_e_f64s(half, difference, p[i][j]);
            }
        }
        symmetric
    }
}
