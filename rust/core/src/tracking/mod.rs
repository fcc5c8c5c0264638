//! Scores over the identities of tracks.

pub mod frames;
pub mod labels;
