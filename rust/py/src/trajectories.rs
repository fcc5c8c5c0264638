//! Binding of `trackmetrics_core::trajectories`.

use crate::convert::{FrameSequence, Integers};
use crate::interrupt::detached;
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use trackmetrics_core::trajectories::{
    Trajectories,
    ospa2::{self as kernel, Base, Ospa2, Parameters},
};

type Floats<'py> = Bound<'py, PyArray1<f64>>;

/// OSPA(2) over each window: (distance, localization, cardinality).
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "two sets of trajectories, flat")]
pub(crate) fn ospa2<'py>(
    py: Python<'py>,
    truth: &Bound<'_, PyAny>,
    truth_steps: Integers<'_>,
    tracks: &Bound<'_, PyAny>,
    track_steps: Integers<'_>,
    first: Integers<'_>,
    beyond: Integers<'_>,
    c: f64,
    p: f64,
    q: f64,
    base: &str,
) -> PyResult<(Floats<'py>, Floats<'py>, Floats<'py>)> {
    let (x, y) = (FrameSequence::read("truth", truth)?, FrameSequence::read("tracks", tracks)?);
    let parameters = Parameters { c, p, q, base: read_base(base)? };
    let windows: Vec<[i64; 2]> =
        first.values.iter().zip(beyond.values).map(|(a, b)| [*a, *b]).collect();
    let found = detached(py, |interrupt| {
        let x = Trajectories::new("truth", x.frames("truth")?, truth_steps.values)?;
        let y = Trajectories::new("tracks", y.frames("tracks")?, track_steps.values)?;
        kernel::ospa2(x, y, &windows, parameters, interrupt)
    })?;
    let column = |part: fn(&Ospa2) -> f64| PyArray1::from_iter(py, found.iter().map(part));
    Ok((column(|o| o.distance), column(|o| o.localization), column(|o| o.cardinality)))
}

fn read_base(base: &str) -> PyResult<Base> {
    match base {
        "euclidean" => Ok(Base::Euclidean),
        "p-norm" => Ok(Base::PNorm),
        _ => Err(PyValueError::new_err(format!(
            "base must be 'euclidean' or 'p-norm', got '{base}'"
        ))),
    }
}
