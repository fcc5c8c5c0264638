"""OSPA and GOSPA over many runs, step by step."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _backend, errors, point_sets
from trackmetrics.monte_carlo.accumulators.base import Accumulator
from trackmetrics.monte_carlo.accumulators.histogram import BINS, quantiles
from trackmetrics.monte_carlo.run_tree import Floats
from trackmetrics.results import Result

_COLUMNS = ("ospa", "gospa", "localization", "missed", "false")


@dataclass(frozen=True, repr=False)
class PointSetSummary(Result):
    """OSPA and GOSPA over runs, step by step, ``(steps,)`` each."""

    runs: int
    """How many runs."""
    ospa: Floats
    """Mean OSPA, in the unit of the points; 0 is best, ``c`` is worst."""
    ospa_deviation: Floats
    """Its standard deviation over runs."""
    gospa: Floats
    """Mean GOSPA, in the unit of the points; 0 is best."""
    gospa_deviation: Floats
    """Its standard deviation over runs."""
    localization: Floats
    """Mean of the sum of ``d ** p`` over the pairs."""
    missed: Floats
    """Mean of ``c ** p / 2`` for each point of the truth without a partner."""
    false: Floats
    """Mean of ``c ** p / 2`` for each estimate without a partner."""
    ospa_histogram: NDArray[np.int64]
    """Counts of OSPA, ``(steps, bins)``."""
    gospa_histogram: NDArray[np.int64]
    """Counts of GOSPA, ``(steps, bins)``."""

    def ospa_quantiles(self, levels: Sequence[float]) -> Floats:
        """Quantiles of OSPA over runs, ``(levels, steps)``, wrong by at most 12 %."""
        return quantiles(self.ospa_histogram, levels)

    def gospa_quantiles(self, levels: Sequence[float]) -> Floats:
        """Quantiles of GOSPA over runs, ``(levels, steps)``, wrong by at most 12 %."""
        return quantiles(self.gospa_histogram, levels)

    def __repr__(self) -> str:
        means = f"ospa={np.mean(self.ospa):.4g}, gospa={np.mean(self.gospa):.4g}"
        return f"PointSetSummary(runs={self.runs}, steps={len(self.ospa)}, {means})"


class PointSetAccumulator(Accumulator):
    """Mean OSPA and GOSPA with its parts over many runs, step by step, and their quantiles.

    Parameters
    ----------
    c : float
        Cutoff, in the unit of the points.
    p : float
        Order, at least 1.

    Notes
    -----
    Sums have the same bits however the runs are cut; quantiles are read from histograms. GOSPA is
    that of ``alpha = 2``, whose parts add up: ``gospa ** p == localization + missed + false``.

    Examples
    --------
    >>> import numpy as np
    >>> points = PointSetAccumulator(c=10.0)
    >>> truth = [[np.zeros((1, 2)), np.zeros((2, 2))]]        # one run of two steps
    >>> estimates = [[np.ones((1, 2)), np.zeros((1, 2))]]
    >>> points.update({"truth": truth, "estimates": estimates}, first_run=0)
    >>> points.result().missed.tolist()
    [0.0, 50.0]
    """

    kind = "PointSetAccumulator"

    def __init__(self, c: float, p: float = 2.0) -> None:
        if not (c > 0 and np.isfinite(c)):
            raise errors.parameter("c", "positive and finite", c)
        if not (p >= 1 and np.isfinite(p)):
            raise errors.parameter("p", "at least 1 and finite", p)
        super().__init__({"c": float(c), "p": float(p)})

    def update(self, batch: Mapping[str, Any], first_run: int) -> None:
        """Takes in a batch of runs, the first of which has the number ``first_run``.

        Parameters
        ----------
        batch : mapping of str to sequence of runs
            ``truth`` and ``estimates``: for each run, for each step, a set of points.
        first_run : int
            Number of the first run; runs may come in any order, each once.

        Raises
        ------
        ValueError
            Where runs differ in their steps, or a coordinate is not finite.
        """
        truth, estimates = batch["truth"], batch["estimates"]
        if len(truth) != len(estimates):
            raise errors.length("estimates", len(estimates), "truth", len(truth), "runs")
        if not len(truth):
            return
        steps = len(truth[0])
        for name, sets in (("truth", truth), ("estimates", estimates)):
            for run, frames in enumerate(sets):
                if len(frames) != steps:
                    raise errors.length(f"{name}[{run}]", len(frames), "truth[0]", steps, "steps")
        runs = len(truth)
        self._require_new(first_run, runs)
        values = self._values(_flat(truth), _flat(estimates)).reshape(5, runs, steps)
        self._take_shape({"steps": steps})
        squares = values[:2] ** 2
        columns = np.concatenate([values, squares]).swapaxes(0, 1).reshape(runs, 7 * steps)
        kernels = _backend.kernels
        counts = {
            name: kernels.histograms(np.ascontiguousarray(values[i]))
            for i, name in enumerate(("ospa", "gospa"))
        }
        sums = kernels.run_sums(np.ascontiguousarray(columns), first_run)
        self._add_nodes(first_run, runs, sums, counts)

    def _values(self, truth: list[Any], estimates: list[Any]) -> Floats:
        """OSPA, GOSPA and its parts of every step of every run."""
        c, p = self.settings["c"], self.settings["p"]
        gospa = point_sets.gospa_over_time(truth, estimates, c, p)
        ospa = point_sets.ospa_over_time(truth, estimates, c, p)
        return np.array([ospa, gospa.distance, gospa.localization, gospa.missed, gospa.false])

    def result(self) -> PointSetSummary:
        """The statistics of the runs so far."""
        steps = self.shape["steps"] if self.shape else 0
        total = self._total()
        sums = np.zeros((7, steps)) if total is None else total.reshape(7, steps)
        n = np.float64(self.runs)
        with np.errstate(invalid="ignore", divide="ignore"):
            means = sums / n
            variances = np.maximum(means[5:] - means[:2] ** 2, 0.0) * (n / (n - 1))
        ospa, gospa, localization, missed, false = means[:5]
        none = np.zeros((0, 0), np.int64)
        return PointSetSummary(
            runs=self.runs,
            ospa=ospa,
            ospa_deviation=np.sqrt(variances[0]),
            gospa=gospa,
            gospa_deviation=np.sqrt(variances[1]),
            localization=localization,
            missed=missed,
            false=false,
            ospa_histogram=self._counts.get("ospa", none),
            gospa_histogram=self._counts.get("gospa", none),
        )

    def _sizes(self) -> tuple[int, dict[str, tuple[int, ...]]]:
        steps = self.shape["steps"] if self.shape else 0
        return 7 * steps, dict.fromkeys(("ospa", "gospa"), (steps, BINS)) if self.shape else {}


def _flat(runs: Sequence[Sequence[Any]]) -> list[Any]:
    return [frame for frames in runs for frame in frames]
