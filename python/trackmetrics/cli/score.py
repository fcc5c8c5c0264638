"""``trackmetrics score TRUTH TRACKS``: a tracker's boxes against the truth."""

import argparse
import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics.assignment import linear_sum_assignment
from trackmetrics.point_sets import ospa_over_time
from trackmetrics.tracking import (
    identity_switches,
    mot_metrics,
    track_fragmentation,
    track_purity,
)
from trackmetrics.tracks import Boxes, read_mot_challenge

Places = NDArray[np.intp]

_EXPLANATION = """
Reads two MOTChallenge files (frame,id,left,top,width,height[,confidence,...]) and compares the
centres of the boxes, in pixels, in every frame from the first to the last of either file. A truth
line whose confidence is below 1 does not count.

Misses, false alarms and MOTP are those of mot_metrics: in each frame truth and tracks are matched
at the least total distance, then pairs farther apart than the threshold are dropped. Its switches,
fragmentations and MOTA are not printed: it takes the place in a frame's list for an identity, and
in a file that place means nothing.

Purity, fragmentation and switches count over the ids of pairs that are matched with the gate first:
in each frame as many pairs within the threshold as there can be, at the least total distance.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Says what the command takes."""
    parser.description = _EXPLANATION
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("truth", metavar="TRUTH", help="MOTChallenge file of the truth")
    parser.add_argument("tracks", metavar="TRACKS", help="MOTChallenge file of the tracker")
    parser.add_argument(
        "--threshold", type=float, default=50.0, help="largest distance of a pair (default: 50)"
    )
    parser.add_argument(
        "--cutoff", type=float, default=100.0, help="cutoff c of OSPA (default: 100)"
    )
    parser.add_argument("--order", type=float, default=2.0, help="order p of OSPA (default: 2)")
    parser.add_argument("--format", choices=["table", "json"], default="table")


def run(arguments: argparse.Namespace) -> int:
    """Prints the scores."""
    truth = read_mot_challenge(arguments.truth, progress=True).counted()
    tracks = read_mot_challenge(arguments.tracks, progress=True)
    result = score(truth, tracks, arguments.threshold, arguments.cutoff, arguments.order)
    if arguments.format == "json":
        print(json.dumps(result.to_dict(), indent=2))
    else:
        print(f"{arguments.tracks} against {arguments.truth}\n{_table(result)}")
    return 0


@dataclass(frozen=True)
class Score:
    """The scores of one file against another, over box centres."""

    threshold: float
    """Largest distance of a pair, in pixels."""
    cutoff: float
    """Cutoff of OSPA, in pixels."""
    order: float
    """Order of OSPA."""
    frames: int
    """Frames compared."""
    true_boxes: int
    """Boxes of the truth."""
    true_ids: int
    """Targets."""
    track_boxes: int
    """Boxes of the tracker."""
    track_ids: int
    """Tracks."""
    ospa_mean: float
    """Mean OSPA over the frames, in pixels; 0 is best."""
    ospa_worst: float
    """Largest OSPA of a frame, in pixels."""
    ospa_worst_frame: int
    """The first frame that has it."""
    misses: int
    """Boxes of the truth without a pair."""
    false_alarms: int
    """Boxes of the tracker without a pair."""
    motp: float
    """Mean distance of the pairs, in pixels; 0 is best."""
    track_purity: float
    """Share of the pairs that belong to the main target of their track; 1 is best."""
    track_fragmentation: int
    """Times that a target passes from one track to another."""
    identity_switches: int
    """Times that a track passes from one target to another."""

    def to_dict(self) -> dict[str, Any]:
        """All fields by name."""
        return asdict(self)


def score(truth: Boxes, tracks: Boxes, threshold: float, cutoff: float, order: float) -> Score:
    """Scores a tracker's boxes against the truth, over the centres of the boxes."""
    numbers = np.concatenate([truth.frames, tracks.frames])
    if not len(numbers):
        raise ValueError("neither file has a box that counts")
    first, last = int(numbers.min()), int(numbers.max())
    places = truth.by_frame(first, last), tracks.by_frame(first, last)
    x = [truth.centres[i] for i in places[0]]
    y = [tracks.centres[j] for j in places[1]]
    distances = ospa_over_time(x, y, c=cutoff, p=order)
    worst = int(np.argmax(distances))
    frames = mot_metrics(x, y, threshold)
    labels = paired_labels(truth, tracks, zip(*places, strict=True), threshold)
    return Score(
        threshold=threshold,
        cutoff=cutoff,
        order=order,
        frames=last - first + 1,
        true_boxes=len(truth),
        true_ids=truth.targets,
        track_boxes=len(tracks),
        track_ids=tracks.targets,
        ospa_mean=float(distances.mean()),
        ospa_worst=float(distances[worst]),
        ospa_worst_frame=first + worst,
        misses=frames.num_misses,
        false_alarms=frames.num_false_positives,
        motp=frames.motp,
        track_purity=track_purity(*labels[:2]),
        track_fragmentation=track_fragmentation(*labels),
        identity_switches=identity_switches(*labels),
    )


def paired_labels(
    truth: Boxes, tracks: Boxes, places: Iterable[tuple[Places, Places]], threshold: float
) -> NDArray[np.int64]:
    """Target, track and frame of every pair: in each frame as many pairs within the threshold as
    there can be, at the least total distance."""
    pairs = [np.empty((3, 0), dtype=np.int64)]
    for i, j in places:
        near = _near_pairs(truth.centres[i], tracks.centres[j], threshold)
        i, j = i[near[0]], j[near[1]]
        pairs.append(np.stack([truth.ids[i], tracks.ids[j], truth.frames[i]]))
    return np.concatenate(pairs, axis=1)


def _near_pairs(
    x: NDArray[np.float64], y: NDArray[np.float64], threshold: float
) -> tuple[Places, Places]:
    distances = np.linalg.norm(x[:, None] - y[None], axis=-1)
    near = distances <= threshold
    # One pair too far costs more than any number of near ones.
    beyond = (min(near.shape) + 1) * distances[near].max(initial=1.0)
    rows, columns = linear_sum_assignment(np.where(near, distances, beyond))
    kept = near[rows, columns]
    return rows[kept], columns[kept]


def _table(s: Score) -> str:
    ospa = f"OSPA, cutoff {s.cutoff:g} px, order {s.order:g}"
    rows = [
        (ospa, f"{s.ospa_mean:.2f} px", "mean over frames"),
        ("", f"{s.ospa_worst:.2f} px", f"worst, in frame {s.ospa_worst_frame}"),
        ("misses", f"{s.misses}", f"of {s.true_boxes} boxes of {s.true_ids} targets"),
        ("false alarms", f"{s.false_alarms}", f"of {s.track_boxes} boxes of {s.track_ids} tracks"),
        ("MOTP", f"{s.motp:.2f} px", f"mean distance of pairs within {s.threshold:g} px"),
        ("track purity", f"{s.track_purity:.4f}", "share of pairs with their track's main target"),
        ("track fragmentation", f"{s.track_fragmentation}", "a target passes to another track"),
        ("identity switches", f"{s.identity_switches}", "a track passes to another target"),
    ]
    width = max(len(name) for name, _, _ in rows)
    lines = [f"  {name:{width}}  {value:>10}   {note}" for name, value, note in rows]
    return "\n".join([f"{s.frames} frames, centres of boxes", *lines])
