//! What the metrics share that look at frame after frame of two sequences.

use super::gated_matching;
use crate::assignment::dense;
use crate::error::{Error, Result};
use crate::points::Frames;

/// How many frames are handled between two questions whether to stop.
pub(super) const FRAMES_BETWEEN_CHECKS: usize = 64;

/// What one frame needs and the next frame can use again.
#[derive(Debug, Default)]
pub struct Workspace {
    pub(super) matching: gated_matching::Workspace,
    pub(super) exact: dense::Workspace,
}

/// Refuses sequences that do not fit together.
pub(super) fn check_sequences(x: Frames, y: Frames) -> Result<()> {
    let argument = "Y_sequence";
    if x.len() != y.len() {
        let (found, expected) = (y.len(), x.len());
        return Err(Error::Length {
            argument,
            found,
            other: "X_sequence",
            expected,
            unit: "frames",
        });
    }
    let (found, expected) = (y.dimension(), x.dimension());
    if !x.has_no_points() && !y.has_no_points() && found != expected {
        return Err(Error::Dimension { argument, index: Vec::new(), found, expected });
    }
    Ok(())
}

/// A piece is the time of about 100 000 pairs of points, some 100 us: tens of times what handing it
/// to a thread costs. A frame without any pair takes as long as 40.
pub(super) fn frames_per_piece(x: Frames, y: Frames) -> usize {
    const PAIRS: usize = 100_000;
    let frames = x.len().max(1);
    PAIRS / (40 + (x.points() / frames) * (y.points() / frames)) + 1
}
