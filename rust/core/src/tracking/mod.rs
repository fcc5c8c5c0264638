//! Scores over the identities of tracks.

mod euclidean_matrix;
pub mod index_scores;
pub mod labels;
