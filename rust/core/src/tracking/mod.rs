//! Scores over the identities of tracks.

mod distances;
pub mod frames;
pub mod labels;
