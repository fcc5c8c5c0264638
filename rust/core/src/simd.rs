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
