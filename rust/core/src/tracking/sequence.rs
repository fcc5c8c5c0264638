//! Truth and tracks of one sequence, and the pairs of their rows that are similar at all.
//!
//! Rows stand frame by frame: frame `t` of a side has its rows `starts[t] .. starts[t + 1]`. The id of a
//! row is a code `0 .. names`. Pairs are listed truth row by truth row, with the track rows of the
//! same frame in rising order.

use crate::error::{Error, Result};
use std::ops::Range;

/// The rows of one side.
#[derive(Debug, Clone, Copy)]
pub struct Side<'a> {
    /// The code of each row's id.
    pub ids: &'a [i64],
    /// How many ids there are.
    pub names: usize,
    starts: &'a [i64],
}

impl<'a> Side<'a> {
    /// The side with these codes and offsets of frames.
    ///
    /// # Errors
    /// [`Error::Offsets`] where `starts` does not rise from 0 to the number of rows,
    /// [`Error::Element`] for a code outside `0 .. names`.
    pub fn new(
        argument: &'static str,
        ids: &'a [i64],
        starts: &'a [i64],
        names: usize,
    ) -> Result<Self> {
        check_offsets(argument, starts, ids.len())?;
        let code = |id: &i64| usize::try_from(*id).is_ok_and(|id| id < names);
        if let Some(row) = ids.iter().position(|id| !code(id)) {
            let (index, value) = (vec![row], ids[row] as f64);
            let requirement = "at least 0 and below the number of ids";
            return Err(Error::Element { argument, index, requirement, value });
        }
        Ok(Self { ids, names, starts })
    }

    /// How many rows.
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    /// The rows of one frame.
    #[inline]
    pub fn rows(&self, t: usize) -> Range<usize> {
        self.starts[t] as usize..self.starts[t + 1] as usize
    }

    /// How many rows each id has.
    pub(super) fn rows_of_ids(&self) -> Vec<usize> {
        let mut counts = vec![0; self.names];
        self.ids.iter().for_each(|&id| counts[id as usize] += 1);
        counts
    }
}

/// Both sides.
#[derive(Debug, Clone, Copy)]
pub struct Sequence<'a> {
    /// The truth.
    pub truth: Side<'a>,
    /// The tracks.
    pub tracks: Side<'a>,
}

impl<'a> Sequence<'a> {
    /// Both sides of the same frames.
    ///
    /// # Errors
    /// [`Error::Length`] where one has more frames.
    pub fn new(truth: Side<'a>, tracks: Side<'a>) -> Result<Self> {
        let (found, expected) = (tracks.starts.len() - 1, truth.starts.len() - 1);
        if found != expected {
            let (argument, other, unit) = ("tracks", "truth", "frames");
            return Err(Error::Length { argument, found, other, expected, unit });
        }
        Ok(Self { truth, tracks })
    }

    /// How many frames.
    pub fn frames(&self) -> usize {
        self.truth.starts.len() - 1
    }

    /// The rows of truth and tracks of each frame.
    pub(super) fn slices(&self) -> impl Iterator<Item = (Range<usize>, Range<usize>)> {
        (0..self.frames()).map(|t| (self.truth.rows(t), self.tracks.rows(t)))
    }
}

/// The listed pairs of a sequence.
#[derive(Debug, Clone, Copy)]
pub struct SimilarPairs<'a> {
    starts: &'a [i64],
    /// The track row of each pair.
    pub columns: &'a [i64],
    /// The similarity of each pair, in [0, 1].
    pub similarities: &'a [f64],
    /// The distance of each pair.
    pub distances: &'a [f64],
}

impl<'a> SimilarPairs<'a> {
    /// Pairs of a sequence: those of truth row `i` are `starts[i] .. starts[i + 1]`.
    ///
    /// # Errors
    /// [`Error::Offsets`] and [`Error::Length`] where the columns do not fit each other,
    /// [`Error::Element`] for a pair that is not of one frame or not in rising order.
    pub fn new(
        sequence: &Sequence,
        starts: &'a [i64],
        columns: &'a [i64],
        similarities: &'a [f64],
        distances: &'a [f64],
    ) -> Result<Self> {
        let (argument, other, unit) = ("starts", "truth", "rows");
        check_offsets("pairs", starts, columns.len())?;
        let (found, expected) = (starts.len() - 1, sequence.truth.len());
        if found != expected {
            return Err(Error::Length { argument, found, other, expected, unit });
        }
        for (argument, values) in [("similarities", similarities), ("distances", distances)] {
            let (found, expected) = (values.len(), columns.len());
            if found != expected {
                let (other, unit) = ("columns", "pairs");
                return Err(Error::Length { argument, found, other, expected, unit });
            }
        }
        let pairs = Self { starts, columns, similarities, distances };
        for (rows, others) in sequence.slices() {
            rows.into_iter().try_for_each(|row| pairs.check(row, &others))?;
        }
        Ok(pairs)
    }

    fn check(&self, row: usize, others: &Range<usize>) -> Result<()> {
        let mut least = others.start;
        for place in self.of(row) {
            let column = self.columns[place];
            if usize::try_from(column).is_ok_and(|j| j >= least && j < others.end) {
                least = column as usize + 1;
                continue;
            }
            let (index, value) = (vec![place], column as f64);
            let requirement = "a track row of the frame, in rising order";
            return Err(Error::Element { argument: "columns", index, requirement, value });
        }
        Ok(())
    }

    /// Where the pairs of a truth row stand.
    #[inline]
    pub fn of(&self, row: usize) -> Range<usize> {
        self.starts[row] as usize..self.starts[row + 1] as usize
    }
}

pub(super) fn check_offsets(argument: &'static str, starts: &[i64], points: usize) -> Result<()> {
    let rises =
        starts.first() == Some(&0) && starts.last() == Some(&(points as i64)) && starts.is_sorted();
    if rises { Ok(()) } else { Err(Error::Offsets { argument, points }) }
}
