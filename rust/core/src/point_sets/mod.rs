//! Distances between finite sets of points.

pub mod cutoff;
pub mod distances;
mod extreme;
pub mod gospa;
mod large;
mod lowest;
mod matching;
mod near;
pub mod ospa;
pub mod pairs;
mod rows;
pub mod sets;
mod tiny;
mod unique;
