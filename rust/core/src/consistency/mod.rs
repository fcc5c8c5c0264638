//! Quadratic forms of many small covariances.

pub(crate) mod batched_ldl;
mod checked_ldl;
pub mod quadratic_form;
