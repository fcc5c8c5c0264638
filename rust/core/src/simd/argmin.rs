//! The least of many numbers, in lanes.

use crate::simd::{LANE, small_integer};
use pulp::Simd;

/// The least of many numbers below a bound, and the first place where it stands.
#[derive(Clone, Copy)]
pub(crate) struct Lowest<S: Simd> {
    value: S::f64s,
    /// Where each lane's least value stands.
    place: S::f64s,
    here: S::f64s,
    step: S::f64s,
}

impl<S: Simd> Lowest<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, bound: f64) -> Self {
        let first = S::as_simd_f64s(&LANE).0[0];
        Self {
            value: simd.splat_f64s(bound),
            place: first,
            here: first,
            step: simd.splat_f64s(S::F64_LANES as f64),
        }
    }

    /// Looks at the next vector of numbers.
    #[inline(always)]
    pub(crate) fn take(&mut self, simd: S, values: S::f64s) {
        let less = simd.less_than_f64s(values, self.value);
        // Not a selection by `less`: from one vector to the next only this one is waited for.
        self.value = simd.min_f64s(values, self.value);
        self.place = simd.select_f64s(less, self.here, self.place);
        self.here = simd.add_f64s(self.here, self.step);
    }

    /// The least value; the bound where none is below.
    #[inline(always)]
    pub(crate) fn least(&self, simd: S) -> f64 {
        simd.reduce_min_f64s(self.value)
    }

    /// The first place of the least value; some place, where none is below the bound.
    #[inline(always)]
    pub(crate) fn place(&self, simd: S, least: f64) -> usize {
        let here = simd.equal_f64s(self.value, simd.splat_f64s(least));
        let places = simd.select_f64s(here, self.place, simd.splat_f64s(f64::INFINITY));
        small_integer(simd.reduce_min_f64s(places))
    }
}
