//! The columns of a run: elementwise work on as many of its steps as there are lanes.

use crate::simd::transpose::lanes;
use pulp::{Simd, WithSimd, bytemuck};

/// Columns of each step that do not belong to one state.
pub const FORM_COLUMNS: usize = 4;
/// Columns of each state.
pub const STATE_COLUMNS: usize = 3;

/// Brings the errors of angles into (-period / 2, period / 2]; a period of 0 is no angle.
#[inline(always)]
pub(super) fn wrap<V: bytemuck::Pod>(errors: &mut [V], periods: &[f64]) {
    for (error, &period) in errors.iter_mut().zip(periods).filter(|(_, period)| **period > 0.0) {
        for x in lanes(error) {
            *x -= period * (*x / period - 0.5).ceil();
        }
    }
}

/// 10 log10 of every lane.
#[inline(always)]
pub(super) fn decibels<V: bytemuck::Pod>(mut forms: V) -> V {
    for x in lanes(&mut forms) {
        *x = DECIBELS * ln(*x);
    }
    forms
}

/// 10 / ln 10.
const DECIBELS: f64 = 10.0 * std::f64::consts::LOG10_E;

/// The natural logarithm of a number that is not negative, to about one unit in the last place,
/// without a call or a branch, so that a loop over it becomes one over vectors.
///
/// With x = 2^k m, m in [1/sqrt 2, sqrt 2), and s = (m - 1) / (m + 1): ln x = k ln 2 + 2 atanh s. The
/// polynomial of atanh is the one of FreeBSD's `e_log.c` (Sun Microsystems, 1993).
#[inline(always)]
pub(super) fn ln(x: f64) -> f64 {
    const MAGIC: u64 = 0x4330_0000_0000_0000; // 2^52, whose last bits count units
    const SUBNORMAL: f64 = f64::MIN_POSITIVE;
    const SQRT_HALF: u64 = 0x3fe6_a09e_667f_3bcd;
    const LN2_HI: f64 = 6.931_471_803_691_238e-1;
    const LN2_LO: f64 = 1.908_214_929_270_587_7e-10;
    let small = x < SUBNORMAL;
    let scaled = if small { x * 18_014_398_509_481_984.0 } else { x }; // 2^54
    let shifted = scaled.to_bits().wrapping_sub(SQRT_HALF).wrapping_add(1023 << 52);
    let exponent = f64::from_bits(MAGIC | (shifted >> 52)) - 4_503_599_627_370_496.0 - 1023.0;
    let k = if small { exponent - 54.0 } else { exponent };
    let m = f64::from_bits((shifted & ((1 << 52) - 1)) + SQRT_HALF);
    let f = m - 1.0;
    let s = f / (2.0 + f);
    let z = s * s;
    let w = z * z;
    let even = w
        * (0.399_999_999_994_094_2 + w * (0.222_221_984_321_497_84 + w * 0.153_138_376_992_093_73));
    let odd = z
        * (0.666_666_666_666_673_5
            + w * (0.285_714_287_436_623_9
                + w * (0.181_835_721_616_180_5 + w * 0.147_981_986_051_165_86)));
    let half = 0.5 * f * f;
    let result = k * LN2_HI - ((half - (s * (half + even + odd) + k * LN2_LO)) - f);
    let result = if x == 0.0 { f64::NEG_INFINITY } else { result };
    if x == f64::INFINITY { x } else { result }
}

/// Adds a row to another.
pub(super) struct Add<'a> {
    /// The sum.
    pub(super) left: &'a mut [f64],
    /// What is added.
    pub(super) right: &'a [f64],
}

impl WithSimd for Add<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for (sum, x) in self.left.iter_mut().zip(self.right) {
            *sum += x;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_logarithm_is_right_to_two_units_in_the_last_place() {
        let mut x = f64::MIN_POSITIVE * 1e-10;
        while x < 1e308 {
            let (found, expected) = (ln(x), x.ln());
            assert!((found - expected).abs() <= 2.0 * f64::EPSILON * expected.abs(), "{x:e}");
            x *= 1.000_73;
        }
        for near in -2000..2000 {
            let x = 1.0 + f64::from(near) * 1e-5;
            assert!((ln(x) - x.ln()).abs() <= 2.0 * f64::EPSILON * x.ln().abs(), "{x}");
        }
        assert_eq!(ln(1.0), 0.0);
        assert_eq!(ln(0.0), f64::NEG_INFINITY);
        assert_eq!(ln(f64::INFINITY), f64::INFINITY);
    }
}
