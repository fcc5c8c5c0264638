"""The result of a sweep: statistics of every setting and step."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np

from trackmetrics import _deprecated
from trackmetrics.monte_carlo import tables
from trackmetrics.monte_carlo.accumulators.consistency import ConsistencyAccumulator
from trackmetrics.monte_carlo.accumulators.scores import ScoreAccumulator
from trackmetrics.monte_carlo.consistency_summary import ConsistencySummary, ErrorStatistics
from trackmetrics.monte_carlo.run_tree import Floats
from trackmetrics.monte_carlo.selection import BestSetting, select_best
from trackmetrics.monte_carlo.setting_state import Failure, SettingState

Rows = Literal["steps", "settings"]


@dataclass(frozen=True, repr=False)
class SweepResult:
    """Statistics of every setting and step of a sweep."""

    runs: int
    """Requested runs of each setting."""
    seed: Any
    """The seed of the random numbers."""
    grid: list[dict[str, Any]]
    """The settings."""
    setting_states: list[SettingState]
    """What was accumulated for each setting."""

    tallies = _deprecated.attribute("setting_states")
    done = _deprecated.attribute("completed_runs")

    @property
    def completed_runs(self) -> list[int]:
        """Runs of each setting that are done, failed ones too."""
        return [len(state) for state in self.setting_states]

    @property
    def complete(self) -> bool:
        """Whether every run of every setting is done."""
        return all(done == self.runs for done in self.completed_runs)

    @property
    def failures(self) -> list[Failure]:
        """The runs that failed, by setting and run."""
        return [
            Failure(run, settings, *state.failures[run])
            for settings, state in zip(self.grid, self.setting_states, strict=True)
            for run in sorted(state.failures)
        ]

    @cached_property
    def consistency(self) -> list[ConsistencySummary]:
        """The statistics of errors and innovations of each setting."""
        found = [state.accumulators.get("consistency") for state in self.setting_states]
        if not any(isinstance(cell, ConsistencyAccumulator) for cell in found):
            raise ValueError("no run gave truth, estimates and covariances, or innovations")
        return [
            cell.result() if isinstance(cell, ConsistencyAccumulator) else
            ConsistencySummary(0, None, None)
            for cell in found
        ]  # fmt: skip

    @property
    def anees(self) -> Floats:
        """Average NEES over runs by the dimension, ``(settings, steps)``; 1 is consistent."""
        return self._stacked("states", "mean")

    @property
    def anees_interval(self) -> Floats:
        """Acceptance interval of the ANEES, ``(2,)``; ``(settings, 2)`` where settings
        have different numbers of runs."""
        return _one_or_each(self._stacked("states", "interval"))

    @property
    def anis(self) -> Floats:
        """Average NIS over runs by the dimension, ``(settings, steps)``; 1 is consistent."""
        return self._stacked("innovations", "mean")

    @property
    def rmse(self) -> Floats:
        """Root mean square error over runs, ``(settings, steps, n)``; 0 is best."""
        return self._stacked("states", "rmse")

    @property
    def rmse_interval(self) -> Floats:
        """Its interval, ``(settings, steps, n, 2)``."""
        return self._stacked("states", "rmse_interval")

    @cached_property
    def coverage(self) -> dict[float, Floats]:
        """For each probability the share of errors inside that region, ``(settings, steps)``."""
        forms = self._forms("states")
        levels = next(form.coverage for form in forms if form is not None)
        return {
            level: _stack([None if form is None else form.coverage[level] for form in forms])
            for level in levels
        }

    def __getitem__(self, name: str) -> list[Any]:
        """For each setting the result of the accumulators that runs returned as ``name``."""
        found = [state.accumulators.get(name) for state in self.setting_states]
        if not any(found):
            raise KeyError(name)
        return [None if cell is None else cell.result() for cell in found]

    @cached_property
    def scores(self) -> dict[str, Floats]:
        """Mean over runs of every score, ``(settings,)``: ``nees`` and ``nis`` (means over steps of
        q / n), ``squared_error[j]`` of each state, and those that the runs returned."""
        means = [cell.means() if cell else {} for cell in self._score_accumulators()]
        names = list(dict.fromkeys(name for found in means for name in found))
        return {name: np.array([found.get(name, np.nan) for found in means]) for name in names}

    def best(
        self,
        by: str = "anees",
        *,
        states: Sequence[int] | None = None,
        maximize: bool = False,
        confidence: float = 0.95,
    ) -> BestSetting:
        """The best setting, and whether the next one is significantly worse.

        Parameters
        ----------
        by : str
            ``"anees"`` or ``"anis"``: the least distance from 0 of ln(mean over runs and steps of
            q / n), which is 0 for a consistent filter. ``"rmse"``: the least root of the summed
            mean squared errors of ``states``, which must have one unit. Or the name of a score.
        states : sequence of int
            For ``"rmse"``; by default all.
        maximize : bool
            Whether more of that score is better.
        confidence : float
            Of the intervals.

        Notes
        -----
        Runs are paired, since all settings have the same random numbers. The value of the best of
        many settings is biased towards better values, because it was selected by that value.
        """
        found = self._score_accumulators()
        return select_best(self.grid, found, by, states, maximize, confidence)

    def to_columns(self, rows: Rows = "steps") -> dict[str, list[Any]]:
        """A tidy table: one row for each setting and step, or for each setting, by columns."""
        if rows not in ("steps", "settings"):
            raise ValueError(f"rows must be 'steps' or 'settings', got {rows!r}")
        if rows == "steps":
            return tables.step_table(self.grid, self.consistency)
        failed = [len(state.failures) for state in self.setting_states]
        scores = list(self.scores)
        return tables.setting_table(
            self.grid, self.completed_runs, failed, self._score_accumulators(), scores
        )

    def to_pandas(self, rows: Rows = "steps") -> Any:
        """A pandas ``DataFrame`` of :meth:`to_columns`."""
        import pandas as pd

        return pd.DataFrame(self.to_columns(rows))

    def to_polars(self, rows: Rows = "steps") -> Any:
        """A polars ``DataFrame`` of :meth:`to_columns`."""
        import polars as pl

        return pl.DataFrame(self.to_columns(rows))

    def to_parquet(self, path: str | os.PathLike[str], rows: Rows = "steps") -> None:
        """Writes :meth:`to_columns` as Parquet, by `polars`."""
        self.to_polars(rows).write_parquet(path)

    def to_dict(self) -> dict[str, Any]:
        """Settings, scores and failures, ready for JSON."""
        return {
            "runs": self.runs,
            "seed": self.seed,
            "complete": self.complete,
            "settings": self.to_columns("settings"),
            "failures": [failure.to_dict() for failure in self.failures],
        }

    def to_bytes(self) -> bytes:
        """Everything that was accumulated: the same bytes for the same seed, grid and runs."""
        return b"".join(state.to_bytes() for state in self.setting_states)

    def __repr__(self) -> str:
        failed = len(self.failures)
        parts = [f"settings={len(self.grid)}", f"runs={self.runs}"]
        parts += [] if self.complete else [f"done={sum(self.completed_runs)}"]
        parts += [f"failed={failed}"] if failed else []
        parts += [f"{name}={values.round(4).tolist()}" for name, values in self.scores.items()]
        return f"SweepResult({', '.join(parts)})"

    def _score_accumulators(self) -> list[ScoreAccumulator | None]:
        found = [state.accumulators.get("scores") for state in self.setting_states]
        return [cell if isinstance(cell, ScoreAccumulator) else None for cell in found]

    def _forms(self, channel: str) -> list[ErrorStatistics | None]:
        forms = [getattr(result, channel) for result in self.consistency]
        if not any(forms):
            raise ValueError(f"no run gave {'truth' if channel == 'states' else channel}")
        return forms

    def _stacked(self, channel: str, name: str) -> Floats:
        return _stack([form and getattr(form, name) for form in self._forms(channel)])


def _stack(arrays: list[Any]) -> Floats:
    """NaN for a setting of which nothing is known."""
    like = next(array for array in arrays if array is not None)
    return np.stack([np.full_like(like, np.nan) if a is None else a for a in arrays])


def _one_or_each(intervals: Floats) -> Floats:
    same = (intervals == intervals[:1]).all()
    first: Floats = intervals[0]
    return first if same else intervals
