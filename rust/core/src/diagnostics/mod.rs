//! The hot parts of a diagnosis: where a scale changes, what a change must exceed to count, how
//! long an error is remembered, and which state it sits in.

pub mod best_split;
pub mod cusum;
mod fixed;
mod gamma;
mod likelihood;
pub mod nees_autocorrelation;
mod noise_filter;
pub mod noise_likelihood;
mod noise_log;
mod optimal;
mod partitions;
pub mod segmentation;
pub mod shapley;
