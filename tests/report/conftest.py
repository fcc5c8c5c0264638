"""Diagnoses and logs for the figures: made by hand, so that what is drawn is known."""

import csv
import math
import os
import shutil
from dataclasses import replace

import numpy as np
import pytest

from trackmetrics import report
from trackmetrics.diagnostics import (
    VERDICTS,
    Bias,
    Diagnosis,
    InnovationCorrelation,
    Outlier,
    QuantityVerdict,
    Segment,
    StateDiagnosis,
    diagnose,
)
from trackmetrics.logs import EstimatorLog, State

STATES = (
    State("lat", "deg"),
    State("lon", "deg", 360.0),
    State("sog", "kt"),
    State("cog", "deg", 360.0),
    State("turn_rate", "deg/s"),
)
FULL, SHORT = "AISMeasurement", "PositionMeasurement"


def synthetic_log(tracks, updates=60, seed=1, states=STATES):
    """Noise of consistent filters, apart from every third track, whose errors grow late."""
    rng = np.random.default_rng(seed)
    n, parts = len(states), []
    for i in range(tracks):
        time = 1.7e9 + 7.0 * i + 60.0 * np.cumsum(rng.integers(1, 6, updates))
        full = rng.random(updates) < 0.4
        std = np.array([0.002, 0.004, 1.2, 6.0, 0.05][:n]) * rng.uniform(0.6, 1.6, (updates, n))
        truth = np.array([54.0 + i, 10.0, 12.0, 350.0, 0.0][:n]) + np.outer(
            np.linspace(0, 1, updates), [0.4, 0.3, 1.0, 40.0, 0.01][:n]
        )
        late = np.where((np.arange(updates) > 0.7 * updates) & (i % 3 == 0), 3.0, 1.0)
        x = truth + std * rng.standard_normal((updates, n)) * late[:, None]
        x[:, 3] %= 360.0
        truth[:, 3] %= 360.0
        parts.append((f"vessel {i:03d}", time, full, std, truth, x))
    join = lambda k: np.concatenate([part[k] for part in parts])  # noqa: E731
    full, x, std = join(2), join(5), join(3)
    z = np.where(full[:, None], x[:, :4], np.where(np.arange(4) < 2, x[:, :4], np.nan))
    observed = [[0, 1, 2, 3] if f else [0, 1] for f in full]
    dof = np.where(full, 4.0, 2.0)
    status = np.array(["active"] * len(full), object)
    status[np.arange(len(full)) % updates < 2] = "tentative"
    nis = np.where(status == "active", rng.chisquare(dof), np.nan)
    return EstimatorLog.from_columns(
        states=states,
        track=[name for name, *_ in parts for _ in range(updates)],
        time=join(1),
        status=status,
        measurement_type=np.where(full, FULL, SHORT),
        observed=observed,
        z=[row[np.isfinite(row)] for row in z],
        nis=nis,
        nis_dof=dof,
        x=x,
        truth=join(4),
        P=np.stack([np.diag(row**2) for row in std]),
    )


