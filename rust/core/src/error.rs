//! What can be wrong with an argument, with the numbers that say where.
//!
//! The text of every message is written here once for Rust and once, to the letter, in the
//! package's `errors.py` for the NumPy reference implementations; a test holds the two against each other.

use crate::format::tuple;
use std::fmt;

/// The result of every fallible function of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// An argument that cannot be used, and the first place where it goes wrong.
#[derive(Debug, Clone, PartialEq)]
pub enum Error {
    /// A value that must be finite is not.
    NotFinite {
        /// The argument's name.
        argument: &'static str,
        /// Where in the argument, outermost index first.
        index: Vec<usize>,
        /// What stands there.
        value: f64,
    },
    /// A point has another number of coordinates than the points before it.
    Dimension {
        /// The argument's name.
        argument: &'static str,
        /// Where in the argument, outermost index first; empty for the whole argument.
        index: Vec<usize>,
        /// Its number of coordinates.
        found: usize,
        /// The number that the others have.
        expected: usize,
    },
    /// A number outside the range that the definition allows.
    Parameter {
        /// The argument's name.
        argument: &'static str,
        /// What it must be, as a phrase that follows "must be".
        requirement: &'static str,
        /// What it was.
        value: f64,
    },
    /// Two sequences that must be equally long are not.
    Length {
        /// The shorter or longer sequence.
        argument: &'static str,
        /// Its length.
        found: usize,
        /// The sequence it is held against.
        other: &'static str,
        /// That one's length.
        expected: usize,
        /// What is counted, in the plural.
        unit: &'static str,
    },
    /// An array has a shape that the function does not take.
    Shape {
        /// The argument's name.
        argument: &'static str,
        /// Its shape.
        found: Vec<usize>,
        /// What it should be, in words or as a tuple.
        expected: String,
    },
    /// An argument without elements, where a mean is asked for.
    Empty {
        /// The argument's name.
        argument: &'static str,
    },
    /// A number of an array outside the range that the definition allows.
    Element {
        /// The argument's name.
        argument: &'static str,
        /// Where in the argument, outermost index first.
        index: Vec<usize>,
        /// What it must be, as a phrase that follows "must be".
        requirement: &'static str,
        /// What it was.
        value: f64,
    },
    /// An axis that the array does not have, or that was named before.
    Axis {
        /// What it was.
        found: i64,
        /// How many axes the array has.
        axes: usize,
    },
    /// An index that is outside what it points into.
    Index {
        /// The argument's name.
        argument: &'static str,
        /// Which of the indices.
        place: usize,
        /// What it was.
        found: i64,
        /// How many components there are.
        length: usize,
    },
    /// A covariance whose two triangles disagree.
    NotSymmetric {
        /// The argument's name.
        argument: &'static str,
        /// Which covariance, outermost index first; empty where there is only one.
        index: Vec<usize>,
        /// The row of the first element that disagrees.
        row: usize,
        /// Its column.
        column: usize,
    },
    /// A covariance that is not positive definite.
    NotPositiveDefinite {
        /// The argument's name.
        argument: &'static str,
        /// Which covariance, outermost index first; empty where there is only one.
        index: Vec<usize>,
        /// The size of the first leading minor that is not positive.
        minor: usize,
    },
    /// Offsets of packed sets that do not rise from 0 to the number of points.
    Offsets {
        /// The argument's name.
        argument: &'static str,
        /// How many points there are.
        points: usize,
    },
    /// More pairs of points than fit into memory.
    Memory {
        /// How many pairs.
        pairs: usize,
        /// How many bytes they would take.
        bytes: usize,
    },
    /// The steps of a trajectory do not rise.
    Steps {
        /// The argument's name.
        argument: &'static str,
        /// Which trajectory.
        index: usize,
    },
    /// A cost matrix with an element that no assignment can use.
    InvalidCosts,
    /// A cost matrix in which every complete assignment has an infinite cost.
    Infeasible,
    /// One of many cost matrices cannot be used.
    Matrix {
        /// Which.
        index: usize,
        /// What is wrong with it.
        error: Box<Error>,
    },
    /// Whoever called the kernel asked it to stop.
    Interrupted,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite { argument, index, value } => {
                write!(f, "{argument}{} is not finite: {}", Place(index), Number(*value))
            }
            Self::Dimension { argument, index, found, expected } => {
                write!(f, "{argument}{} has {found} coordinates, expected {expected}", Place(index))
            }
            Self::Parameter { argument, requirement, value } => {
                write!(f, "{argument} must be {requirement}, got {}", Number(*value))
            }
            Self::Length { argument, found, other, expected, unit } => {
                write!(f, "{argument} has {found} {unit}, {other} has {expected}")
            }
            Self::Shape { argument, found, expected } => {
                write!(f, "{argument} has shape {}, expected {expected}", tuple(found))
            }
            Self::Empty { argument } => write!(f, "{argument} is empty"),
            Self::Element { argument, index, requirement, value } => {
                let (place, value) = (Place(index), Number(*value));
                write!(f, "{argument}{place} must be {requirement}, got {value}")
            }
            Self::Axis { found, axes } => {
                write!(f, "axis must be among the {axes} axes of the array, each once, got {found}")
            }
            Self::Index { argument, place, found, length } => {
                write!(f, "{argument}[{place}] is {found}, the state has {length} components")
            }
            Self::NotSymmetric { argument, index, row, column } => write!(
                f,
                "{argument}{} is not symmetric: elements [{row}, {column}] and [{column}, {row}] differ",
                Place(index)
            ),
            Self::NotPositiveDefinite { argument, index, minor } => write!(
                f,
                "{argument}{} is not positive definite (leading minor {minor})",
                Place(index)
            ),
            Self::Offsets { argument, points } => {
                write!(f, "{argument}: starts must rise from 0 to {points}, the number of points")
            }
            Self::Memory { pairs, bytes } => write!(
                f,
                "{pairs} pairs of points would take {bytes} bytes: take a smaller c or fewer points"
            ),
            Self::Steps { argument, index } => write!(f, "{argument}[{index}]: steps must rise"),
            Self::InvalidCosts => write!(f, "matrix contains invalid numeric entries"),
            Self::Infeasible => write!(f, "cost matrix is infeasible"),
            Self::Matrix { index, error } => write!(f, "costs[{index}]: {error}"),
            Self::Interrupted => write!(f, "interrupted"),
        }
    }
}

impl std::error::Error for Error {}

/// An index as Python writes it: `[3][1]`.
struct Place<'a>(&'a [usize]);

impl fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|i| write!(f, "[{i}]"))
    }
}

/// A float as Python's `repr` writes it.
struct Number(f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = self.0;
        if !value.is_finite() {
            let sign = if value < 0.0 { "-" } else { "" };
            return write!(f, "{sign}{}", if value.is_nan() { "nan" } else { "inf" });
        }
        if value == 0.0 || (1e-4..1e16).contains(&value.abs()) {
            return write!(f, "{value:?}");
        }
        let text = format!("{value:e}");
        let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        let (sign, size) = match exponent.strip_prefix('-') {
            Some(size) => ('-', size),
            None => ('+', exponent),
        };
        write!(f, "{digits}e{sign}{size:0>2}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_as_in_python() {
        for (value, text) in [
            (1.0, "1.0"),
            (-0.5, "-0.5"),
            (1e300, "1e+300"),
            (-1.5e-7, "-1.5e-07"),
            (1e16, "1e+16"),
            (123456.0, "123456.0"),
            (f64::NAN, "nan"),
            (f64::NEG_INFINITY, "-inf"),
        ] {
            assert_eq!(Number(value).to_string(), text);
        }
    }
}
