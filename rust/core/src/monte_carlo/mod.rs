//! Reductions over many runs, the same bits however the runs are cut into batches.

pub mod batch;
mod columns;
pub mod consistency;
mod group;
pub mod histogram;
mod large;
mod tile;
pub mod tree;
