//! Binding of `trackmetrics_core::point_sets`.

use crate::convert::PointSet;
use crate::error::raise;
use pyo3::prelude::*;
use std::cell::RefCell;
use trackmetrics_core::point_sets::ospa::{self as kernel, Workspace};

thread_local! {
    static WORK: RefCell<Workspace> = RefCell::default();
}

/// OSPA of one frame: (distance, localization, cardinality).
#[pyfunction]
pub(crate) fn ospa(
    x: &Bound<'_, PyAny>,
    y: &Bound<'_, PyAny>,
    c: f64,
    p: f64,
) -> PyResult<(f64, f64, f64)> {
    let (x, y) = (PointSet::read("X", x)?, PointSet::read("Y", y)?);
    let result =
        WORK.with_borrow_mut(|work| kernel::ospa(x.points("X")?, y.points("Y")?, c, p, work));
    result.map(|r| (r.distance, r.localization, r.cardinality)).map_err(raise)
}
