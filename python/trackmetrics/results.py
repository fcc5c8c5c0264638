"""What the functions give back.

The NamedTuples are those of ``pytcl.performance_evaluation``, field for field.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _deprecated


def to_json(value: Any) -> Any:
    """A value as JSON knows it: numbers, strings, lists and dictionaries.

    NaN (undefined) becomes None, infinities become ``"inf"`` and ``"-inf"``.
    """
    if hasattr(value, "to_dict"):
        return to_json(value.to_dict())
    if isinstance(value, np.ndarray | np.generic):
        return to_json(value.tolist())
    if isinstance(value, float):
        if math.isnan(value):
            return None
        return value if math.isfinite(value) else str(value)
    if isinstance(value, Mapping):
        return {str(key): to_json(item) for key, item in value.items()}
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        return to_json(value._asdict())
    if isinstance(value, list | tuple):
        return [to_json(item) for item in value]
    return value


class Result:
    """Base of the frozen dataclasses that functions return."""

    def to_dict(self) -> dict[str, Any]:
        """The fields by name, ready for JSON.

        Arrays become lists; what is undefined (NaN) becomes None, infinities ``"inf"`` and
        ``"-inf"``.
        """
        return {f.name: to_json(getattr(self, f.name)) for f in fields(self)}  # type: ignore[arg-type]


class OSPAResult(NamedTuple):
    """OSPA distance and its two parts, all in the unit of the points; 0 is best, ``c`` is worst.

    ``ospa ** p == localization ** p + cardinality ** p``.
    """

    ospa: float
    """The distance."""
    localization: float
    """The part due to the distances of matched points."""
    cardinality: float
    """The part due to the difference in cardinality."""


@dataclass(frozen=True, eq=False)
class AuctionAssignment(Result):
    """A complete matching whose total cost is within a bound of the best one."""

    row_ind: NDArray[np.int64]
    """The matched rows, rising."""
    col_ind: NDArray[np.int64]
    """The column of each of them."""
    epsilon: float
    """The last epsilon of the auction, in the unit of the costs."""
    bound: float
    """The total cost is at most this far from the best one, in the unit of the costs: at most
    ``n * epsilon`` and the rounding of a sum, and 0 where the matching is proved optimal."""


@dataclass(frozen=True, eq=False)
class BottleneckAssignment(Result):
    """A complete matching whose largest cost is as small as it can be."""

    cost: float
    """The largest cost of a pair, in the unit of the costs; NaN where there are no pairs."""
    row_ind: NDArray[np.int64]
    """The matched rows, rising."""
    col_ind: NDArray[np.int64]
    """The column of each of them."""


class MOTMetrics(NamedTuple):
    """CLEAR MOT scores of a sequence, and the counts that they are made of."""

    mota: float
    """Accuracy: 1 is best, and it has no lower bound."""
    motp: float
    """Mean distance of the matched pairs, in the unit of the points; 0 is best."""
    num_switches: int
    """Pairs whose truth index had another estimate index in the remembered frame."""
    num_fragmentations: int
    """Pairs whose truth index had a pair before, but none in the remembered frame."""
    num_false_positives: int
    """Estimates without a pair."""
    num_misses: int
    """Truth points without a pair."""


class ConsistencyResult(NamedTuple):
    """Whether the mean of NEES or NIS values lies in its acceptance interval, and its limits."""

    is_consistent: bool
    """Whether the mean lies within the bounds, both included."""
    statistic: float
    """The mean of the values."""
    lower_bound: float
    """Lower bound of the acceptance interval; below it, the filter is pessimistic."""
    upper_bound: float
    """Upper bound of the acceptance interval; above it, the filter is optimistic."""
    mean_value: float
    """The mean of the values, once more."""


@dataclass(frozen=True, eq=False)
class OSPA2Result(Result):
    """OSPA(2) over time; ``distance ** p == localization ** p + cardinality ** p`` at each time."""

    times: NDArray[np.float64]
    """When it was evaluated, shape (T,)."""
    distance: NDArray[np.float64]
    """The distance, in the unit of the states; 0 is best, ``c`` is worst."""
    localization: NDArray[np.float64]
    """The part due to the distances of matched tracks."""
    cardinality: NDArray[np.float64]
    """The part due to the difference in the number of tracks."""

    ospa2 = _deprecated.attribute("distance")


@dataclass(frozen=True, eq=False)
class GOSPAResult(Result):
    """GOSPA distance of two sets of points, its parts, and the pairs behind it; 0 is best.

    ``localization + missed + false == distance ** p`` for ``alpha = 2``; the parts do not exist
    otherwise and are NaN.
    """

    distance: float
    """The distance, in the unit of the points."""
    localization: float
    """The sum of ``d ** p`` over the pairs."""
    missed: float
    """``c ** p / 2`` for each point of the truth without a partner."""
    false: float
    """``c ** p / 2`` for each estimate without a partner."""
    num_missed: int
    """Points of the truth without a partner closer than ``c``."""
    num_false: int
    """Estimates without a partner closer than ``c``."""
    assignment: NDArray[np.int64]
    """The pairs closer than ``c``, shape (k, 2): index in X, index in Y; the first rises."""


@dataclass(frozen=True, eq=False)
class TrajectoryGOSPAResult(Result):
    """Trajectory GOSPA and its parts over time, which are p-th powers and add up:
    ``distance ** p == sum(totals().values())``."""

    distance: float
    """The distance, in the unit of the states; 0 is best."""
    times: NDArray[np.float64]
    """The times at which something exists, shape (T,)."""
    localization: NDArray[np.float64]
    """Due to the distances of states that are followed, shape (T,)."""
    missed: NDArray[np.float64]
    """Due to states of the truth that no track follows, shape (T,)."""
    false: NDArray[np.float64]
    """Due to states of tracks that follow no truth, shape (T,)."""
    switching: NDArray[np.float64]
    """Due to changes from each time to the next, shape (T - 1,)."""

    def totals(self) -> dict[str, float]:
        """The four parts, summed over time."""
        names = ("localization", "missed", "false", "switching")
        return {name: float(getattr(self, name).sum()) for name in names}


@dataclass(frozen=True, eq=False)
class GOSPASequence(Result):
    """GOSPA at every frame of two sequences; each field has shape (T,)."""

    distance: NDArray[np.float64]
    """The distance, in the unit of the points; 0 is best."""
    localization: NDArray[np.float64]
    """The sum of ``d ** p`` over the pairs; NaN unless ``alpha = 2``, as the next two."""
    missed: NDArray[np.float64]
    """``c ** p / 2`` for each point of the truth without a partner."""
    false: NDArray[np.float64]
    """``c ** p / 2`` for each estimate without a partner."""
    num_missed: NDArray[np.int64]
    """Points of the truth without a partner closer than ``c``."""
    num_false: NDArray[np.int64]
    """Estimates without a partner closer than ``c``."""
