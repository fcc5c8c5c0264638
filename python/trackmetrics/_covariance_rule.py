"""When a matrix counts as a covariance: how symmetric, and what is positive definite."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SYMMETRY = 1e-8
"""Asymmetry, relative to the standard deviations, up to which a covariance is averaged."""
SYMMETRY_SINGLE = 1e-3
"""The same for a covariance of single precision."""


def failing_minors(p: Floats) -> NDArray[np.int64]:
    """The first leading minor of each ``(k, d, d)`` that is not positive; 0 if all are."""
    with np.errstate(all="ignore"):
        averaged, _ = symmetrized(p, SYMMETRY)
        return ldl(averaged, np.zeros(p.shape[:-1]))[1]


def ldl(p: Floats, e: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """The forms, and the first leading minor of each covariance that is not positive (or 0).

    Right-looking: a finished column is subtracted from what is right of it. A pivot counts as
    positive above the rounding error of the diagonal element it came from.
    """
    d = e.shape[-1]
    lower, z = p.copy(), e.copy()
    least = d * np.finfo(float).eps * np.diagonal(p, axis1=-2, axis2=-1)
    forms, minors = np.zeros(e.shape[:-1]), np.zeros(p.shape[:-2], dtype=np.int64)
    for j in range(d):
        pivot = lower[..., j, j].copy()
        minors[(minors == 0) & ~(pivot > least[..., j])] = j + 1
        forms += z[..., j] * z[..., j] / pivot
        factor = lower[..., j + 1 :, j] / pivot[..., None]
        z[..., j + 1 :] -= factor * z[..., j, None]
        lower[..., j + 1 :, j + 1 :] -= factor[..., :, None] * lower[..., None, j + 1 :, j]
    return forms, minors


def symmetrized(p: Floats, symmetry: float) -> tuple[Floats, NDArray[np.bool_]]:
    """The mean of the two triangles, and which elements below the diagonal differ by too much."""
    above = np.swapaxes(p, -1, -2)
    deviations = np.sqrt(np.abs(np.diagonal(p, axis1=-2, axis2=-1)))
    bound = symmetry * deviations[..., :, None] * deviations[..., None, :]
    unequal = np.tril(np.abs(above - p) > bound, -1)
    return p + 0.5 * (above - p), unequal
