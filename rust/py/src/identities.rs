//! Binding of the scores of `trackmetrics_core::tracking` over identities.

use crate::convert::{Floats, Integers};
use crate::error::raise;
use crate::interrupt::detached;
use numpy::PyArray1;
use pyo3::prelude::*;
use trackmetrics_core::Error;
use trackmetrics_core::tracking::clear_mot::{self as clear, Rules};
use trackmetrics_core::tracking::hota as hota_kernel;
use trackmetrics_core::tracking::identity::{self, Near};
use trackmetrics_core::tracking::sequence::{Sequence, Side, SimilarPairs};
use trackmetrics_core::tracking::similar_pairs::{self as similar, Found, Offsets};

type Array<'py, T> = Bound<'py, PyArray1<T>>;
/// Codes, offsets of frames and the number of ids.
type SideColumns<'a> = (Integers<'a>, Integers<'a>, usize);
/// Offsets of rows, columns, similarities and distances.
type PairColumns<'a> = (Integers<'a>, Integers<'a>, Floats<'a, 1>, Floats<'a, 1>);
type PairArrays<'py> = (Array<'py, i64>, Array<'py, i64>, Array<'py, f64>, Array<'py, f64>);

fn arrays(py: Python<'_>, found: Found) -> PairArrays<'_> {
    (
        PyArray1::from_vec(py, found.starts),
        PyArray1::from_vec(py, found.columns),
        PyArray1::from_vec(py, found.similarities),
        PyArray1::from_vec(py, found.distances),
    )
}

fn sequence<'a>(truth: &SideColumns<'a>, tracks: &SideColumns<'a>) -> Result<Sequence<'a>, Error> {
    let side = |argument, side: &SideColumns<'a>| {
        Side::new(argument, side.0.values, side.1.values, side.2)
    };
    Sequence::new(side("truth", truth)?, side("tracks", tracks)?)
}

fn pairs_of<'a>(sequence: &Sequence, pairs: &PairColumns<'a>) -> Result<SimilarPairs<'a>, Error> {
    let (starts, columns, similarities, distances) = pairs;
    let (similarities, distances) = (similarities.values, distances.values);
    SimilarPairs::new(sequence, starts.values, columns.values, similarities, distances)
}

fn require_boxes(argument: &'static str, shape: [usize; 2]) -> PyResult<()> {
    if shape[1] == 4 {
        return Ok(());
    }
    let expected = format!("({}, 4)", shape[0]);
    Err(raise(Error::Shape { argument, found: shape.to_vec(), expected }))
}

/// Pairs of boxes that share an area: (starts, columns, similarities, distances).
#[pyfunction]
pub(crate) fn box_pairs<'py>(
    py: Python<'py>,
    truth: Floats<'_, 2>,
    tracks: Floats<'_, 2>,
    truth_starts: Integers<'_>,
    track_starts: Integers<'_>,
    keep_all: bool,
) -> PyResult<PairArrays<'py>> {
    require_boxes("truth", truth.shape)?;
    require_boxes("tracks", tracks.shape)?;
    let rows = [truth.shape[0], tracks.shape[0]];
    let found = detached(py, |interrupt| {
        let offsets = Offsets::new(truth_starts.values, track_starts.values, rows)?;
        similar::box_pairs(truth.values, tracks.values, offsets, keep_all, interrupt)
    })?;
    Ok(arrays(py, found))
}

/// Pairs of positions nearer than twice the threshold: (starts, columns, similarities, distances).
#[pyfunction]
pub(crate) fn position_pairs<'py>(
    py: Python<'py>,
    truth: Floats<'_, 2>,
    tracks: Floats<'_, 2>,
    truth_starts: Integers<'_>,
    track_starts: Integers<'_>,
    threshold: f64,
) -> PyResult<PairArrays<'py>> {
    let ([n, dimension], [m, found]) = (truth.shape, tracks.shape);
    if n > 0 && m > 0 && found != dimension {
        let (argument, index) = ("tracks", vec![0]);
        return Err(raise(Error::Dimension { argument, index, found, expected: dimension }));
    }
    let found = detached(py, |interrupt| {
        let offsets = Offsets::new(truth_starts.values, track_starts.values, [n, m])?;
        let (x, y) = (truth.values, tracks.values);
        similar::position_pairs(x, y, dimension, offsets, threshold, interrupt)
    })?;
    Ok(arrays(py, found))
}

