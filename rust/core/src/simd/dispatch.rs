//! The width of the vector units, chosen when the program runs.
//!
//! A shipped library is compiled for the baseline of its platform; the kernels are written once
//! over [`pulp::Simd`] lanes and compiled for each width that `pulp` knows. This module decides
//! which one runs, and lets a bench or a test ask for a narrower one.

use pulp::{Arch, Simd, WithSimd};
use std::sync::atomic::{AtomicU8, Ordering};

static LIMIT: AtomicU8 = AtomicU8::new(Width::Widest as u8);

/// How wide the vector units that kernels use may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Width {
    /// No vector unit.
    Scalar,
    /// At most 256 bits: AVX2 and FMA.
    V3,
    /// Whatever the machine has.
    Widest,
}

/// Limits the width from now on.
pub fn set_width(width: Width) {
    LIMIT.store(width as u8, Ordering::Relaxed);
}

/// The limit in force.
pub(crate) fn limit() -> Width {
    match LIMIT.load(Ordering::Relaxed) {
        limit if limit == Width::Scalar as u8 => Width::Scalar,
        limit if limit == Width::V3 as u8 => Width::V3,
        _ => Width::Widest,
    }
}

/// Runs `operation` compiled for the widest vector units that the machine has and the limit allows.
#[inline]
pub fn dispatch<Op: WithSimd>(operation: Op) -> Op::Output {
    let limit = LIMIT.load(Ordering::Relaxed);
    if limit == Width::Widest as u8 {
        return Arch::new().dispatch(operation);
    }
    #[cfg(target_arch = "x86_64")]
    if limit == Width::V3 as u8
        && let Some(simd) = pulp::x86::V3::try_new()
    {
        return Simd::vectorize(simd, operation);
    }
    operation.with_simd(pulp::Scalar::new())
}

/// The lanes of the widest vector unit: arrays are padded to a multiple of it, so that their layout
/// does not depend on the machine.
pub(crate) const MAX_LANES: usize = 8;

/// The numbers of the lanes.
pub(crate) const LANE: [f64; MAX_LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

/// Lowers one of many numbers.
///
/// A whole vector is written, by a minimum: what loads it next would have to wait for a store of one
/// lane, and into that a compiler would turn a selection.
#[inline(always)]
pub(crate) fn lower<S: Simd>(simd: S, values: &mut [S::f64s], index: usize, to: f64) {
    let lane = lane(simd, index, to, f64::INFINITY);
    let vector = &mut values[index / S::F64_LANES];
    // The second operand is what a NaN leaves as it is.
    *vector = simd.min_f64s(lane, *vector);
}

/// Raises one of many numbers; see [`lower`].
#[inline(always)]
pub(crate) fn raise<S: Simd>(simd: S, values: &mut [S::f64s], index: usize, to: f64) {
    let lane = lane(simd, index, to, f64::NEG_INFINITY);
    let vector = &mut values[index / S::F64_LANES];
    *vector = simd.max_f64s(lane, *vector);
}

/// A whole number below 2^32 as one, without the questions that `as` asks: they take as long as a
/// pass over some vectors.
#[inline(always)]
pub(crate) fn small_integer(value: f64) -> usize {
    const LAST_PLACE_IS_ONE: f64 = 4_503_599_627_370_496.0;
    (value + LAST_PLACE_IS_ONE).to_bits() as u32 as usize
}

/// A vector of one number in the lane of this index, and another in all others.
#[inline(always)]
fn lane<S: Simd>(simd: S, index: usize, value: f64, others: f64) -> S::f64s {
    let wanted = simd.splat_f64s((index % S::F64_LANES) as f64);
    let here = simd.equal_f64s(S::as_simd_f64s(&LANE).0[0], wanted);
    simd.select_f64s(here, simd.splat_f64s(value), simd.splat_f64s(others))
}

/// What [`dispatch`] runs on at the moment, by name.
pub fn width() -> &'static str {
    struct Name;
    impl WithSimd for Name {
        type Output = usize;
        fn with_simd<S: Simd>(self, _: S) -> usize {
            S::F64_LANES
        }
    }
    match dispatch(Name) {
        8 => "avx512",
        4 => "avx2",
        2 => "128-bit",
        _ => "scalar",
    }
}
