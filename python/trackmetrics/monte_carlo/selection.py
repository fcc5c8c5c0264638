"""The best setting of a sweep by a criterion, with confidence intervals.

A criterion is a function g of means over runs. Its value at a setting has, to first order, the
influence g'(mean) (x - mean) of each run (or block of runs) x; the differences of two settings'
influences, run by run, give the interval of the difference of their values.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _deprecated
from trackmetrics.monte_carlo.accumulators.scores import ScoreAccumulator
from trackmetrics.monte_carlo.run_tree import Floats
from trackmetrics.results import Result

Interval = tuple[float, float]


@dataclass(frozen=True)
class BestSetting(Result):
    """The best setting by a criterion."""

    index: int
    """Its place in the grid."""
    settings: dict[str, Any]
    """The setting."""
    criterion: str
    """What was compared."""
    value: float
    """Of the best setting."""
    interval: Interval
    """Of the value."""
    runner_up: dict[str, Any] | None
    """The next setting; None where there is only one."""
    difference: float
    """How much worse the next setting is, in the criterion's unit."""
    difference_interval: Interval
    """Of the difference, from runs paired by their random numbers."""
    significant: bool
    """Whether that interval lies on one side of 0."""

    words = _deprecated.attribute("describe")

    def describe(self) -> list[str]:
        """The result in one or two sentences."""
        low, high = self.interval
        said = [f"best by {self.criterion}: {self.value:.4g} [{low:.4g}, {high:.4g}]"]
        if self.runner_up is not None:
            low, high = self.difference_interval
            verdict = "significant" if self.significant else "not significant"
            worse = f"the next is worse by {self.difference:.4g} [{low:.4g}, {high:.4g}]"
            said.append(f"{worse}, {verdict}")
        return said


@dataclass(frozen=True)
class Criterion:
    """A function of the means of some scores; less is better."""

    text: str
    names: list[str]
    value: Callable[[Floats], float]
    gradient: Callable[[Floats], Floats]
    sign: float = 1.0
    logarithmic: bool = False
    """Whether the value is |ln mean|, whose interval is that of ln mean, folded at 0."""


def criterion_of(
    by: str,
    known: Sequence[str],
    states: Sequence[int] | None,
    maximize: bool,
    plain: bool = False,
) -> Criterion:
    """The criterion of this name."""
    if by in ("anees", "anis") and not plain:
        name = {"anees": "nees", "anis": "nis"}[by]
        _require([name], known)
        return Criterion(
            f"|ln {by}|",
            [name],
            lambda m: abs(np.log(m[0])),
            lambda m: np.sign(np.log(m)) / m,
            logarithmic=True,
        )
    if by == "rmse" and not plain and by not in known:
        names = [name for name in known if name.startswith("squared_error[")]
        if states is not None:
            names = [f"squared_error[{j}]" for j in states]
        _require(names or ["squared_error[0]"], known)
        return Criterion(
            f"rmse of states {', '.join(name[14:-1] for name in names)}",
            names,
            lambda m: float(np.sqrt(m.sum())),
            lambda m: np.full(len(m), 0.5 / np.sqrt(m.sum())) if m.sum() else np.zeros(len(m)),
        )
    _require([by], known)
    sign = -1.0 if maximize else 1.0
    return Criterion(by, [by], lambda m: float(m[0]), lambda m: np.ones(1), sign)


def _require(names: Sequence[str], known: Sequence[str]) -> None:
    for name in names:
        if name not in known:
            raise ValueError(f"there is no score {name!r}, there are {', '.join(known)}")


def select_best(
    grid: Sequence[dict[str, Any]],
    scores: Sequence[ScoreAccumulator | None],
    by: str,
    states: Sequence[int] | None,
    maximize: bool,
    confidence: float,
) -> BestSetting:
    """The best of the settings."""
    known = next((cell.names for cell in scores if cell is not None), [])
    criterion = criterion_of(by, known, states, maximize)
    values = [np.nan if cell is None else _value(cell, criterion) for cell in scores]
    if np.isnan(values).all():
        raise ValueError(f"no setting has a {criterion.text}")
    order = np.argsort(criterion.sign * np.array(values), kind="stable")
    first = int(order[0])
    best = scores[first]
    assert best is not None  # NaN is sorted last
    value, interval = estimate(best, criterion, confidence)
    second = int(order[1]) if len(order) > 1 and not np.isnan(values[order[1]]) else None
    difference, spread = np.nan, np.nan
    if second is not None:
        other = scores[second]
        assert other is not None
        difference = values[second] - value
        spread = _paired_spread(best, other, criterion, confidence)
    low, high = difference - spread, difference + spread
    return BestSetting(
        index=first,
        settings=grid[first],
        criterion=criterion.text,
        value=value,
        interval=interval,
        runner_up=None if second is None else grid[second],
        difference=float(difference),
        difference_interval=(float(low), float(high)),
        significant=bool(low > 0 or high < 0),
    )


def estimate(
    cell: ScoreAccumulator, criterion: Criterion, confidence: float
) -> tuple[float, Interval]:
    """The value of a criterion, with its interval."""
    value = _value(cell, criterion)
    _, influences = _influences(cell, criterion)
    spread = _half_width(influences, confidence)
    if not criterion.logarithmic:
        return value, (value - spread, value + spread)
    (mean,) = _means(cell, criterion)
    ends = sorted((np.log(mean) - spread, np.log(mean) + spread))
    if ends[0] <= 0 <= ends[1]:
        return value, (0.0, float(max(-ends[0], ends[1])))
    low, high = sorted(abs(end) for end in ends)
    return value, (float(low), float(high))


def _means(cell: ScoreAccumulator, criterion: Criterion) -> Floats:
    means = cell.means()
    return np.array([means[name] for name in criterion.names])


def _value(cell: ScoreAccumulator, criterion: Criterion) -> float:
    return float(criterion.value(_means(cell, criterion)))


def _influences(cell: ScoreAccumulator, criterion: Criterion) -> tuple[NDArray[np.int64], Floats]:
    """First run and influence of every block that has all scores."""
    gradient = criterion.gradient(_means(cell, criterion))
    blocks = [cell.blocks(name) for name in criterion.names]
    starts = blocks[0][0]
    for others, _ in blocks[1:]:
        starts = np.intersect1d(starts, others)
    total = np.zeros(len(starts))
    for slope, (places, means) in zip(gradient, blocks, strict=True):
        total += slope * means[np.isin(places, starts)]
    return starts, total


def _paired_spread(
    ours: ScoreAccumulator, theirs: ScoreAccumulator, criterion: Criterion, confidence: float
) -> float:
    """Half the width of the interval of a difference, from the blocks that both have."""
    (a, x), (b, y) = _influences(ours, criterion), _influences(theirs, criterion)
    both = np.intersect1d(a, b)
    return _half_width(x[np.isin(a, both)] - y[np.isin(b, both)], confidence)


def _half_width(values: Floats, confidence: float) -> float:
    from scipy.special import stdtrit

    if len(values) < 2:
        return float("nan")
    quantile = stdtrit(len(values) - 1, (1 + confidence) / 2)
    return float(quantile * values.std(ddof=1) / np.sqrt(len(values)))
