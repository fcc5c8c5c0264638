//! Binding of `trackmetrics_core::assignment`.

use crate::convert::Floats;
use crate::error::raise;
use numpy::PyArray1;
use pyo3::prelude::*;
use std::cell::RefCell;
use trackmetrics_core::assignment::{bottleneck, dense, pairs};

thread_local! {
    static DENSE: RefCell<dense::Workspace> = RefCell::default();
    static BOTTLENECK: RefCell<bottleneck::Workspace> = RefCell::default();
}

type Indices<'py> = Bound<'py, PyArray1<i64>>;

/// The pairs of least (or largest) total cost: (row_ind, col_ind).
#[pyfunction]
pub(crate) fn linear_sum_assignment<'py>(
    py: Python<'py>,
    cost_matrix: Floats<'_, 2>,
    maximize: &Bound<'py, PyAny>,
) -> PyResult<(Indices<'py>, Indices<'py>)> {
    let solve = if maximize.is_truthy()? { dense::solve_largest } else { dense::solve };
    let [rows, columns] = cost_matrix.shape;
    let (i, j) = py
        .detach(|| {
            DENSE.with_borrow_mut(|work| solve(cost_matrix.values, rows, columns, work).map(pairs))
        })
        .map_err(raise)?;
    Ok((PyArray1::from_slice(py, &i), PyArray1::from_slice(py, &j)))
}

/// The pairs whose largest cost is the smallest: (cost, row_ind, col_ind).
#[pyfunction]
pub(crate) fn bottleneck_assignment<'py>(
    py: Python<'py>,
    cost_matrix: Floats<'_, 2>,
) -> PyResult<(f64, Indices<'py>, Indices<'py>)> {
    let [rows, columns] = cost_matrix.shape;
    let (value, (i, j)) = py
        .detach(|| {
            BOTTLENECK.with_borrow_mut(|work| {
                bottleneck::solve(cost_matrix.values, rows, columns, work)
                    .map(|(value, columns)| (value, pairs(columns)))
            })
        })
        .map_err(raise)?;
    Ok((value, PyArray1::from_slice(py, &i), PyArray1::from_slice(py, &j)))
}
