"""What the statistics share in reading their input."""

from typing import Any

import numpy as np

from trackmetrics import _check, errors
from trackmetrics._check import Floats
from trackmetrics.consistency.nees_nis import nis


def statistics(argument: str, values: Any) -> Floats:
    """NEES or NIS values: finite, at least 0, and at least one."""
    array = np.atleast_1d(_check.floats(argument, values))
    if array.size == 0:
        raise errors.empty(argument)
    unfair = np.argwhere(~(np.isfinite(array) & (array >= 0)))
    if unfair.size:
        index = tuple(unfair[0])
        raise errors.element(argument, index, "finite and at least 0", array[index])
    return array


def degrees(dof: Any, shape: tuple[int, ...]) -> Floats:
    """Degrees of freedom of every value, one number or an array of the values' shape."""
    array = _check.floats("dof", dof)
    if array.shape not in ((), shape):
        raise errors.shape("dof", array.shape, f"{shape} or ()")
    unfair = np.argwhere(~(np.isfinite(array) & (array > 0)))
    if unfair.size or (array.ndim == 0 and not 0 < array < np.inf):
        index = tuple(unfair[0]) if array.ndim else ()
        raise errors.element("dof", index, "positive and finite", array[index])
    return np.broadcast_to(array, shape)


def components(values: Any) -> int:
    """How many components the errors of runs have."""
    shape = _check.floats("errors", values).shape
    if len(shape) < 2:
        raise errors.shape("errors", shape, "(N, ..., d)")
    return int(shape[-1])


def errors_of_runs(values: Any, covariances: Any, runs: int = 1) -> tuple[Floats, Floats]:
    """Errors ``(N, ..., d)`` of at least so many runs, and their covariances, checked."""
    p, e = _pair(("errors", values), ("covariances", covariances))
    if e.ndim < 2:
        raise errors.shape("errors", e.shape, "(N, ..., d)")
    if len(e) < runs:
        raise ValueError(f"errors has {len(e)} runs, at least {runs} are needed")
    nees_check(e, p, "errors", "covariances")
    return e, p


def _pair(vectors: tuple[str, Any], covariances: tuple[str, Any]) -> tuple[Floats, Floats]:
    e, p, _ = _check.states(covariances, vectors)
    if p.shape != (*e.shape, e.shape[-1]) and p.shape != (e.shape[-1], e.shape[-1]):
        d = e.shape[-1]
        raise errors.shape(covariances[0], p.shape, f"{(*e.shape, d)} or {(d, d)}")
    return p, e


def nees_check(e: Floats, p: Floats, vectors: str, covariances: str) -> Floats:
    """The forms; what is wrong is reported under the caller's names."""
    try:
        return np.asarray(nis(e, p))
    except (ValueError, np.linalg.LinAlgError) as error:
        text, own = str(error), "innovation_covariance"
        if text.startswith(own):
            raise type(error)(covariances + text.removeprefix(own)) from None
        raise type(error)(vectors + text.removeprefix("innovation")) from None
