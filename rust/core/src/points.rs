//! Borrowed point sets: checked once when they are made, trusted afterwards.
//!
//! A set of `n` points in `d` dimensions is the C-ordered `(n, d)` array that Python holds. Many
//! sets travel flat, with offsets: set `t` is the points `starts[t] .. starts[t + 1]`.

use crate::error::{Error, Result};
use crate::threads;

/// A finite set of points, all of the same dimension, all finite.
#[derive(Debug, Clone, Copy)]
pub struct Points<'a> {
    coordinates: &'a [f64],
    dimension: usize,
    /// Kept, since a division takes as long as some distances.
    len: usize,
}

impl<'a> Points<'a> {
    /// The set whose points are the rows of `coordinates`. A set without points has any dimension.
    ///
    /// # Errors
    /// [`Error::NotFinite`] names the first point with a coordinate that is NaN or infinite.
    pub fn new(argument: &'static str, coordinates: &'a [f64], dimension: usize) -> Result<Self> {
        match first_not_finite(coordinates) {
            None => {
                let len = coordinates.len().checked_div(dimension).unwrap_or(0);
                Ok(Self { coordinates, dimension, len })
            }
            Some(at) => Err(Error::NotFinite {
                argument,
                index: vec![at / dimension.max(1)],
                value: coordinates[at],
            }),
        }
    }

    /// How many points.
    #[inline]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is no point.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.coordinates.is_empty()
    }

    /// Coordinates of each point.
    #[inline]
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// All coordinates, point by point.
    #[inline]
    pub fn coordinates(&self) -> &'a [f64] {
        self.coordinates
    }

    /// The coordinates of one point.
    #[inline]
    pub fn point(&self, i: usize) -> &'a [f64] {
        &self.coordinates[i * self.dimension..(i + 1) * self.dimension]
    }
}

/// A sequence of point sets, packed.
#[derive(Debug, Clone, Copy)]
pub struct Frames<'a> {
    coordinates: &'a [f64],
    starts: &'a [i64],
    dimension: usize,
}

impl<'a> Frames<'a> {
    /// The sequence whose set `t` is the rows `starts[t] .. starts[t + 1]` of `coordinates`.
    ///
    /// # Errors
    /// [`Error::Offsets`] where `starts` does not rise from 0 to the number of points,
    /// [`Error::NotFinite`] with the frame and the point of the first offender.
    pub fn new(
        argument: &'static str,
        coordinates: &'a [f64],
        starts: &'a [i64],
        dimension: usize,
    ) -> Result<Self> {
        let points = coordinates.len().checked_div(dimension).unwrap_or(0);
        let rises = starts.first() == Some(&0)
            && starts.last() == Some(&(points as i64))
            && starts.is_sorted();
        if !rises {
            return Err(Error::Offsets { argument, points });
        }
        match first_not_finite(coordinates) {
            None => Ok(Self { coordinates, starts, dimension }),
            Some(at) => {
                let point = at / dimension;
                let frame = starts.partition_point(|&s| s as usize <= point) - 1;
                let within = point - starts[frame] as usize;
                Err(Error::NotFinite {
                    argument,
                    index: vec![frame, within],
                    value: coordinates[at],
                })
            }
        }
    }

    /// How many sets.
    #[inline]
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Whether there is no set.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether no set has a point.
    #[inline]
    pub fn has_no_points(&self) -> bool {
        self.coordinates.is_empty()
    }

    /// Coordinates of each point.
    #[inline]
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// How many points all sets have together.
    #[inline]
    pub fn points(&self) -> usize {
        self.starts[self.len()] as usize
    }

    /// Where one set stands among all points.
    #[inline]
    pub fn range(&self, t: usize) -> std::ops::Range<usize> {
        self.starts[t] as usize..self.starts[t + 1] as usize
    }

    /// One set.
    #[inline]
    pub fn frame(&self, t: usize) -> Points<'a> {
        let (from, to) = (self.starts[t] as usize, self.starts[t + 1] as usize);
        Points {
            coordinates: &self.coordinates[from * self.dimension..to * self.dimension],
            dimension: self.dimension,
            len: to - from,
        }
    }
}

/// The position of the first NaN or infinity.
///
/// Large arrays are looked at in parallel: what comes before a parallel kernel is what limits it.
pub(crate) fn first_not_finite(values: &[f64]) -> Option<usize> {
    const PIECE: usize = 1 << 17;
    if values.len() <= 2 * PIECE {
        return look(values);
    }
    let mut found = vec![None; values.len().div_ceil(PIECE)];
    let looked: std::result::Result<(), std::convert::Infallible> =
        threads::fill(&mut found, 2, |first, found| {
            for (piece, place) in (first..).zip(found) {
                let (from, to) = (piece * PIECE, values.len().min((piece + 1) * PIECE));
                *place = look(&values[from..to]).map(|i| from + i);
            }
            Ok(())
        });
    match looked {
        Ok(()) => found.into_iter().flatten().next(),
    }
}

/// The same on one thread.
///
/// One product a value: `0 x` is 0 for a finite `x` and NaN otherwise, so that a block's sum tells
/// whether it is worth a second look.
fn look(values: &[f64]) -> Option<usize> {
    const BLOCK: usize = 64;
    for (block, chunk) in values.chunks(BLOCK).enumerate() {
        let mut sums = [0.0; 8];
        let lanes = chunk.chunks_exact(8);
        let rest: f64 = lanes.remainder().iter().map(|x| 0.0 * x).sum();
        for lane in lanes {
            for (sum, x) in sums.iter_mut().zip(lane) {
                *sum += 0.0 * x;
            }
        }
        if sums.iter().sum::<f64>() + rest != 0.0 {
            return chunk.iter().position(|x| !x.is_finite()).map(|i| block * BLOCK + i);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_offender_is_found_wherever_it_stands() {
        for n in [1, 7, 8, 63, 64, 65, 200] {
            let mut values = vec![1e308; n];
            assert_eq!(first_not_finite(&values), None);
            for at in (0..n).rev() {
                values[at] = if at % 2 == 0 { f64::NAN } else { f64::NEG_INFINITY };
                assert_eq!(first_not_finite(&values), Some(at));
            }
        }
    }

    #[test]
    fn the_first_offender_of_a_large_array_is_found_by_any_number_of_threads() {
        let mut values = vec![1.0; 1_000_003];
        assert_eq!(first_not_finite(&values), None);
        for at in [1_000_002, 700_001, 131_072, 131_071, 0] {
            values[at] = f64::NAN;
            assert_eq!(first_not_finite(&values), Some(at));
        }
    }

    #[test]
    fn an_empty_frame_before_the_offender_is_counted() {
        let error = Frames::new("X", &[0.0, f64::NAN], &[0, 1, 1, 2], 1).unwrap_err();
        assert_eq!(error.to_string(), "X[2][0] is not finite: nan");
    }

    #[test]
    fn offsets_that_do_not_rise_are_refused() {
        for starts in [&[0i64, 3, 2][..], &[1, 2], &[0, 1], &[], &[0, -1, 2]] {
            assert!(Frames::new("X", &[0.0, 0.0], starts, 1).is_err(), "{starts:?}");
        }
    }
}
