//! The hot parts of a diagnosis: where a scale changes, what a change must exceed to count, how
//! long an error is remembered, and which state it sits in.

pub mod attribution;
pub mod best_split;
pub mod cusum;
mod fixed;
mod gamma;
pub mod inflation;
mod likelihood;
mod noise_filter;
pub mod noise_likelihood;
mod optimal;
pub mod segmentation;
