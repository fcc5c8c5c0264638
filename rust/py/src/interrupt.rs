//! Ctrl-C in long kernels.

use crate::error::raise;
use pyo3::prelude::*;
use std::sync::{Mutex, PoisonError};
use trackmetrics_core::Result;
use trackmetrics_core::interrupt::Interrupt;

/// Runs a kernel detached from the interpreter; pending signals stop it.
///
/// What a signal handler raises (`KeyboardInterrupt` for Ctrl-C) is raised from here.
pub(crate) fn detached<T: Send>(
    py: Python<'_>,
    kernel: impl FnOnce(&Interrupt<'_>) -> Result<T> + Send,
) -> PyResult<T> {
    let raised: Mutex<Option<PyErr>> = Mutex::new(None);
    let ask = || {
        let signal = Python::attach(|py| py.check_signals()).err();
        let stop = signal.is_some();
        *raised.lock().unwrap_or_else(PoisonError::into_inner) = signal;
        stop
    };
    let result = py.detach(|| kernel(&Interrupt::new(&ask)));
    match raised.into_inner().unwrap_or_else(PoisonError::into_inner) {
        Some(exception) => Err(exception),
        None => result.map_err(raise),
    }
}
