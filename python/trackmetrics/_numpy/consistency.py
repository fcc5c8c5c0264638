"""Quadratic forms of many small covariances: twin of ``consistency`` in the core."""

import numpy as np

from trackmetrics._numpy.arguments import Floats, plain


def nees(errors: Floats, covariances: Floats) -> Floats:
    """NEES of many errors with their covariances."""
    plain(errors, covariances)
    forms: Floats = np.einsum(
        "ni,ni->n", errors, np.linalg.solve(covariances, errors[..., None])[..., 0]
    )
    return forms
