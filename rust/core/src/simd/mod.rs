//! Vector units: which one runs, and what the kernels share on it.
//!
//! [`dispatch`] chooses the width when the program runs; [`transpose`] loads one small record into
//! each lane; `argmin` finds the least of many numbers, `sums` adds them up in a fixed order.

pub(crate) mod argmin;
mod dispatch;
pub(crate) mod sums;
pub mod transpose;

pub use dispatch::*;
