//! How far estimates are from the truth.

pub mod rmse;
