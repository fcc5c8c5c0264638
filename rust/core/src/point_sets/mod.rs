//! Distances between finite sets of points.

pub mod ospa;
