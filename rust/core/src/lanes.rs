//! Many small records at once: one record in each lane of a vector.
//!
//! Records (vectors of an error, covariances) lie one after the other in memory. A kernel that works
//! on as many records as a vector has lanes needs them transposed: element i of every record in one
//! vector. Loading element by element would cost more than the arithmetic; so whole vectors are
//! loaded and transposed in registers, in blocks of four elements.

use crate::simd::{Width, limit};
use pulp::{Arch, Simd, WithSimd};
#[cfg(target_arch = "x86_64")]
use pulp::{
    cast,
    x86::{V3, V4},
};

/// Loads records transposed.
pub trait Load<S: Simd>: Copy {
    /// Element `i` of record `l` in lane `l` of vector `i`, for as many records of `E` elements as
    /// there are lanes; `records` holds at least those.
    fn load<const E: usize>(self, simd: S, records: &[f64]) -> [S::f64s; E];
}

/// What [`dispatch`] runs: a kernel over lanes of any width.
pub trait WithLanes {
    /// What comes out.
    type Output;
    /// The kernel; to be marked `#[inline(always)]`, so that it is compiled for the width.
    fn with_lanes<S: Simd, L: Load<S>>(self, simd: S, load: L) -> Self::Output;
}

/// Runs `operation` compiled for the widest vector units that the machine has and the limit allows.
#[inline]
pub fn dispatch<Op: WithLanes>(operation: Op) -> Op::Output {
    let limit = limit();
    #[cfg(target_arch = "x86_64")]
    {
        if limit == Width::Widest
            && let Some(simd) = V4::try_new()
        {
            return Simd::vectorize(simd, On(operation, simd));
        }
        if limit != Width::Scalar
            && let Some(simd) = V3::try_new()
        {
            return Simd::vectorize(simd, On(operation, simd));
        }
    }
    if limit == Width::Widest {
        return Arch::new().dispatch(Gathered(operation));
    }
    Gathered(operation).with_simd(pulp::Scalar::new())
}

/// An operation with the vector units it is compiled for, whose registers it may transpose.
#[cfg(target_arch = "x86_64")]
struct On<Op, S>(Op, S);

#[cfg(target_arch = "x86_64")]
impl<Op: WithLanes, Own: Simd> WithSimd for On<Op, Own>
where
    Transposed: Load<Own>,
{
    type Output = Op::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Op::Output {
        self.0.with_lanes(self.1, Transposed)
    }
}

/// An operation on vector units whose registers are filled element by element.
struct Gathered<Op>(Op);

impl<Op: WithLanes> WithSimd for Gathered<Op> {
    type Output = Op::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Op::Output {
        self.0.with_lanes(simd, Each)
    }
}

/// Fills a vector element by element.
#[derive(Clone, Copy)]
struct Each;

impl<S: Simd> Load<S> for Each {
    #[inline(always)]
    fn load<const E: usize>(self, simd: S, records: &[f64]) -> [S::f64s; E] {
        let mut vectors = [simd.splat_f64s(0.0); E];
        for (i, vector) in vectors.iter_mut().enumerate() {
            let mut column = [0.0; 64];
            for (l, value) in column[..S::F64_LANES].iter_mut().enumerate() {
                *value = records[l * E + i];
            }
            *vector = simd.partial_load_f64s(&column[..S::F64_LANES]);
        }
        vectors
    }
}

/// Loads rows and transposes them in registers.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy)]
struct Transposed;

/// Four consecutive elements.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn four(records: &[f64], from: usize) -> std::arch::x86_64::__m256d {
    let values = &records[from..from + 4];
    cast([values[0], values[1], values[2], values[3]])
}

/// The first element of each block of four, so that blocks cover `E` elements; the last may overlap
/// the one before it. `None` where the element is better loaded by itself.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
const fn block<const E: usize>(at: usize) -> Option<usize> {
    if at + 4 <= E {
        Some(at)
    } else if E >= 4 && E - at >= 2 {
        Some(E - 4)
    } else {
        None
    }
}

#[cfg(target_arch = "x86_64")]
impl Load<V3> for Transposed {
    #[inline(always)]
    fn load<const E: usize>(self, simd: V3, records: &[f64]) -> [pulp::f64x4; E] {
        let records = &records[..4 * E];
        let mut vectors = [pulp::f64x4(0.0, 0.0, 0.0, 0.0); E];
        let mut at = 0;
        while at < E {
            if let Some(from) = block::<E>(at) {
                vectors[from..from + 4].copy_from_slice(&transpose4(simd, records, from, E));
                at = from + 4;
            } else {
                vectors[at] = pulp::f64x4(
                    records[at],
                    records[E + at],
                    records[2 * E + at],
                    records[3 * E + at],
                );
                at += 1;
            }
        }
        vectors
    }
}

