//! Distances between finite sets of points.

pub mod cutoff;
pub mod distances;
mod extreme;
pub mod frames;
pub mod gospa;
mod large;
mod lowest;
mod matching;
mod near;
pub mod ospa;
mod pairs;
pub mod results;
mod rows;
pub mod sets;
mod tiny;
mod unique;
