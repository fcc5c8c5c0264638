//! How far estimates are from the truth.

pub mod rmse;
mod sums;

pub(crate) use sums::sum;
