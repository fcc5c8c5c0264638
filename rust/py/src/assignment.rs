//! Binding of `trackmetrics_core::assignment`.

use crate::convert::{Floats, number_or_none};
use crate::error::raise;
use crate::interrupt::detached;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};
use std::cell::RefCell;
use trackmetrics_core::assignment::auction as auctions;
use trackmetrics_core::assignment::batch::{Matrix, solve_batch};
use trackmetrics_core::assignment::dense::{self, Goal};
use trackmetrics_core::assignment::{bottleneck, pairs};
use trackmetrics_core::interrupt::Interrupt;

thread_local! {
    static DENSE: RefCell<dense::Workspace> = RefCell::default();
    static AUCTION: RefCell<auctions::Workspace> = RefCell::default();
    static BOTTLENECK: RefCell<bottleneck::Workspace> = RefCell::default();
}

/// Matrices of fewer elements are solved in some microseconds, for which it is not worth letting go
/// of the interpreter.
const SMALL: usize = 1 << 10;

/// So many pairs a matrix of fewer than `SMALL` elements can have.
const MOST_SMALL_PAIRS: usize = 32;

/// Workspaces for larger matrices are let go after the call.
const KEPT: usize = 1 << 20;

/// A row without a column.
const NONE: usize = usize::MAX;

type Indices<'py> = Bound<'py, PyArray1<i64>>;

fn goal(maximize: &Bound<'_, PyAny>) -> PyResult<Goal> {
    Ok(if maximize.is_truthy()? { Goal::Largest } else { Goal::Least })
}

/// The pairs of least (or largest) total cost: (row_ind, col_ind).
#[pyfunction]
pub(crate) fn linear_sum_assignment<'py>(
    py: Python<'py>,
    cost_matrix: Floats<'_, 2>,
    maximize: &Bound<'py, PyAny>,
) -> PyResult<(Indices<'py>, Indices<'py>)> {
    let (goal, Floats { values, shape: [rows, columns] }) = (goal(maximize)?, cost_matrix);
    if values.len() < SMALL {
        return solve_small(py, values, rows, columns, goal);
    }
    let (i, j) = detached(py, |interrupt| {
        let mut work = DENSE.take();
        let solved =
            dense::solve_until(values, rows, columns, goal, interrupt, &mut work).map(pairs);
        if values.len() <= KEPT {
            DENSE.set(work);
        }
        solved
    })?;
    Ok((PyArray1::from_slice(py, &i), PyArray1::from_slice(py, &j)))
}

/// The pairs of a matrix of fewer than `SMALL` elements. To move the workspace or to allocate lists of
/// the pairs would take a tenth of the time of ten rows.
fn solve_small<'py>(
    py: Python<'py>,
    costs: &[f64],
    rows: usize,
    columns: usize,
    goal: Goal,
) -> PyResult<(Indices<'py>, Indices<'py>)> {
    let (mut i, mut j, mut count) = ([0; MOST_SMALL_PAIRS], [0; MOST_SMALL_PAIRS], 0);
    DENSE
        .with_borrow_mut(|work| {
            let found = dense::solve_until(costs, rows, columns, goal, &Interrupt::never(), work)?;
            for (row, &column) in found.iter().enumerate().filter(|(_, column)| **column != NONE) {
                (i[count], j[count]) = (row as i64, column as i64);
                count += 1;
            }
            Ok(())
        })
        .map_err(raise)?;
    Ok((PyArray1::from_slice(py, &i[..count]), PyArray1::from_slice(py, &j[..count])))
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
        if cost_matrix.values.len() <= KEPT {
            BOTTLENECK.set(work);
        }
        solved
    })?;
    Ok((value, PyArray1::from_slice(py, &i), PyArray1::from_slice(py, &j)))
}

/// The pairs of many matrices: (row_ind, col_ind) of shape (B, k) for an array of shape (B, n, m), and
/// a list of (row_ind, col_ind) for a list of matrices.
#[pyfunction]
pub(crate) fn linear_sum_assignment_batch<'py>(
    py: Python<'py>,
    costs: &Bound<'py, PyAny>,
    maximize: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let goal = goal(maximize)?;
    if let Ok(list) = costs.cast_exact::<PyList>() {
        let items: Vec<_> = list.iter().collect();
        let matrices = items.iter().map(matrix).collect::<PyResult<Vec<_>>>()?;
        let solved = detached(py, |interrupt| solve_batch(&matrices, goal, interrupt))?;
        let arrays = |(i, j): &(Vec<i64>, Vec<i64>)| {
            (PyArray1::from_slice(py, i), PyArray1::from_slice(py, j))
        };
        return Ok(PyList::new(py, solved.iter().map(arrays))?.into_any());
    }
    let Floats { values, shape: [count, rows, columns] } = costs.extract::<Floats<'_, 3>>()?;
    let matrix = |index: usize| Matrix {
        costs: &values[index * rows * columns..(index + 1) * rows * columns],
        rows,
        columns,
    };
    let matrices: Vec<_> = (0..count).map(matrix).collect();
    let solved = detached(py, |interrupt| solve_batch(&matrices, goal, interrupt))?;
    let shape = [count, rows.min(columns)];
    let (i, j): (Vec<_>, Vec<_>) = solved.into_iter().unzip();
    let arrays = [i, j].map(|part| PyArray1::from_vec(py, part.concat()).reshape(shape));
    let [i, j] = arrays;
    Ok(PyTuple::new(py, [i?, j?])?.into_any())
}

fn matrix<'a>(item: &'a Bound<'_, PyAny>) -> PyResult<Matrix<'a>> {
    let Floats { values: costs, shape: [rows, columns] } = item.extract()?;
    Ok(Matrix { costs, rows, columns })
}

/// A matching within a bound of the best one: (row_ind, col_ind, epsilon, bound).
#[pyfunction]
pub(crate) fn auction<'py>(
    py: Python<'py>,
    cost_matrix: Floats<'_, 2>,
    #[pyo3(from_py_with = number_or_none)] epsilon: Option<f64>,
    maximize: &Bound<'py, PyAny>,
) -> PyResult<(Indices<'py>, Indices<'py>, f64, f64)> {
    let (goal, Floats { values, shape: [rows, columns] }) = (goal(maximize)?, cost_matrix);
    let found = detached(py, |interrupt| {
        let mut work = AUCTION.take();
        let found = auctions::solve(values, rows, columns, epsilon, goal, interrupt, &mut work);
        if values.len() <= KEPT {
            AUCTION.set(work);
        }
        found
    })?;
    let (i, j) = pairs(&found.column_of_row);
    Ok((PyArray1::from_slice(py, &i), PyArray1::from_slice(py, &j), found.epsilon, found.bound))
}
