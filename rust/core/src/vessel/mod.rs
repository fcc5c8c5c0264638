//! The five-state estimator of vessels: motion, measurement, the life of a track, gating.

pub mod earth;
pub mod filter;
pub mod gate;
pub mod lifecycle;
pub mod motion;
pub mod predict;
pub mod update;

pub use filter::{Reports, Rows, Tracks, filter};
pub use gate::{Pair, gate};
pub use lifecycle::Life;
pub use motion::Motion;
pub use predict::{Predicted, advance, predict};
