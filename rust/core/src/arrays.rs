//! Borrowed arrays of any number of axes, with the name that messages give them.

use crate::error::{Error, Result};
use crate::format::tuple;

/// A C-ordered array of floats.
#[derive(Debug, Clone, Copy)]
pub struct Array<'a> {
    argument: &'static str,
    values: &'a [f64],
    shape: &'a [usize],
}

impl<'a> Array<'a> {
    /// The array of this shape, last axis fastest.
    ///
    /// # Errors
    /// [`Error::Shape`] where the shape does not count the values.
    pub fn new(argument: &'static str, values: &'a [f64], shape: &'a [usize]) -> Result<Self> {
        if shape.iter().product::<usize>() != values.len() {
            let expected = format!("{} elements", values.len());
            return Err(Error::Shape { argument, found: shape.to_vec(), expected });
        }
        Ok(Self { argument, values, shape })
    }

    /// What messages call it.
    pub fn argument(&self) -> &'static str {
        self.argument
    }

    /// Its elements.
    pub fn values(&self) -> &'a [f64] {
        self.values
    }

    /// The lengths of its axes.
    pub fn shape(&self) -> &'a [usize] {
        self.shape
    }

    /// That its shape is not what was `expected`.
    pub(crate) fn misshapen(&self, expected: impl Into<String>) -> Error {
        let (argument, found) = (self.argument, self.shape.to_vec());
        Error::Shape { argument, found, expected: expected.into() }
    }

    /// # Errors
    /// [`Error::Shape`] where it does not have exactly the shape of `other`.
    pub(crate) fn require_shape(&self, other: &Array) -> Result<()> {
        if self.shape == other.shape {
            return Ok(());
        }
        Err(self.misshapen(tuple(other.shape)))
    }

    /// # Errors
    /// [`Error::Empty`] where it has no elements.
    pub(crate) fn require_elements(&self) -> Result<()> {
        match self.values {
            [] => Err(Error::Empty { argument: self.argument }),
            _ => Ok(()),
        }
    }
}

/// The index of an element, outermost axis first, from its place in an array of this shape.
pub(crate) fn unravel(place: usize, shape: &[usize]) -> Vec<usize> {
    let mut index = vec![0; shape.len()];
    let mut rest = place;
    for (i, &length) in index.iter_mut().zip(shape).rev() {
        (*i, rest) = (rest % length.max(1), rest / length.max(1));
    }
    index
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_unravel_last_axis_first() {
        assert_eq!(unravel(7, &[2, 3, 2]), [1, 0, 1]);
        assert_eq!(unravel(0, &[]), [0usize; 0]);
    }
}
