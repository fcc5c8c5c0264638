//! The likelihood of a segment of chi-square values with one unknown scale, in code that compiles
//! to vector instructions.
//!
//! For values with sum N and degrees of freedom M together, the best scale is N / M, and twice the
//! maximal log-likelihood is, up to terms of the data alone, -M ln(N / M).

/// Ratio below which a segment of values that vanish is held, so that its logarithm exists.
const FLOOR: f64 = 1e-12;

/// -M ln(N / M).
#[inline(always)]
pub(super) fn best(sum: f64, dof: f64) -> f64 {
    let ratio = sum / dof;
    -dof * ln(if ratio > FLOOR { ratio } else { FLOOR })
}

/// The natural logarithm of a positive, normal number, within one unit in the last place.
///
/// The method of fdlibm's `log` without its branches: x = 2^e (1 + f) with 1 + f between sqrt(1/2)
/// and sqrt(2), s = f / (2 + f), and a polynomial in s^2.
#[inline(always)]
fn ln(x: f64) -> f64 {
    const ROOT_HALF: u64 = 0x3fe6_a09e_667f_3bcd;
    const ONE: u64 = 0x3ff0_0000_0000_0000;
    const TWO_TO_52: u64 = 0x4330_0000_0000_0000;
    let shifted = x.to_bits().wrapping_add(ONE - ROOT_HALF);
    let mantissa = (shifted & 0x000f_ffff_ffff_ffff).wrapping_add(ROOT_HALF);
    let e = f64::from_bits((shifted >> 52) | TWO_TO_52) - (4_503_599_627_370_496.0 + 1023.0);
    let f = f64::from_bits(mantissa) - 1.0;
    let s = f / (2.0 + f);
    let half = 0.5 * f * f;
    e * LN2_HIGH - ((half - (s * (half + series(s * s)) + e * LN2_LOW)) - f)
}

const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// fdlibm's minimax polynomial for log(1 + f) - 2 s, in z = s^2.
#[inline(always)]
fn series(z: f64) -> f64 {
    const C: [f64; 7] = [
        6.666_666_666_666_735e-1,
        3.999_999_999_940_942e-1,
        2.857_142_874_366_239e-1,
        2.222_219_843_214_978_4e-1,
        1.818_357_216_161_805e-1,
        1.531_383_769_920_937_3e-1,
        1.479_819_860_511_658_6e-1,
    ];
    C.iter().rev().fold(0.0, |sum, c| (sum + c) * z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_logarithm_is_that_of_the_library() {
        for k in -400..400 {
            for m in 0..50 {
                let x = 2f64.powi(k) * (1.0 + f64::from(m) / 50.0);
                assert!((ln(x) - x.ln()).abs() <= 3e-16 * x.ln().abs().max(1e-3), "{x}");
            }
        }
    }
}
