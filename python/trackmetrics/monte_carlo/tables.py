"""Tidy tables of a sweep, as columns."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from trackmetrics.monte_carlo.accumulators.scores import ScoreAccumulator
from trackmetrics.monte_carlo.consistency_summary import ConsistencySummary, ErrorStatistics
from trackmetrics.monte_carlo.selection import criterion_of, estimate

Grid = Sequence[dict[str, Any]]
Columns = dict[str, list[Any]]


def step_table(grid: Grid, summaries: Sequence[ConsistencySummary]) -> Columns:
    """One row for each setting and step."""
    tables = []
    for settings, found in zip(grid, summaries, strict=True):
        columns: dict[str, Any] = {}
        for prefix, form in (("", found.states), ("innovation_", found.innovations)):
            if form is not None:
                columns |= _columns(form, "anis" if prefix else "anees", prefix)
        steps = len(next(iter(columns.values()), []))
        constant = {name: [value] * steps for name, value in settings.items()}
        tables.append({**constant, "step": list(range(steps)), **columns})
    names = dict.fromkeys(name for table in tables for name in table)
    return {
        name: [x for table in tables for x in table.get(name, [None] * len(table["step"]))]
        for name in names
    }


def _columns(form: ErrorStatistics, mean: str, prefix: str) -> Columns:
    interval = np.broadcast_to(form.interval, (len(form.runs), 2))
    columns: dict[str, Any] = {
        f"{prefix}runs": form.runs,
        mean: form.mean,
        f"{mean}_low": interval[:, 0],
        f"{mean}_high": interval[:, 1],
        f"{prefix}deviation": form.deviation,
        f"{prefix}inclination": form.inclination,
        f"{prefix}noncredibility": form.noncredibility,
    }
    for level, share in form.coverage.items():
        columns[f"{prefix}coverage_{level:g}"] = share
    for j in range(form.dimension):
        columns[f"{prefix}rmse_{j}"] = form.rmse[:, j]
        columns[f"{prefix}bias_{j}"] = form.bias[:, j]
        columns[f"{prefix}normalized_mean_error_{j}"] = form.normalized_mean_error[:, j]
    return {name: np.asarray(column).tolist() for name, column in columns.items()}


def setting_table(
    grid: Grid,
    done: Sequence[int],
    failed: Sequence[int],
    cells: Sequence[ScoreAccumulator | None],
    scores: Sequence[str],
) -> Columns:
    """One row for each setting: its runs, and each score with its interval."""
    columns: Columns = {name: [settings[name] for settings in grid] for name in grid[0]}
    columns["runs"] = [runs - lost for runs, lost in zip(done, failed, strict=True)]
    columns["failed"] = list(failed)
    for name in scores:
        criterion = criterion_of(name, [name], None, False, plain=True)
        found = [
            estimate(cell, criterion, 0.95) if cell else (np.nan, (np.nan, np.nan))
            for cell in cells
        ]
        columns[name] = [float(value) for value, _ in found]
        columns[f"{name}_low"] = [float(interval[0]) for _, interval in found]
        columns[f"{name}_high"] = [float(interval[1]) for _, interval in found]
    return columns
