"""py-motmetrics' metrics: functions of the events and of the metrics that they depend on.

An argument's name is the metric that is passed.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from trackmetrics._tables.data_frames import pandas
from trackmetrics.compat.motmetrics import _events
from trackmetrics.compat.motmetrics._frame_map import DataFrameMap
from trackmetrics.compat.motmetrics._identity import IdentityAssignment, IdentityCounts
from trackmetrics.compat.motmetrics.math_util import quiet_divide


def num_frames(df: DataFrameMap) -> int:
    """Number of frames."""
    frames = df.columns.frames
    return int(frames.max()) + 1 if len(frames) else 0


def obj_frequencies(df: DataFrameMap) -> Any:
    """Number of frames of each object."""
    return pandas().Series(df.noraw_columns.objects, name="OId").value_counts()


def pred_frequencies(df: DataFrameMap) -> Any:
    """Number of frames of each hypothesis."""
    return pandas().Series(df.noraw_columns.hypotheses, name="HId").value_counts()


def num_unique_objects(df: DataFrameMap, obj_frequencies: Any) -> int:
    """Number of objects."""
    return len(obj_frequencies)


def num_matches(df: DataFrameMap) -> Any:
    """Number of matches that are no switch."""
    return df.noraw_columns.count(_events.MATCH)


def num_switches(df: DataFrameMap) -> Any:
    """Number of switches of an object to another hypothesis."""
    return df.noraw_columns.count(_events.SWITCH)


def num_transfer(df: DataFrameMap) -> Any:
    """Number of transfers of a hypothesis to another object."""
    return df.extra_columns.count(_events.TRANSFER)


def num_ascend(df: DataFrameMap) -> Any:
    """Number of switches to a hypothesis that is new."""
    return df.extra_columns.count(_events.ASCEND)


def num_migrate(df: DataFrameMap) -> Any:
    """Number of transfers to an object that is new."""
    return df.extra_columns.count(_events.MIGRATE)


def num_false_positives(df: DataFrameMap) -> Any:
    """Number of false alarms."""
    return df.noraw_columns.count(_events.FP)


def num_misses(df: DataFrameMap) -> Any:
    """Number of misses."""
    return df.noraw_columns.count(_events.MISS)


def num_detections(df: DataFrameMap, num_matches: Any, num_switches: Any) -> Any:
    """Number of detected objects: matches and switches."""
    return num_matches + num_switches


def num_objects(df: DataFrameMap, obj_frequencies: Any) -> Any:
    """Number of objects over all frames."""
    return obj_frequencies.sum()


def num_predictions(df: DataFrameMap, pred_frequencies: Any) -> Any:
    """Number of hypotheses over all frames."""
    return pred_frequencies.sum()


def track_ratios(df: DataFrameMap, obj_frequencies: Any) -> Any:
    """Detected share of each object's frames."""
    columns = df.noraw_columns
    tracked = pandas().Series(columns.objects[columns.types != _events.MISS], name="OId")
    return tracked.value_counts().div(obj_frequencies).fillna(0.0)


def mostly_tracked(df: DataFrameMap, track_ratios: Any) -> Any:
    """Number of objects that are detected in at least 80 percent of their frames."""
    return track_ratios[track_ratios >= 0.8].count()


def partially_tracked(df: DataFrameMap, track_ratios: Any) -> Any:
    """Number of objects that are detected in at least 20 and less than 80 percent."""
    return track_ratios[(track_ratios >= 0.2) & (track_ratios < 0.8)].count()


def mostly_lost(df: DataFrameMap, track_ratios: Any) -> Any:
    """Number of objects that are detected in less than 20 percent of their frames."""
    return track_ratios[track_ratios < 0.2].count()


def num_fragmentations(df: DataFrameMap, obj_frequencies: Any) -> Any:
    """Number of interruptions between an object's first and last detection."""
    columns = df.noraw_columns
    codes = pandas().factorize(columns.objects)[0]
    rows = np.flatnonzero(codes >= 0)
    rows = rows[np.argsort(codes[rows], kind="stable")]
    codes, detected = codes[rows], columns.types[rows] != _events.MISS
    same = np.diff(codes, prepend=-1) == 0
    begins = detected & ~(same & np.append(False, detected[:-1]))
    begun = len(np.unique(codes[detected]))
    return int(begins.sum()) - begun


def motp(df: DataFrameMap, num_detections: Any) -> Any:
    """Mean distance of the detected objects."""
    return quiet_divide(np.nansum(df.noraw_columns.distances), num_detections)


