//! Scores over the identities of tracks.
//!
//! `sequence` holds truth and tracks, `similar_pairs` finds their similar rows in one pass, and
//! `clear_mot`, `identity` and `hota` score them; the assignment of a frame is in
//! `frame_assignment`.

pub mod clear_mot;
mod euclidean_matrix;
mod frame_assignment;
pub mod hota;
pub mod identity;
pub mod index_scores;
pub mod labels;
mod meetings;
mod pairwise_sum;
pub mod sequence;
pub mod similar_pairs;