/// Elements `from .. from + 4` of four records of `size` elements, one vector each.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn transpose4(simd: V3, records: &[f64], from: usize, size: usize) -> [pulp::f64x4; 4] {
    let avx = simd.avx;
    let a = four(records, from);
    let b = four(records, size + from);
    let c = four(records, 2 * size + from);
    let d = four(records, 3 * size + from);
    let low = [avx._mm256_unpacklo_pd(a, b), avx._mm256_unpacklo_pd(c, d)];
    let high = [avx._mm256_unpackhi_pd(a, b), avx._mm256_unpackhi_pd(c, d)];
    [
        cast(avx._mm256_permute2f128_pd::<0x20>(low[0], low[1])),
        cast(avx._mm256_permute2f128_pd::<0x20>(high[0], high[1])),
        cast(avx._mm256_permute2f128_pd::<0x31>(low[0], low[1])),
        cast(avx._mm256_permute2f128_pd::<0x31>(high[0], high[1])),
    ]
}

#[cfg(target_arch = "x86_64")]
impl Load<V4> for Transposed {
    #[inline(always)]
    fn load<const E: usize>(self, simd: V4, records: &[f64]) -> [pulp::f64x8; E] {
        let records = &records[..8 * E];
        let mut vectors = [simd.splat_f64x8(0.0); E];
        let mut at = 0;
        while at < E {
            if let Some(from) = block::<E>(at) {
                vectors[from..from + 4].copy_from_slice(&transpose8(simd, records, from, E));
                at = from + 4;
            } else {
                vectors[at] = pulp::f64x8(
                    records[at],
                    records[E + at],
                    records[2 * E + at],
                    records[3 * E + at],
                    records[4 * E + at],
                    records[5 * E + at],
                    records[6 * E + at],
                    records[7 * E + at],
                );
                at += 1;
            }
        }
        vectors
    }
}

/// Elements `from .. from + 4` of eight records of `size` elements, one vector each.
///
/// Records l and l + 4 share a register, so that two transpositions of four by four run at once.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn transpose8(simd: V4, records: &[f64], from: usize, size: usize) -> [pulp::f64x8; 4] {
    let avx = simd.avx512f;
    let a = pair(simd, records, from, size);
    let b = pair(simd, records, size + from, size);
    let c = pair(simd, records, 2 * size + from, size);
    let d = pair(simd, records, 3 * size + from, size);
    let low = [avx._mm512_unpacklo_pd(a, b), avx._mm512_unpacklo_pd(c, d)];
    let high = [avx._mm512_unpackhi_pd(a, b), avx._mm512_unpackhi_pd(c, d)];
    let first = cast([0u64, 1, 8, 9, 4, 5, 12, 13]);
    let second = cast([2u64, 3, 10, 11, 6, 7, 14, 15]);
    [
        cast(avx._mm512_permutex2var_pd(low[0], first, low[1])),
        cast(avx._mm512_permutex2var_pd(high[0], first, high[1])),
        cast(avx._mm512_permutex2var_pd(low[0], second, low[1])),
        cast(avx._mm512_permutex2var_pd(high[0], second, high[1])),
    ]
}

/// Four elements of one record, and the same four of the fourth record after it.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn pair(simd: V4, records: &[f64], from: usize, size: usize) -> std::arch::x86_64::__m512d {
    let avx = simd.avx512f;
    let low = avx._mm512_castpd256_pd512(four(records, from));
    avx._mm512_insertf64x4::<1>(low, four(records, from + 4 * size))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::set_width;

    struct Check<const E: usize>;

    impl<const E: usize> WithLanes for Check<E> {
        type Output = usize;

        #[inline(always)]
        fn with_lanes<S: Simd, L: Load<S>>(self, simd: S, load: L) -> usize {
            let records: Vec<f64> = (0..S::F64_LANES * E).map(|i| i as f64).collect();
            for (i, vector) in load.load::<E>(simd, &records).into_iter().enumerate() {
                let mut lanes = [0.0; 64];
                simd.partial_store_f64s(&mut lanes[..S::F64_LANES], vector);
                for (l, &value) in lanes[..S::F64_LANES].iter().enumerate() {
                    assert_eq!(value, (l * E + i) as f64, "element {i} of record {l} of {E}");
                }
            }
            S::F64_LANES
        }
    }

    fn check_all() {
        dispatch(Check::<1>);
        dispatch(Check::<2>);
        dispatch(Check::<3>);
        dispatch(Check::<4>);
        dispatch(Check::<5>);
        dispatch(Check::<6>);
        dispatch(Check::<7>);
        dispatch(Check::<9>);
        dispatch(Check::<16>);
        dispatch(Check::<25>);
        dispatch(Check::<81>);
    }

    #[test]
    fn every_element_arrives_in_its_lane() {
        for width in [Width::Scalar, Width::V3, Width::Widest] {
            set_width(width);
            check_all();
        }
    }
}