/// Pairs of the similarity matrices of all frames: (starts, columns, similarities, distances).
#[pyfunction]
pub(crate) fn matrix_pairs<'py>(
    py: Python<'py>,
    matrices: Floats<'_, 1>,
    truth_starts: Integers<'_>,
    track_starts: Integers<'_>,
    keep_all: bool,
) -> PyResult<PairArrays<'py>> {
    let last = |starts: &Integers<'_>| starts.values.last().map_or(0, |&rows| rows.max(0) as usize);
    let rows = [last(&truth_starts), last(&track_starts)];
    let found = detached(py, |interrupt| {
        let offsets = Offsets::new(truth_starts.values, track_starts.values, rows)?;
        similar::matrix_pairs(matrices.values, offsets, keep_all, interrupt)
    })?;
    Ok(arrays(py, found))
}

type Matches<'py> = (Array<'py, i64>, Array<'py, f64>, Array<'py, i64>, Array<'py, i64>, f64);

/// Truth and tracks matched frame by frame: (partners, values, events, matched, total).
#[pyfunction]
pub(crate) fn clear_mot<'py>(
    py: Python<'py>,
    truth: SideColumns<'_>,
    tracks: SideColumns<'_>,
    pairs: PairColumns<'_>,
    rules: (bool, bool, bool),
    limit: f64,
) -> PyResult<Matches<'py>> {
    let (forgets, most_similar, own_frames) = rules;
    let found = detached(py, |interrupt| {
        let sequence = sequence(&truth, &tracks)?;
        let pairs = pairs_of(&sequence, &pairs)?;
        let rules = Rules { forgets, most_similar, own_frames, limit };
        clear::clear_mot(&sequence, &pairs, rules, interrupt)
    })?;
    Ok((
        PyArray1::from_vec(py, found.partners),
        PyArray1::from_vec(py, found.values),
        PyArray1::from_vec(py, found.events),
        PyArray1::from_vec(py, found.matched),
        found.total,
    ))
}

type Identities<'py> = (Array<'py, i64>, Array<'py, i64>, Array<'py, i64>, Array<'py, i64>, i64);

/// Targets and tracks that meet: (targets, tracks, counts, assigned, true positives).
#[pyfunction]
pub(crate) fn identities<'py>(
    py: Python<'py>,
    truth: SideColumns<'_>,
    tracks: SideColumns<'_>,
    pairs: PairColumns<'_>,
    by_distance: bool,
    limit: f64,
) -> PyResult<Identities<'py>> {
    let found = detached(py, |interrupt| {
        let sequence = sequence(&truth, &tracks)?;
        let pairs = pairs_of(&sequence, &pairs)?;
        let near = if by_distance { Near::Distance(limit) } else { Near::Similarity(limit) };
        identity::identities(&sequence, &pairs, near, interrupt)
    })?;
    Ok((
        PyArray1::from_vec(py, found.targets),
        PyArray1::from_vec(py, found.tracks),
        PyArray1::from_vec(py, found.counts),
        PyArray1::from_vec(py, found.assigned),
        found.true_positives,
    ))
}

type Hota<'py> =
    (Array<'py, i64>, Array<'py, f64>, Array<'py, f64>, Array<'py, f64>, Array<'py, f64>);

/// At each threshold: (true positives, sum of similarities, AssA, AssRe, AssPr).
#[pyfunction]
pub(crate) fn hota<'py>(
    py: Python<'py>,
    truth: SideColumns<'_>,
    tracks: SideColumns<'_>,
    pairs: PairColumns<'_>,
    thresholds: Floats<'_, 1>,
) -> PyResult<Hota<'py>> {
    let found = detached(py, |interrupt| {
        let sequence = sequence(&truth, &tracks)?;
        let pairs = pairs_of(&sequence, &pairs)?;
        hota_kernel::hota(&sequence, &pairs, thresholds.values, interrupt)
    })?;
    Ok((
        PyArray1::from_vec(py, found.true_positives),
        PyArray1::from_vec(py, found.similarity),
        PyArray1::from_vec(py, found.accuracy),
        PyArray1::from_vec(py, found.recall),
        PyArray1::from_vec(py, found.precision),
    ))
}