def published_log(folder):
    """The published run as a log."""
    text = (folder / "published_run" / "updates.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(text.splitlines()))
    number = lambda row, key: float(row[key]) if row[key] else math.nan  # noqa: E731
    column = lambda key: [number(row, key) for row in rows]  # noqa: E731
    full = [row["measurement_type"] == FULL for row in rows]
    stds = ("std_lat_deg", "std_lon_deg", "std_sog_kts", "std_cog_deg", "std_turn_rate")
    nis = column("nis_recovered")
    # Of the states only speed and course are published: the others are missing.
    partial = lambda kind, blank: [  # noqa: E731
        (*[math.nan] * 2, sog, cog, *[math.nan] * blank)
        for sog, cog in zip(column(f"sog_{kind}_kts"), column(f"cog_{kind}_deg"), strict=True)
    ]
    return EstimatorLog.from_columns(
        states=STATES,
        track=[row["track"] for row in rows],
        time=column("time"),
        status=["tentative" if math.isnan(v) else "active" for v in nis],
        measurement_type=[row["measurement_type"] for row in rows],
        observed=[[0, 1, 2, 3] if f else [0, 1] for f in full],
        z=partial("meas", 0),
        x=partial("est", 1),
        truth=partial("true", 1),
        nis=nis,
        nis_dof=column("nis_df"),
        nees=column("nees"),
        std=list(zip(*map(column, stds), strict=True)),
    )


def quantity(name, verdict, times, cuts, scales, **moments):
    """A verdict with segments between these updates."""
    edges = [0, *cuts, len(times)]
    segments = []
    for start, stop, scale in zip(edges, edges[1:], scales, strict=False):
        label = "optimistic" if scale > 1.25 else "pessimistic" if scale < 0.8 else "consistent"
        ends = (float(times[start]), float(times[stop - 1]))
        interval = (0.7 * scale, 1.5 * scale)
        p = 0.4 if label == "consistent" else 1e-6
        segments.append(
            Segment(start, stop, *ends, 3.0 * (stop - start), scale, interval, p, label)
        )
    none = dict.fromkeys(
        (
            "onset_index",
            "onset_time",
            "settling_index",
            "settling_time",
            "alarm_index",
            "alarm_time",
            "alarm_onset_time",
        )
    )
    scale = scales[-1] if segments else math.nan
    fields = {"scale": scale, "interval": (0.7 * scale, 1.5 * scale), "autocorrelation_time": 1.0}
    return QuantityVerdict(
        quantity=name,
        verdict=verdict,
        updates=len(times),
        segments=tuple(segments),
        **{**none, **fields, **moments},
    )


def track_diagnosis(like, log, name, verdict):
    """A record of every kind about one track, its segments fitting its verdict."""
    rows = log[name]
    good = np.isfinite(rows.nis)
    times, late = rows.time[good], int(0.7 * good.sum())
    shapes = {
        "late_divergence": ((late,), (0.9, 8.1)),
        "startup_then_pessimistic": ((len(times) // 4,), (4.0, 0.35)),
        "pessimistic": ((), (0.2,)),
        "optimistic": ((), (3.1,)),
    }
    cuts, scales = shapes.get(verdict, ((), (1.0,)))
    moments = {}
    if verdict == "late_divergence":
        moments = {"onset_time": float(times[late]), "alarm_time": float(times[late + 1])}
    if verdict.startswith("startup"):
        moments = {"settling_time": float(times[len(times) // 4])}
    std = rows.std
    states = tuple(
        StateDiagnosis(
            s.name,
            s.unit,
            (FULL,) if i in (2, 3) else (FULL, SHORT) if i < 2 else (),
            (12, 12, 5, 5, 0)[i],
            900.0,
            float(std[0, i]),
            float(std[:, i].max() / std[0, i]),
            float(rows.time[std[:, i].argmax()]),
            float(times[3]) if i == 3 else None,
            0.3,
            i != 4,
            (0.05, 0.05, 0.1, 0.2, 0.6)[i],
            float(1 + i),
            1.0,
            1.0,
        )
        for i, s in enumerate(log.states)
    )
    fails = verdict in ("late_divergence", "optimistic")
    return replace(
        like,
        track=name,
        verdict=verdict,
        nis=quantity("nis", verdict, times, cuts, scales, **moments),
        nees=quantity("nees", verdict, rows.time, (), scales[-1:], **moments),
        cause="process noise too small" if fails else None,
        weakest_state="turn_rate" if fails else None,
        states=states,
        biases=(Bias("innovation", FULL, "cog", 1.5, "deg", 4.1, 0.001),) if fails else (),
        whiteness=InnovationCorrelation(0.05, 0.6, 0.55, 80),
        outliers=(Outlier(5, float(times[5]), 31.0, 4.0, 1e-6),) if fails else (),
        updates=len(rows),
        updates_without_nis=int((~good).sum()),
        repeated=0,
        log_start=log.start_time,
        start_time=float(rows.time[0]),
        stop_time=float(rows.time[-1]),
        longest_gap=300.0,
        longest_gap_time=float(rows.time[1]),
        observed={FULL: ("lat", "lon", "sog", "cog"), SHORT: ("lat", "lon")},
        notes=("A note about <this> & that.",) if fails else (),
    )


def made_up(log):
    """A diagnosis that gives the tracks of a log every verdict in turn."""
    cycle = ("late_divergence", "pessimistic", "consistent", "startup_then_pessimistic", *VERDICTS)
    named = zip(log.tracks, [cycle[i % len(cycle)] for i in range(len(log.tracks))], strict=True)
    (like,) = diagnose(EstimatorLog.from_columns(nis=[1.0] * 4, nis_dof=2)).values()
    return Diagnosis(tuple(track_diagnosis(like, log, name, verdict) for name, verdict in named))


@pytest.fixture(scope="session")
def small():
    """A log of four tracks and its diagnosis."""
    log = synthetic_log(4)
    return log, made_up(log)


@pytest.fixture(scope="session")
def fleet():
    """A log of a hundred tracks of 200 updates and its diagnosis."""
    log = synthetic_log(100, 200)
    return log, made_up(log)


@pytest.fixture(scope="session")
def fleet_page(fleet):
    """Its page."""
    return report.render_page(fleet[1], fleet[0])


@pytest.fixture
def published(data):
    """The published run and its diagnosis."""
    log = published_log(data)
    return log, diagnose(log)


def pytest_collection_modifyitems(config, items):
    """Without Chromium the tests in the browser are deselected; in CI that is a failure."""
    marked = [item for item in items if item.get_closest_marker("browser")]
    if not marked or (shutil.which("chromium") and shutil.which("chromedriver")):
        return
    if os.environ.get("CI"):
        raise pytest.UsageError("chromium and chromedriver are missing (Debian: chromium-driver)")
    config.hook.pytest_deselected(items=marked)
    items[:] = [item for item in items if item not in marked]
    config.get_terminal_writer().line("no chromium: tests in the browser deselected")
