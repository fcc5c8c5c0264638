"""Quadratic forms of many small covariances: reference implementation of ``consistency`` in the
core.

e' P^-1 e through P = L D L', column after column and all covariances at once.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import errors as messages
from trackmetrics._covariance_rule import ldl, symmetrized
from trackmetrics._numpy.arguments import Floats, plain

Named = tuple[str, Floats]


def nees(
    true_state: Floats,
    estimated_state: Floats,
    covariance: Floats,
    symmetry: float,
    periods: Floats | None,
    nan_where_invalid: bool,
) -> Any:
    """Normalised estimation error squared of states ``(..., d)``."""
    residuals = [("true_state", true_state), ("estimated_state", estimated_state)]
    rules = (1, symmetry, periods, nan_where_invalid)
    return _number(quadratic_forms(residuals, ("covariance", covariance), *rules))


def nees_sequence(
    true_states: Floats,
    estimated_states: Floats,
    covariances: Floats,
    symmetry: float,
    periods: Floats | None,
    nan_where_invalid: bool,
) -> Any:
    """Normalised estimation error squared of sequences of states ``(..., N, d)``."""
    residuals = [("true_states", true_states), ("estimated_states", estimated_states)]
    rules = (2, symmetry, periods, nan_where_invalid)
    return quadratic_forms(residuals, ("covariances", covariances), *rules)


def nis(
    innovation: Floats,
    innovation_covariance: Floats,
    symmetry: float,
    periods: Floats | None,
    nan_where_invalid: bool,
) -> Any:
    """Normalised innovation squared of innovations ``(..., m)``."""
    covariances = ("innovation_covariance", innovation_covariance)
    rules = (1, symmetry, periods, nan_where_invalid)
    return _number(quadratic_forms([("innovation", innovation)], covariances, *rules))


def nis_sequence(
    innovations: Floats,
    innovation_covariances: Floats,
    symmetry: float,
    periods: Floats | None,
    nan_where_invalid: bool,
) -> Any:
    """Normalised innovation squared of sequences of innovations ``(..., N, m)``."""
    covariances = ("innovation_covariances", innovation_covariances)
    rules = (2, symmetry, periods, nan_where_invalid)
    return quadratic_forms([("innovations", innovations)], covariances, *rules)


def credibility_interval(
    errors: Floats, covariances: Floats, threshold: float, symmetry: float
) -> float:
    """The share of errors inside their credibility region: forms of at most ``threshold``."""
    plain(errors, covariances)
    _refuse_columns(errors, covariances)
    if errors.size == 0:
        raise messages.empty("errors")
    forms = quadratic_forms(
        [("errors", errors)], ("covariances", covariances), 2, symmetry, None, False
    )
    return float(np.count_nonzero(forms <= threshold) / forms.size)


def mean_statistic(nees_or_nis_values: Floats) -> tuple[float, int]:
    """The mean of NEES or NIS values, each finite and at least 0, and how many there are."""
    values = nees_or_nis_values
    plain(values)
    if values.size == 0:
        raise messages.empty("nees_or_nis_values")
    fair = np.isfinite(values) & (values >= 0)
    if not fair.all():
        index = tuple(np.argwhere(~fair)[0])
        requirement = "finite and at least 0"
        raise messages.element("nees_or_nis_values", index, requirement, values[index])
    return float(values.mean()), values.size


def quadratic_forms(
    residuals: list[Named],
    covariances: Named,
    axes: int,
    symmetry: float,
    periods: Floats | None,
    nan_where_invalid: bool,
) -> Floats:
    """``e' P^-1 e``; the residual is the first argument less the second, where there are two."""
    arrays = [array for _, array in residuals]
    plain(*arrays, covariances[1])
    _refuse_columns(arrays[0], covariances[1])
    _check_shapes(residuals, covariances, axes)
    with np.errstate(all="ignore"):
        e = arrays[0] - arrays[1] if len(arrays) == 2 else arrays[0]
        if periods is not None:
            e = _wrapped(e, periods)
        p, unequal = symmetrized(covariances[1], symmetry)
        forms, minors = ldl(p, e)
    invalid = _invalid(residuals, covariances[1], unequal, minors)
    if nan_where_invalid:
        forms[invalid] = np.nan
    elif invalid.any():
        raise _first_fault(residuals, covariances, unequal, minors)
    return forms


def _wrapped(e: Floats, periods: Floats) -> Floats:
    """Residuals of angles brought into (-period / 2, period / 2]."""
    period = np.where(periods > 0, periods, 1.0)
    wrapped: Floats = np.where(periods > 0, e - period * np.ceil(e / period - 0.5), e)
    return wrapped


def _invalid(
    residuals: list[Named],
    p: Floats,
    unequal: NDArray[np.bool_],
    minors: NDArray[np.int64],
) -> NDArray[np.bool_]:
    infinite = ~np.isfinite(p).all((-1, -2)) | unequal.any((-1, -2)) | (minors > 0)
    for _, array in residuals:
        infinite = infinite | ~np.isfinite(array).all(-1)
    return infinite


def _first_fault(
    residuals: list[Named],
    covariances: Named,
    unequal: NDArray[np.bool_],
    minors: NDArray[np.int64],
) -> ValueError:
    """The error of the first residual or covariance at fault; one for all comes before any."""
    argument, p = covariances
    if p.ndim == 2 and (fault := _fault(argument, p, unequal, minors, ())):
        return fault
    invalid = _invalid(residuals, p, unequal, minors)
    index = tuple(int(i) for i in np.argwhere(invalid)[0])
    for name, array in residuals:
        bad = np.flatnonzero(~np.isfinite(array[index]))
        if bad.size:
            return messages.not_finite(name, (*index, bad[0]), array[index][bad[0]])
    fault = _fault(argument, p, unequal, minors, index)
    assert fault is not None
    return fault


def _fault(
    argument: str,
    p: Floats,
    unequal: NDArray[np.bool_],
    minors: NDArray[np.int64],
    index: tuple[int, ...],
) -> ValueError | None:
    """What is wrong with one covariance."""
    at = np.argwhere(~np.isfinite(p[index]))
    if at.size:
        return messages.not_finite(argument, (*index, *at[0]), p[index][tuple(at[0])])
    at = np.argwhere(unequal[index])
    if at.size:
        return messages.not_symmetric(argument, index, at[0][0], at[0][1])
    if minors[index]:
        return messages.not_positive_definite(argument, index, int(minors[index]))
    return None


def _check_shapes(residuals: list[Named], covariances: Named, axes: int) -> None:
    name, first = residuals[0]
    if first.ndim < axes:
        raise messages.shape(name, first.shape, "(..., d)" if axes < 2 else "(..., N, d)")
    for other, array in residuals[1:]:
        if array.shape != first.shape:
            raise messages.shape(other, array.shape, str(first.shape))
    d = first.shape[-1]
    one, each = (d, d), (*first.shape[:-1], d, d)
    if covariances[1].shape not in (one, each):
        expected = f"{one}" if one == each else f"{each} or {one}"
        raise messages.shape(covariances[0], covariances[1].shape, expected)


def _refuse_columns(states: Floats, covariances: Floats) -> None:
    """Leaves scalars and column vectors to the public function, which knows how to flatten them."""
    if states.ndim == 0 or covariances.ndim < 2:
        raise messages.NotPlain
    if states.ndim > 1 and states.shape[-1] == 1 and covariances.shape[-1] != 1:
        raise messages.NotPlain


def _number(forms: Floats) -> Any:
    """A number where there are no leading axes."""
    return forms if forms.ndim else float(forms)
