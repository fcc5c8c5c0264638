//! Metrics and consistency diagnostics for target tracking and state estimation.
//!
//! The modules, each importing only modules above it in this list:
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`error`], [`arrays`], [`points`], [`interrupt`], [`threads`], [`simd`] | errors with numbers in them; borrowed arrays and point sets; stopping a long kernel; the pool; vector units |
//! | [`assignment`] | which rows are matched with which columns, at the least total cost |
//! | [`point_sets`] | distances between finite sets of points |
//! | [`trajectories`] | distances between sets of trajectories |
//! | [`tracking`] | scores over the identities of tracks |
//! | [`accuracy`] | root mean square errors |
//! | [`vessel`] | the five-state estimator of vessels from AIS and positions |
//! | [`consistency`] | quadratic forms of many small covariances |
//! | [`diagnostics`] | where a scale changes, and which state an error sits in |
//! | [`monte_carlo`] | sums over many runs that do not depend on how they were cut |
//!
//! Nothing in this crate knows Python, draws random numbers, or panics on bad input: what can be
//! wrong with an argument is an [`Error`].

#![forbid(unsafe_code)]

pub mod accuracy;
pub mod arrays;
pub mod assignment;
pub mod consistency;
pub mod diagnostics;
pub mod error;
mod format;
pub mod interrupt;
pub mod monte_carlo;
pub mod point_sets;
pub mod points;
pub mod simd;
pub mod threads;
pub mod tracking;
pub mod trajectories;
pub mod vessel;

pub use arrays::Array;
pub use error::{Error, Result};
pub use points::{Frames, Points};
