"""Linear algebra of stacks of small covariances whose components may be missing (NaN).

Long stacks are processed in blocks of rows: temporary arrays then stay in the processor's cache and
take no memory beside the stack's own. Each row's numbers are the same in any block.
"""

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _backend

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
BLOCK_ROWS = 4096
MIN_ROWS_FOR_THREADS = 10 * BLOCK_ROWS
MIN_SURE_PIVOT = 1e-8


def row_blocks(rows: int) -> Iterator[slice]:
    """Slices of at most ``BLOCK_ROWS`` rows that cover all rows."""
    for first in range(0, rows, BLOCK_ROWS):
        yield slice(first, min(first + BLOCK_ROWS, rows))


def for_blocks(function: Callable[[slice], Any], rows: int) -> None:
    """Call ``function`` for every block of rows, on as many threads as kernels may use.

    Of the exceptions of several blocks, that of the first block is raised.
    """
    threads = _backend.threads() if rows >= MIN_ROWS_FOR_THREADS else 1
    if threads == 1:
        for block in row_blocks(rows):
            function(block)
        return
    with ThreadPoolExecutor(threads) as executor:
        for _ in executor.map(function, row_blocks(rows)):
            pass


def side_by_side(*calls: Callable[[], Any]) -> list[Any]:
    """What each of these calls returns, at the same time where kernels may use several threads.

    Floating-point warnings are handled as in the calling thread. Of several exceptions, that of the
    first call is raised.
    """
    if _backend.threads() == 1:
        return [call() for call in calls]
    with ThreadPoolExecutor(len(calls)) as executor:
        return [f.result() for f in [executor.submit(copy_context().run, c) for c in calls]]


def valid_components(vectors: Floats, covariances: Floats) -> Mask:
    """``(rows, d)``: the components that have both a value and a variance."""
    valid: Mask = ~np.isnan(vectors)
    return valid & ~np.isnan(covariances.diagonal(axis1=1, axis2=2))


def fill_missing_with_identity(covariances: Floats, valid: Mask | None = None) -> Floats:
    """Covariances in which missing (or not ``valid``) components are those of an identity.

    With an error of 0 such a component adds nothing to a quadratic form, and since it is
    independent of the others it changes nothing of theirs.
    """
    absent = np.isnan(covariances)
    if valid is not None:
        absent |= ~(valid[:, :, None] & valid[:, None, :])
    if not absent.any():
        return covariances
    return np.where(absent, np.eye(covariances.shape[1]), covariances)


def to_unit_diagonal(covariances: Floats) -> Floats:
    """Covariances scaled to a unit diagonal, with an identity where components are missing.

    Latitudes in degrees next to speeds in knots give condition numbers of 1e9; scaling costs
    nothing and removes the units. A variance that is not positive stays on the diagonal as it is.
    """
    whole = fill_missing_with_identity(covariances)
    variances = np.einsum("kii->ki", whole)
    d = np.sqrt(np.where(variances > 0, variances, 1.0))
    scaled: Floats = (whole + whole.swapaxes(1, 2)) / (2 * d[:, :, None] * d[:, None, :])
    return scaled


def decorrelated(errors: Floats, covariances: Floats) -> Floats:
    """``L^-1 e`` with ``P = L L'``: uncorrelated and of unit variance where P is right."""
    lower = np.linalg.cholesky((covariances + np.swapaxes(covariances, -1, -2)) / 2)
    white: Floats = np.linalg.solve(lower, errors[..., None])[..., 0]
    return white


def whitened(errors: Floats, covariances: Floats, valid: Mask) -> Floats:
    """:func:`decorrelated` errors of the valid components, whatever their units; 0 elsewhere."""
    p = fill_missing_with_identity(covariances, valid)
    d = np.sqrt(p.diagonal(axis1=1, axis2=2))
    e = np.where(valid, errors, 0.0) / d
    return decorrelated(e, to_unit_diagonal(p))


def quadratic_forms(errors: Floats, covariances: Floats) -> Floats:
    """``e' P^-1 e`` of each row over its valid components; NaN where there is none."""
    forms = np.full(len(errors), np.nan)

    def fill(block: slice) -> None:
        forms[block] = _quadratic_forms(errors[block], covariances[block])

    for_blocks(fill, len(errors))
    return forms


def _quadratic_forms(errors: Floats, covariances: Floats) -> Floats:
    forms = np.full(len(errors), np.nan)
    valid = valid_components(errors, covariances)
    rows = valid.any(axis=1)
    if rows.any():
        with np.errstate(over="ignore"):
            white = whitened(errors[rows], covariances[rows], valid[rows])
            forms[rows] = (white**2).sum(axis=1)
    return forms


def surely_definite(covariances: Floats) -> Mask:
    """Which of these covariances are positive definite beyond rounding.

    A Cholesky factorisation of all rows at once, element by element: a row whose pivots all stay
    above ``MIN_SURE_PIVOT`` of its variances is definite for LAPACK as well. The others need a
    closer look.
    """
    p = np.moveaxis(fill_missing_with_identity(covariances), 0, -1).copy()
    least = MIN_SURE_PIVOT * np.einsum("iik->ik", p)
    sure = np.ones(len(covariances), bool)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        for j in range(len(p)):
            sure &= (p[j, j] > least[j]) & (least[j] > 0)
            below = p[j + 1 :, j] / p[j, j]
            p[j + 1 :, j + 1 :] -= below[:, None] * p[j + 1 :, j][None]
    return sure
