//! Reductions over many runs, the same bits however the runs are cut into batches.

pub mod batch;
pub mod consistency;
mod elementwise;
pub mod histogram;
pub mod pairwise_tree;
mod reduce;
mod reduce_large_dimension;
mod run_block;
mod step_block;
