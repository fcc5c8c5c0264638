"""Reductions over many runs, the same bits however they are cut: reference implementation of
``monte_carlo``.

A node (start, level) is the sum of the runs start .. start + 2^level, left half plus right half;
any interval of runs is at most 2 log2 N of them.
"""

import numpy as np
from numpy.typing import NDArray

from trackmetrics import errors
from trackmetrics._covariance_rule import SYMMETRY
from trackmetrics._numpy.arguments import Floats, plain
from trackmetrics._numpy.consistency import quadratic_forms

Counts = NDArray[np.int64]

_PARTS = 3
_LOWEST, _HIGHEST = (1023 - 20) << _PARTS, (1023 + 28) << _PARTS
_BINS = _HIGHEST - _LOWEST + 2


def run_sums(values: Floats, first_run: int) -> Floats:
    """Sums over the canonical nodes of a batch of runs ``(runs, columns)``."""
    plain(values)
    return _nodes(values, first_run)


def _nodes(values: Floats, first: int) -> Floats:
    """Level by level: the node that has no sibling on its side is done, the others are paired."""
    left: list[Floats] = []
    right: list[Floats] = []
    while len(values):
        if first % 2:
            left.append(values[0])
            values, first = values[1:], first + 1
        if len(values) % 2:
            right.append(values[-1])
            values = values[:-1]
        values, first = values[0::2] + values[1::2], first // 2
    nodes = left + right[::-1]
    return np.stack(nodes) if nodes else values


def histograms(values: Floats) -> Counts:
    """Counts of each column of ``(runs, columns)`` in the bins of a histogram."""
    plain(values)
    leading = values.view(np.int64) >> (52 - _PARTS)
    bins = np.clip(leading, _LOWEST - 1, _HIGHEST) - _LOWEST + 1
    places = bins + _BINS * np.arange(values.shape[1])
    counts = np.bincount(places[~np.isnan(values)], minlength=_BINS * values.shape[1])
    return counts.reshape(values.shape[1], _BINS)


def consistency_sums(
    truth: Floats,
    estimates: Floats | None,
    covariances: Floats,
    periods: Floats,
    first_run: int,
    decibels: float,
    thresholds: Floats,
) -> tuple[Floats, Floats, Counts, Counts]:
    """What is kept of the errors of a batch of runs: sums over its nodes, sums of each run, counts,
    and a histogram."""
    plain(truth, covariances, periods, thresholds, *([] if estimates is None else [estimates]))
    _check(truth, estimates, covariances)
    e = _errors(truth, estimates, periods)
    measured: NDArray[np.bool_] = np.full(e.shape[:-1], True)
    if estimates is None:
        measured = np.logical_not(np.isnan(e).any(-1))
    p = covariances
    if not measured.all():
        e = np.where(measured[..., None], e, 0.0)
        p = np.where(measured[..., None, None], p, np.eye(e.shape[-1]))
    residuals = [("innovations", e)] if estimates is None else _named(truth, estimates)
    name = "innovation_covariances" if estimates is None else "covariances"
    q = quadratic_forms(residuals, (name, p), 1, SYMMETRY, periods, False)
    q = np.where(measured, np.where(np.isnan(q), np.inf, q), np.nan)
    of_runs = np.concatenate([measured[..., None], q[..., None], e * e], -1)
    of_runs[~measured] = 0.0
    columns = _columns(e, np.einsum("...jj->...j", p), q, decibels)
    counts = np.stack([~np.isnan(q), *(q <= x for x in thresholds)]).sum(1)
    return _nodes(columns, first_run), of_runs.sum(1), counts, histograms(q)


def _errors(truth: Floats, estimates: Floats | None, periods: Floats) -> Floats:
    """Truth less estimates, angles brought into (-period / 2, period / 2]."""
    e = truth.copy() if estimates is None else truth - estimates
    angles = periods > 0
    e[..., angles] -= periods[angles] * np.ceil(e[..., angles] / periods[angles] - 0.5)
    return e


def _columns(e: Floats, variances: Floats, q: Floats, decibels: float) -> Floats:
    """What is summed over runs: a row a run, block by block; 0 for what was not measured."""
    with np.errstate(divide="ignore", over="ignore"):
        b = 10.0 * np.log10(q)
        of_forms = np.stack([q, q * q, b, np.abs(b - decibels)], 1)
        of_states = np.stack([e, e * e, e / np.sqrt(variances)], 1)
    absent = np.isnan(q)[:, None]
    of_forms = np.where(absent, 0.0, of_forms)
    of_states = np.where(absent[..., None], 0.0, of_states)
    runs, steps, d = e.shape
    by_state = of_states.swapaxes(2, 3).reshape(runs, 3 * d * steps)
    blocks = [of_forms.reshape(runs, 4 * steps), by_state]
    return np.concatenate(blocks, 1)


def _named(truth: Floats, estimates: Floats) -> list[tuple[str, Floats]]:
    return [("truth", truth), ("estimates", estimates)]


def _check(truth: Floats, estimates: Floats | None, covariances: Floats) -> None:
    """That there is something, and that sizes fit together."""
    argument = "innovations" if estimates is None else "truth"
    if truth.shape[1] * truth.shape[2] == 0:
        raise errors.parameter(argument, "of at least one step and one dimension", 0)
    if estimates is not None and estimates.size != truth.size:
        raise errors.length("estimates", estimates.size, argument, truth.size, "numbers")
    expected = truth.size * truth.shape[2]
    if covariances.size != expected:
        name = "innovation_covariances" if estimates is None else "covariances"
        raise errors.length(name, covariances.size, argument, expected, "numbers")
