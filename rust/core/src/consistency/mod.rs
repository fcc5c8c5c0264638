//! Quadratic forms of many small covariances.

pub mod quadratic_form;
