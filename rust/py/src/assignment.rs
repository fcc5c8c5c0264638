//! Binding of `trackmetrics_core::assignment`.

use crate::convert::Floats;
use crate::error::raise;
use crate::interrupt::detached;
use numpy::PyArray1;
use pyo3::prelude::*;
use std::cell::RefCell;
use trackmetrics_core::assignment::{
    bottleneck,
    dense::{self, Goal},
    pairs,
};
use trackmetrics_core::interrupt::Interrupt;

thread_local! {
    static DENSE: RefCell<dense::Workspace> = RefCell::default();
    static BOTTLENECK: RefCell<bottleneck::Workspace> = RefCell::default();
}

/// Matrices of fewer elements are solved in some microseconds, for which it is not worth letting go
/// of the interpreter.
const SMALL: usize = 1 << 10;

type Indices<'py> = Bound<'py, PyArray1<i64>>;

/// The pairs of least (or largest) total cost: (row_ind, col_ind).
#[pyfunction]
pub(crate) fn linear_sum_assignment<'py>(
    py: Python<'py>,
    cost_matrix: Floats<'_, 2>,
    maximize: &Bound<'py, PyAny>,
) -> PyResult<(Indices<'py>, Indices<'py>)> {
    let goal = if maximize.is_truthy()? { Goal::Largest } else { Goal::Least };
    let [rows, columns] = cost_matrix.shape;
    let solve = |interrupt: &Interrupt<'_>| {
        let mut work = DENSE.take();
        let solved =
            dense::solve_until(cost_matrix.values, rows, columns, goal, interrupt, &mut work)
                .map(pairs);
        DENSE.set(work);
        solved
    };
    let (i, j) = if cost_matrix.values.len() < SMALL {
        solve(&Interrupt::never()).map_err(raise)?
    } else {
        detached(py, solve)?
    };
    Ok((PyArray1::from_slice(py, &i), PyArray1::from_slice(py, &j)))
}

/// The pairs whose largest cost is the smallest: (cost, row_ind, col_ind).
#[pyfunction]
pub(crate) fn bottleneck_assignment<'py>(
    py: Python<'py>,
    cost_matrix: Floats<'_, 2>,
) -> PyResult<(f64, Indices<'py>, Indices<'py>)> {
    let [rows, columns] = cost_matrix.shape;
    let (value, (i, j)) = detached(py, |interrupt| {
        let mut work = BOTTLENECK.take();
        let solved =
            bottleneck::solve_until(cost_matrix.values, rows, columns, interrupt, &mut work)
                .map(|(value, columns)| (value, pairs(columns)));
        BOTTLENECK.set(work);
        solved
    })?;
    Ok((value, PyArray1::from_slice(py, &i), PyArray1::from_slice(py, &j)))
}
