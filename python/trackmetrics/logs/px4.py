"""Flight logs of the PX4 autopilot (ULog): the innovations of its Kalman filter, axis by axis.

Three generations of topics are read: ``ekf2_innovations`` (before 1.9), ``estimator_innovations``
with ``estimator_innovation_variances`` (1.11 and later), and ``estimator_aid_src_*`` (1.14 and
later). PX4 fuses every axis as a scalar, so every axis is a track of its own with one degree of
freedom; its measurement type says sensor, axis and unit.

A field keeps its last value where nothing was fused. A value that repeats to the bit, and one whose
variance is not positive, is therefore no update. What the filter rejected (a test ratio above 1, or
the flag of the topic) has the status ``"rejected"``. Times are seconds since the start of the log;
of a topic whose time stamps are all the same, the numbers of its rows.
"""

import io
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics._tables.opening import Content
from trackmetrics.logs.header import LogHeader

Floats = NDArray[np.float64]
Table = dict[str, list[Any]]

NEAR = 50_000
"""Microseconds within which messages of two topics belong together: the logger thins each topic by
itself, so that an innovation and its variance may come from neighbouring cycles of the filter."""
NED = ("north", "east", "down")
XYZ = ("x", "y", "z")
SENSORS = {
    "gps": "GPS",
    "gnss": "GNSS",
    "ev": "external vision",
    "fake": "assumed",
    "aux": "auxiliary",
    "aux_global": "auxiliary",
    "rng": "range finder",
    "baro": "barometer",
    "optical_flow": "optical flow",
}
QUANTITIES = {
    "hvel": ("velocity", NED[:2], "m/s"),
    "vvel": ("velocity", NED[2:], "m/s"),
    "vel": ("velocity", NED, "m/s"),
    "hpos": ("position", NED[:2], "m"),
    "vpos": ("position", NED[2:], "m"),
    "pos": ("position", NED[:2], "m"),
    "position": ("position", NED[:2], "m"),
    "hgt": ("height", (), "m"),
    "yaw": ("yaw", (), "rad"),
}
WHOLE = {
    "mag_field": ("magnetometer field", XYZ, "gauss"),
    "mag": ("magnetometer field", XYZ, "gauss"),
    "heading": ("heading", (), "rad"),
    "mag_heading": ("magnetometer heading", (), "rad"),
    "airspeed": ("airspeed", (), "m/s"),
    "beta": ("sideslip angle", (), "rad"),
    "sideslip": ("sideslip angle", (), "rad"),
    "hagl": ("height above ground", (), "m"),
    "hagl_rate": ("rate of the height above ground", (), "m/s"),
    "flow": ("optical flow", XYZ[:2], "rad/s"),
    "optical_flow": ("optical flow", XYZ[:2], "rad/s"),
    "terr_flow": ("optical flow of the terrain", XYZ[:2], "rad/s"),
    "terrain_optical_flow": ("optical flow of the terrain", XYZ[:2], "rad/s"),
    "drag": ("drag acceleration", XYZ[:2], "m/s^2"),
    "gravity": ("gravity direction", XYZ, "m/s^2"),
}
VEL_POS = tuple(f"velocity {axis} (m/s)" for axis in NED) + tuple(
    f"position {axis} (m)" for axis in NED
)


@dataclass(frozen=True)
class Axis:
    """The innovations of one axis of one sensor, in the order of time."""

    sensor: str
    """Sensor, quantity, axis and unit."""
    instance: int
    """Number of the filter, where several run."""
    time: Floats
    """Seconds since the start of the log."""
    innovation: Floats
    variance: Floats
    rejected: NDArray[np.bool_]


def read(content: Content) -> tuple[dict[str, Any], LogHeader]:
    """The columns of a log, one row for each update of each axis."""
    import pyulog

    ulog = pyulog.ULog(io.BytesIO(content.data))
    axes = [kept for axis in _axes(ulog) if len((kept := _updates(axis)).time)]
    if not axes:
        raise ValueError(
            f"{content.name}: no innovations; expected a topic ekf2_innovations, "
            "estimator_innovations or estimator_aid_src_*"
        )
    several = len({axis.instance for axis in axes}) > 1
    table: Table = {
        name: [] for name in ("track", "time", "status", "measurement_type", "innovation", "S")
    }
    for axis in axes:
        count = len(axis.time)
        name = f"{axis.sensor}, filter {axis.instance}" if several else axis.sensor
        table["track"] += [name] * count
        table["measurement_type"] += [axis.sensor] * count
        table["time"] += axis.time.tolist()
        table["status"] += ["rejected" if r else "active" for r in axis.rejected]
        table["innovation"] += [[v] for v in axis.innovation.tolist()]
        table["S"] += [[[v]] for v in axis.variance.tolist()]
    return table, LogHeader()


def _updates(axis: Axis) -> Axis:
    """The rows that are updates."""
    new = np.ones(len(axis.time), bool)
    new[1:] = (np.diff(axis.innovation) != 0) | (np.diff(axis.variance) != 0)
    new &= np.isfinite(axis.innovation) & np.isfinite(axis.variance) & (axis.variance > 0)
    new[1:] &= np.diff(axis.time) > 0
    return Axis(
        axis.sensor, axis.instance, axis.time[new], axis.innovation[new], axis.variance[new],
        axis.rejected[new],
    )  # fmt: skip


