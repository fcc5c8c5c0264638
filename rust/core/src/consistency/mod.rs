//! Quadratic forms of many small covariances.

mod judge;
mod lanes;
pub mod quadratic_form;