def mota(
    df: DataFrameMap, num_misses: Any, num_switches: Any, num_false_positives: Any, num_objects: Any
) -> Any:
    """One minus misses, switches and false alarms over objects."""
    return 1.0 - quiet_divide(num_misses + num_switches + num_false_positives, num_objects)


def precision(df: DataFrameMap, num_detections: Any, num_false_positives: Any) -> Any:
    """Detected objects over detected objects and false alarms."""
    return quiet_divide(num_detections, num_false_positives + num_detections)


def recall(df: DataFrameMap, num_detections: Any, num_objects: Any) -> Any:
    """Detected objects over objects."""
    return quiet_divide(num_detections, num_objects)


def id_global_assignment(df: DataFrameMap, ana: Any = None) -> IdentityAssignment:
    """Assignment of whole hypotheses to objects of least ID false alarms and misses."""
    return IdentityAssignment(IdentityCounts.of(df))


def idfp(df: DataFrameMap, id_global_assignment: Any) -> Any:
    """False alarms after the global assignment."""
    return _over_pairs(id_global_assignment, "idfp", "fpmatrix")


def idfn(df: DataFrameMap, id_global_assignment: Any) -> Any:
    """Misses after the global assignment."""
    return _over_pairs(id_global_assignment, "idfn", "fnmatrix")


def _over_pairs(assignment: Any, ready: str, matrix: str) -> Any:
    if isinstance(assignment, IdentityAssignment):
        return getattr(assignment, ready)
    return assignment[matrix][assignment["rids"], assignment["cids"]].sum()


def idtp(df: DataFrameMap, id_global_assignment: Any, num_objects: Any, idfn: Any) -> Any:
    """Detections after the global assignment."""
    return num_objects - idfn


def idp(df: DataFrameMap, idtp: Any, idfp: Any) -> Any:
    """Precision after the global assignment."""
    return quiet_divide(idtp, idtp + idfp)


def idr(df: DataFrameMap, idtp: Any, idfn: Any) -> Any:
    """Recall after the global assignment."""
    return quiet_divide(idtp, idtp + idfn)


def idf1(df: DataFrameMap, idtp: Any, num_objects: Any, num_predictions: Any) -> Any:
    """F1 score after the global assignment."""
    return quiet_divide(2 * idtp, num_objects + num_predictions)


def motp_m(partials: Any, num_detections: Any) -> Any:
    """MOTP over sequences: the mean over all detections."""
    total = sum((v["motp"] * v["num_detections"] for v in partials), 0)
    return quiet_divide(total, num_detections)


METRICS: dict[Callable[..., Any], str | None] = {
    **dict.fromkeys((num_frames, obj_frequencies, pred_frequencies, num_matches), "{:d}"),
    **dict.fromkeys((num_switches, num_transfer, num_ascend, num_migrate), "{:d}"),
    **dict.fromkeys((num_false_positives, num_misses, num_detections), "{:d}"),
    **dict.fromkeys((num_objects, num_predictions, num_unique_objects), "{:d}"),
    track_ratios: None,
    **dict.fromkeys((mostly_tracked, partially_tracked, mostly_lost), "{:d}"),
    num_fragmentations: None,
    motp: "{:.3f}",
    **dict.fromkeys((mota, precision, recall), "{:.1%}"),
    **dict.fromkeys((id_global_assignment, idfp, idfn, idtp)),
    **dict.fromkeys((idp, idr, idf1), "{:.1%}"),
}
"""Every metric, in py-motmetrics' order, with its format."""

SUMMED = (
    *("num_frames", "num_unique_objects", "num_matches", "num_switches", "num_transfer"),
    *("num_ascend", "num_migrate", "num_false_positives", "num_misses", "num_detections"),
    *("num_objects", "num_predictions", "mostly_tracked", "partially_tracked", "mostly_lost"),
    *("num_fragmentations", "idfp", "idfn", "idtp"),
)
"""Metrics that are summed over sequences."""


def _summed(name: str) -> Callable[[Any], Any]:
    def total(partials: Any) -> Any:
        return sum((v[name] for v in partials), 0)

    return total


RATIOS = (mota, precision, recall, idp, idr, idf1)
"""Metrics that are the same function of the sums."""

MERGES: dict[str, Callable[..., Any]] = {
    **{name: _summed(name) for name in SUMMED},
    **{function.__name__: function for function in RATIOS},
    "motp": motp_m,
}
"""How a metric is computed over sequences, by name."""