def _axes(ulog: Any) -> Iterator[Axis]:
    names = {topic.name for topic in ulog.data_list}
    aid = any(name.startswith("estimator_aid_src_") for name in names)
    for topic in ulog.data_list:
        if topic.name.startswith("estimator_aid_src_"):
            yield from _of_aid_source(topic, ulog.start_timestamp)
        elif topic.name == "estimator_innovations" and not aid:
            yield from _of_innovations(ulog, topic)
        elif topic.name == "ekf2_innovations":
            yield from _of_ekf2(topic, ulog.start_timestamp)


def _seconds(topic: Any, start: int, rows: Any = slice(None)) -> Floats:
    stamps = topic.data["timestamp"].astype(np.int64)
    if len(stamps) > 1 and (stamps == stamps[0]).all():
        return np.asarray(np.arange(float(len(stamps)))[rows])
    return np.asarray((stamps[rows] - start) * 1e-6, np.float64)


def _floats(values: Any) -> Floats:
    return np.asarray(values, np.float64)


def _of_ekf2(topic: Any, start: int) -> Iterator[Axis]:
    """``vel_pos_innov[i]`` with ``vel_pos_innov_var[i]``, and so on."""
    time = _seconds(topic, start)
    for field in topic.data:
        match = re.fullmatch(r"(.+)_innov(\[\d\])?", field)
        if match is None:
            continue
        base, index = match.group(1), match.group(2) or ""
        variance = f"{base}_innov_var{index}"
        if variance in topic.data:
            sensor = VEL_POS[int(index[1])] if base == "vel_pos" else full_name(base + index)
            yield Axis(
                sensor, topic.multi_id, time, _floats(topic.data[field]),
                _floats(topic.data[variance]), np.zeros(len(time), bool),
            )  # fmt: skip


def _of_innovations(ulog: Any, topic: Any) -> Iterator[Axis]:
    """Fields that three topics share, each message matched with the nearest of the others."""
    others = {
        other.name: other
        for other in ulog.data_list
        if other.multi_id == topic.multi_id and other.name.startswith("estimator_innovation_")
    }
    if "estimator_innovation_variances" not in others:
        return
    variances = others["estimator_innovation_variances"]
    ratios = others.get("estimator_innovation_test_ratios")
    rows, place = _matched(topic, variances)
    time = _seconds(topic, ulog.start_timestamp, rows)
    tested = None if ratios is None else _matched_to(topic, rows, ratios)
    for field in topic.data:
        if field.startswith("timestamp") or field not in variances.data:
            continue
        rejected = np.zeros(len(rows), bool)
        if ratios is not None and tested is not None and field in ratios.data:
            rejected = (tested >= 0) & (np.abs(_floats(ratios.data[field])[tested]) > 1)
        yield Axis(
            full_name(field), topic.multi_id, time, _floats(topic.data[field])[rows],
            _floats(variances.data[field])[place], rejected,
        )  # fmt: skip


def _matched(topic: Any, other: Any) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows of a topic that have one of another at nearly the same time, and those."""
    place = _matched_to(topic, np.arange(len(topic.data["timestamp"])), other)
    rows = np.flatnonzero(place >= 0)
    return rows, place[rows]


def _matched_to(topic: Any, rows: NDArray[np.int64], other: Any) -> NDArray[np.int64]:
    """For some rows of a topic the nearest row of another, -1 where none is near."""
    key = "timestamp_sample" if "timestamp_sample" in topic.data else "timestamp"
    if key not in other.data:
        key = "timestamp"
    wanted = topic.data[key].astype(np.int64)[rows]
    times = other.data[key].astype(np.int64)
    if not len(times):
        return np.full(len(rows), -1, np.int64)
    order = np.argsort(times, kind="stable")
    after = np.clip(np.searchsorted(times[order], wanted), 1, max(len(times) - 1, 1))
    pair = order[np.minimum(np.stack([after - 1, after]), len(times) - 1)]
    place = np.where(np.diff(np.abs(times[pair] - wanted), axis=0)[0] < 0, pair[1], pair[0])
    return np.where(np.abs(times[place] - wanted) <= NEAR, place, -1)


def _of_aid_source(topic: Any, start: int) -> Iterator[Axis]:
    """A topic of one source, with its flags."""
    source = topic.name.removeprefix("estimator_aid_src_")
    data, time = topic.data, _seconds(topic, start)
    rejected = _floats(data.get("innovation_rejected", np.zeros(len(time)))) > 0
    for field in data:
        match = re.fullmatch(r"innovation(\[\d\])?", field)
        variance = f"innovation_variance{match.group(1) or ''}" if match else ""
        if match and variance in data:
            yield Axis(
                full_name(source + (match.group(1) or "")), topic.multi_id, time,
                _floats(data[field]), _floats(data[variance]), rejected,
            )  # fmt: skip


def full_name(field: str) -> str:
    """Sensor, quantity, axis and unit of a field.

    >>> full_name("gps_hvel[1]")
    'GPS velocity east (m/s)'
    >>> full_name("baro_hgt")
    'barometer height (m)'
    """
    match = re.fullmatch(r"(.+?)(?:\[(\d)\])?", field)
    assert match is not None
    base, index = match.group(1), int(match.group(2) or 0)
    if base in WHOLE:
        quantity, axes, unit = WHOLE[base]
        sensor = ""
    else:
        start, _, end = base.rpartition("_")
        if start not in SENSORS or end not in QUANTITIES:
            return field
        sensor, (quantity, axes, unit) = SENSORS[start], QUANTITIES[end]
    axis = axes[index] if index < len(axes) else ""
    return " ".join(part for part in (sensor, quantity, axis, f"({unit})") if part)
