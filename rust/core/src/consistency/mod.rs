//! Quadratic forms of many small covariances.

mod judge;
pub(crate) mod lanes;
pub mod quadratic_form;
