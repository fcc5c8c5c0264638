//! Distances between finite sets of points.

mod assignment_order;
mod cell_grid;
pub mod cost_source;
pub mod cutoff;
pub mod distances;
mod gated_matching;
pub mod gospa;
pub mod ospa;
pub mod results;
mod rows;
mod scaled_ospa;
mod sparse_matching;
mod tiny;
mod unique;
pub mod workspace;
