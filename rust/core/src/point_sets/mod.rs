//! Distances between finite sets of points.

pub mod cutoff;
mod extreme;
mod matching;
pub mod ospa;
mod rows;
mod tiny;
