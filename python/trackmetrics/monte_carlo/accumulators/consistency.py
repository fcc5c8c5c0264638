"""Consistency and accuracy of a filter over many runs, kept in a few sums for each step."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from trackmetrics import _backend, _check, _deprecated, errors
from trackmetrics._distributions import DECIBELS, chi2_log_mean, chi2_quantile
from trackmetrics._tables.errors import value
from trackmetrics.monte_carlo.accumulators.base import Accumulator, Counts
from trackmetrics.monte_carlo.accumulators.histogram import BINS
from trackmetrics.monte_carlo.consistency_summary import ConsistencySummary, ErrorStatistics
from trackmetrics.monte_carlo.run_tree import Floats

PROBABILITIES = (0.5, 0.9, 0.95, 0.99)
_STATES = ("truth", "estimates", "covariances")
_INNOVATIONS = ("innovations", "innovation_covariances")


class ConsistencyAccumulator(Accumulator):
    """ANEES, RMSE and related statistics over many runs, step by step, without keeping the runs.

    For the error e of each run and step with its covariance P, and q = e' P^-1 e, it keeps over
    the runs: sums of q (ANEES), q^2, 10 log10 q (inclination) and its distance from what a
    consistent filter expects (noncredibility), of e (bias: estimate minus truth), e^2 (RMSE) and
    e / sqrt(P_jj) (normalised mean error) of every state; how many q lie below the chi-square
    quantiles of ``probabilities`` (coverage); and a histogram of q. The same of innovations with
    their covariances, where they are given.

    Parameters
    ----------
    angles, innovation_angles : mapping of int to float
        Which components of the state and of the innovation are angles, with their period
        (``{3: 360.0}``): their errors are brought into (-period / 2, period / 2].
    probabilities : sequence of float
        The probabilities of the credibility regions whose coverage is counted.

    Notes
    -----
    However the runs are cut into batches, and in whatever order they come or are merged, the sums
    have the same bits: they live on the tree of run numbers. Memory is O(steps x states x log
    runs).

    Examples
    --------
    >>> import numpy as np
    >>> rng = np.random.default_rng(1)
    >>> P = np.broadcast_to(np.diag([4.0, 1.0]), (200, 10, 2, 2))
    >>> truth = np.zeros((200, 10, 2))
    >>> batch = {"truth": truth, "estimates": truth + rng.normal(0, [2.0, 1.0], (200, 10, 2)),
    ...          "covariances": P}
    >>> whole = ConsistencyAccumulator()
    >>> whole.update(batch, first_run=0)
    >>> first, second = ConsistencyAccumulator(), ConsistencyAccumulator()
    >>> second.update({name: array[77:] for name, array in batch.items()}, first_run=77)
    >>> first.update({name: array[:77] for name, array in batch.items()}, first_run=0)
    >>> second.merge(first)
    >>> second.to_bytes() == whole.to_bytes()
    True
    >>> result = whole.result()
    >>> low, high = result.anees_interval
    >>> bool(np.mean((low < result.anees) & (result.anees < high)) > 0.7)
    True
    """

    kind = "ConsistencyAccumulator"

    @_deprecated.parameters(levels="probabilities")
    def __init__(
        self,
        *,
        angles: Mapping[int, float] | None = None,
        innovation_angles: Mapping[int, float] | None = None,
        probabilities: Sequence[float] = PROBABILITIES,
    ) -> None:
        if isinstance(probabilities, str) or not isinstance(probabilities, Iterable):
            raise TypeError(
                f"probabilities must be a sequence of numbers, got {value(probabilities)}"
            )
        for probability in probabilities:
            if not 0 < _check.number("probabilities", probability) < 1:
                raise errors.parameter("probabilities", "between 0 and 1", probability)
        super().__init__(
            {
                "angles": _periods("angles", angles),
                "innovation_angles": _periods("innovation_angles", innovation_angles),
                "levels": [float(p) for p in probabilities],
            }
        )

    def update(self, batch: Mapping[str, Any], first_run: int) -> None:
        """Takes in a batch of runs, the first of which has the number ``first_run``.

        Parameters
        ----------
        batch : mapping of str to array
            ``truth`` and ``estimates`` of shape (runs, steps, n) with ``covariances`` (runs, steps,
            n, n); or ``innovations`` (runs, steps, m) with ``innovation_covariances`` (runs, steps,
            m, m); or both. An innovation of NaN was not measured, and does not count.
        first_run : int
            Number of the first run; runs may come in any order, each once.

        Raises
        ------
        ValueError
            Where shapes do not fit, a run is in already, or a state is not finite.
        numpy.linalg.LinAlgError
            For a covariance that is not positive definite, with its run and step in the batch.
        """
        self.add_runs(batch, first_run)

    absorb = _deprecated.attribute("add_runs")

    def add_runs(self, batch: Mapping[str, Any], first_run: int) -> dict[str, Floats]:
        """As ``update``; returns for each run the steps counted, the sum of q, and of e^2."""
        if not isinstance(batch, Mapping):
            raise TypeError(f"batch must be a mapping of names to arrays, got {value(batch)}")
        channels = {
            name: _arrays(batch, names)
            for name, names in (("states", _STATES), ("innovations", _INNOVATIONS))
            if any(key in batch for key in names)
        }
        if not channels:
            raise ValueError("batch has neither truth, estimates and covariances nor innovations")
        runs, *others = {len(arrays[0]) for arrays in channels.values()}
        if others:
            raise ValueError(f"states and innovations differ in their runs: {runs}, {others[0]}")
        self._require_new(first_run, runs)
        shape = {name: list(arrays[0].shape[1:]) for name, arrays in channels.items()}
        if self.shape is not None:
            self._take_shape(shape)
        parts = {name: self._sums(name, arrays, first_run) for name, arrays in channels.items()}
        self._take_shape(shape)
        counts: dict[str, Counts] = {}
        for name, (_, _, under, histogram) in parts.items():
            counts |= {f"{name} under": under, f"{name} histogram": histogram}
        rows = np.concatenate([part[0] for part in parts.values()], axis=1)
        self._add_nodes(first_run, runs, rows, counts)
        return {name: part[1] for name, part in parts.items()}

    def _sums(
        self, name: str, arrays: Sequence[Floats], first_run: int
    ) -> tuple[Floats, Floats, Counts, Counts]:
        truth, covariances = arrays[0], arrays[-1]
        estimates = arrays[1] if name == "states" else None
        d = truth.shape[2]
        setting = "angles" if name == "states" else "innovation_angles"
        periods = np.zeros(d)
        for index, period in self.settings[setting]:
            if index >= d:
                raise ValueError(f"{setting} names component {index} of {d}")
            periods[index] = period
        thresholds = np.asarray(chi2_quantile(np.array(self.settings["levels"]), d), np.float64)
        found: tuple[Floats, Floats, Counts, Counts] = _backend.kernels.consistency_sums(
            truth,
            estimates,
            covariances,
            periods,
            first_run,
            float(DECIBELS * chi2_log_mean(d)),
            thresholds,
        )
        return found

    def result(self, confidence: float = 0.95) -> ConsistencySummary:
        """The statistics of the runs so far, with intervals of this confidence."""
        total = self._total()
        found: dict[str, ErrorStatistics] = {}
        start = 0
        for name, (steps, d) in (self.shape or {}).items():
            width = steps * (4 + 3 * d)
            row = np.zeros(width) if total is None else total[start : start + width]
            under, histogram = self._counts[f"{name} under"], self._counts[f"{name} histogram"]
            levels = tuple(self.settings["levels"])
            sign = -1.0 if name == "states" else 1.0
            found[name] = ErrorStatistics.of(
                row, d, under, histogram, levels, confidence, sign=sign
            )
            start += width
        return ConsistencySummary(self.runs, found.get("states"), found.get("innovations"))

    def _sizes(self) -> tuple[int, dict[str, tuple[int, ...]]]:
        width = 0
        counts: dict[str, tuple[int, ...]] = {}
        for name, (steps, d) in (self.shape or {}).items():
            width += steps * (4 + 3 * d)
            counts[f"{name} under"] = (1 + len(self.settings["levels"]), steps)
            counts[f"{name} histogram"] = (steps, BINS)
        return width, counts


def _periods(argument: str, angles: Mapping[int, float] | None) -> list[list[float]]:
    """Pairs of component and period, sorted, as JSON keeps them."""
    if not isinstance(angles or {}, Mapping):
        raise TypeError(f"{argument} must map components to periods, got {value(angles)}")
    pairs = []
    for index, given in (angles or {}).items():
        if _check.whole(argument, index) < 0:
            raise ValueError(f"{argument} must name components from 0, got {value(index)}")
        period = _check.number(f"{argument}[{index}]", given)
        if not (period > 0 and np.isfinite(period)):
            raise errors.parameter(f"{argument}[{index}]", "positive and finite", period)
        pairs.append([int(index), period])
    return sorted(pairs)


def _arrays(batch: Mapping[str, Any], names: Sequence[str]) -> list[Floats]:
    """The arrays of a channel, with shapes that fit together."""
    if missing := [name for name in names if name not in batch]:
        given = " and ".join(name for name in names if name in batch)
        raise ValueError(f"batch has {given} but not {' and '.join(missing)}")
    arrays = [_check.floats(name, batch[name]) for name in names]
    shape = arrays[0].shape
    if len(shape) != 3 or 0 in shape[1:]:
        raise errors.shape(names[0], shape, "(runs, steps, d)")
    for name, array in zip(names[1:-1], arrays[1:-1], strict=True):
        if array.shape != shape:
            raise errors.shape(name, array.shape, str(shape))
    if arrays[-1].shape != (*shape, shape[-1]):
        raise errors.shape(names[-1], arrays[-1].shape, str((*shape, shape[-1])))
    return arrays
