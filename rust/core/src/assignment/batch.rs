//! Many dense assignment problems at once, in parallel.
//!
//! Each is solved as [`dense`](super::dense) solves it; the pairs do not depend on the number of
//! threads.

use super::dense::{Goal, Workspace, solve_until};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::threads::fill_until;

/// A C-ordered cost matrix and its shape.
#[derive(Debug, Clone, Copy)]
pub struct Matrix<'a> {
    /// The elements.
    pub costs: &'a [f64],
    /// How many rows.
    pub rows: usize,
    /// How many columns.
    pub columns: usize,
}

/// The matched rows of a matrix, rising, and the column of each.
pub type Pairs = (Vec<i64>, Vec<i64>);

/// Elements that are worth a thread's attention: about half a millisecond of work.
const WORTHWHILE: usize = 1 << 17;

/// The pairs of each matrix.
///
/// # Errors
/// [`Error::Matrix`] with the error and the index of the first matrix that cannot be solved;
/// [`Error::Interrupted`].
pub fn solve_batch(
    matrices: &[Matrix<'_>],
    goal: Goal,
    interrupt: &Interrupt<'_>,
) -> Result<Vec<Pairs>> {
    let mut output = vec![Pairs::default(); matrices.len()];
    let elements: usize = matrices.iter().map(|matrix| matrix.costs.len()).sum();
    let least = matrices.len().saturating_mul(WORTHWHILE) / elements.max(1);
    fill_until(&mut output, least.max(1), interrupt, |first, output| {
        let mut work = Workspace::default();
        let mut spent = 0;
        for (index, pairs) in output.iter_mut().enumerate() {
            let Matrix { costs, rows, columns } = matrices[first + index];
            if spent >= WORTHWHILE {
                interrupt.check()?;
                spent = 0;
            }
            spent += costs.len();
            let solved = solve_until(costs, rows, columns, goal, interrupt, &mut work);
            *pairs = super::pairs(solved.map_err(|error| at(first + index, error))?);
        }
        Ok(())
    })?;
    Ok(output)
}

/// Says which matrix an error is about.
fn at(index: usize, error: Error) -> Error {
    match error {
        Error::Interrupted => error,
        _ => Error::Matrix { index, error: Box::new(error) },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_matrix_that_cannot_be_solved_is_named() {
        let good = Matrix { costs: &[1.0, 2.0], rows: 1, columns: 2 };
        let bad = Matrix { costs: &[f64::NAN], rows: 1, columns: 1 };
        let solve = |matrices: &[Matrix<'_>]| {
            solve_batch(matrices, Goal::Largest, &Interrupt::never()).map_err(|e| e.to_string())
        };
        assert_eq!(solve(&[good, good]), Ok(vec![(vec![0], vec![1]); 2]));
        let text = "costs[1]: matrix contains invalid numeric entries";
        assert_eq!(solve(&[good, bad, bad]), Err(text.to_owned()));
        assert_eq!(solve(&[]), Ok(vec![]));
    }
}
