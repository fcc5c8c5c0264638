//! Distances between finite sets of points.

pub mod cutoff;
pub mod distances;
mod extreme;
pub mod gospa;
mod matching;
pub mod ospa;
pub mod pairs;
mod rows;
pub mod sets;
mod tiny;
mod unique;
