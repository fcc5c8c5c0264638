//! Distances between sets of trajectories.

pub mod ospa2;

use crate::error::{Error, Result};
use crate::points::Frames;

/// Trajectories with holes: the states of each, and the steps of a common clock at which they stand.
#[derive(Debug, Clone, Copy)]
pub struct Trajectories<'a> {
    states: Frames<'a>,
    steps: &'a [i64],
}

impl<'a> Trajectories<'a> {
    /// The trajectories whose states are the sets of `states`; `steps` holds one step for each
    /// state, and rises within each trajectory.
    ///
    /// # Errors
    /// [`Error::Offsets`] where there are more or fewer steps than states, [`Error::Steps`] for the
    /// first trajectory whose steps do not rise.
    pub fn new(argument: &'static str, states: Frames<'a>, steps: &'a [i64]) -> Result<Self> {
        if states.points() != steps.len() {
            return Err(Error::Offsets { argument, points: steps.len() });
        }
        let trajectories = Self { states, steps };
        let rises = |i: &usize| trajectories.steps(*i).windows(2).all(|pair| pair[0] < pair[1]);
        match (0..states.len()).find(|i| !rises(i)) {
            Some(index) => Err(Error::Steps { argument, index }),
            None => Ok(trajectories),
        }
    }

    /// How many trajectories.
    pub fn len(&self) -> usize {
        self.states.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The steps at which trajectory `i` exists.
    #[inline]
    pub fn steps(&self, i: usize) -> &'a [i64] {
        &self.steps[self.states.range(i)]
    }

    /// The state of trajectory `i` at its `k`-th step.
    #[inline]
    pub fn state(&self, i: usize, k: usize) -> &'a [f64] {
        self.states.frame(i).point(k)
    }
}
