"""All families of scores from one pass over the pairs, with tables and an event log."""

from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import nullcontext
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _progress
from trackmetrics._tables.data_frames import pandas
from trackmetrics.results import Result, to_json
from trackmetrics.tracking.clear_mot import CLEARMOT, clear_of_matches, combine_clear
from trackmetrics.tracking.event_log import Columns, event_log, object_rows, track_rows
from trackmetrics.tracking.frames import TrackFrames
from trackmetrics.tracking.hota import HOTA, combine_hota, hota_of
from trackmetrics.tracking.identity_scores import (
    IdentityScores,
    identity_of_counts,
    identity_scores_of,
)
from trackmetrics.tracking.matches import match
from trackmetrics.tracking.protocols import PROTOCOLS, find_protocol
from trackmetrics.tracking.similarity import PairMeasure, pair_measure
from trackmetrics.tracks import TrackTable

METRICS = ("clear", "identity", "hota")


@dataclass(frozen=True, eq=False)
class Evaluation(Result):
    """The scores of a sequence, and what they were counted from."""

    protocol: str
    """Name of the protocol."""
    threshold: float
    """Threshold, in the unit of the similarity."""
    clear: CLEARMOT | None
    """CLEAR MOT; None where it was not asked for, as the next two."""
    identity: IdentityScores | None
    """Identity scores."""
    hota: HOTA | None
    """HOTA."""
    objects: Columns = field(default_factory=dict)
    """A row for each truth object: first and last time, rows, matched, share, tracks, switches,
    RMSE of the distances of its pairs."""
    tracks: Columns = field(default_factory=dict)
    """A row for each track: first and last time, rows, matched, purity (share of its pairs that
    are with its most frequent object), objects, share of false alarms."""
    events: Columns = field(default_factory=dict)
    """time, truth, track, event, distance; in the order of time. An event is ``"match"``,
    ``"miss"``, ``"false alarm"``, ``"switch"``, ``"transfer"`` or ``"fragmentation"``; the last
    three stand beside the match that they belong to."""

    @property
    def scores(self) -> dict[str, Any]:
        """All scores by name: ``mota``, ``idf1``, ``hota`` ..."""
        found: dict[str, Any] = {}
        for part in (self.clear, self.identity, self.hota):
            found |= {} if part is None else vars(part)
        return found

    def to_dict(self) -> dict[str, Any]:
        """Scores by name and the three tables, ready for JSON."""
        tables = {name: to_json(_plain(getattr(self, name))) for name in _TABLES}
        scores = {name: to_json(value) for name, value in self.scores.items()}
        return {"protocol": self.protocol, "threshold": self.threshold, **scores, **tables}

    def to_pandas(self, table: str = "events") -> Any:
        """``"events"``, ``"objects"`` or ``"tracks"`` as a pandas data frame."""
        return pandas().DataFrame(self._table(table))

    def to_polars(self, table: str = "events") -> Any:
        """``"events"``, ``"objects"`` or ``"tracks"`` as a Polars data frame; ids of mixed kinds
        become objects."""
        from trackmetrics._tables.polars_columns import need_polars

        polars = need_polars("to_polars")
        return polars.DataFrame({n: _series(c) for n, c in self._table(table).items()})

    def _table(self, table: str) -> Columns:
        if table not in _TABLES:
            raise ValueError(f"table must be one of {', '.join(_TABLES)}, got {table!r}")
        found: Columns = getattr(self, table)
        return found


_TABLES = ("events", "objects", "tracks")


def _series(column: NDArray[Any]) -> Any:
    return column.tolist() if column.dtype == object else column


def _plain(columns: Columns) -> dict[str, list[Any]]:
    return {n: (c.astype(str) if c.dtype.kind in "mM" else c).tolist() for n, c in columns.items()}


def evaluate(
    truth: TrackTable | TrackFrames,
    tracks: TrackTable | None = None,
    *,
    metrics: Sequence[str] = METRICS,
    similarity: str | Sequence[Any] = "iou",
    threshold: float = 0.5,
    protocol: str = "trackeval",
    times: Any = None,
) -> Evaluation:
    """Score tracks against the truth: CLEAR MOT, identity scores and HOTA, with an event log.

    Parameters
    ----------
    truth, tracks : TrackTable
        One sequence; or ``truth`` is TrackFrames, which hold both.
    metrics : sequence of {"clear", "identity", "hota"}
        Families of scores. Tables and events are of CLEAR MOT's pairs, whichever are asked for.
    similarity, threshold, protocol
        As in :func:`clear_mot`.
    times : array_like, optional
        All times of the sequence, for frames without a row on either side.

    Returns
    -------
    Evaluation

    Raises
    ------
    ValueError, TypeError
        As in :func:`clear_mot`; where ``metrics`` names another family.

    Examples
    --------
    >>> truth = TrackTable.from_columns(time=[1, 2, 3], id=["ferry"] * 3, position=[[0], [1], [2]])
    >>> tracks = TrackTable.from_columns(time=[1, 3], id=[7, 8], position=[[0], [2]])
    >>> found = evaluate(truth, tracks, similarity="euclidean", threshold=1)
    >>> found.clear.fn, found.clear.idsw, found.identity.idtp
    (1, 1, 1)
    >>> found.events["event"].tolist()
    ['match', 'miss', 'match', 'switch']
    """
    if isinstance(metrics, str):
        raise TypeError(f"metrics must be a list of {', '.join(METRICS)}, got {metrics!r}")
    for name in metrics:
        if name not in METRICS:
            raise ValueError(f"metrics must be a list of {', '.join(METRICS)}, got {name!r}")
    rules = find_protocol(protocol)
    if isinstance(truth, TrackFrames):
        frames = truth
    else:
        frames = TrackFrames.from_tables(truth, tracks, times=times)  # type: ignore[arg-type]
    measure = pair_measure(frames, similarity, threshold)
    matches = match(measure, rules)
    values = matches.values[matches.truth_rows]
    distances = values if rules.motp_is_distance else _distances(measure, values)
    return Evaluation(
        protocol,
        float(threshold),
        clear_of_matches(frames, matches, rules) if "clear" in metrics else None,
        identity_scores_of(measure, rules) if "identity" in metrics else None,
        hota_of(measure) if "hota" in metrics else None,
        objects=object_rows(frames, matches, distances),
        tracks=track_rows(frames, matches),
        events=event_log(frames, matches, distances),
    )


def _distances(measure: PairMeasure, similarities: NDArray[np.float64]) -> NDArray[np.float64]:
    scale = 2 * measure.threshold if measure.kind == "euclidean" else 1.0
    return (1 - similarities) * scale


def combine(results: Iterable[Evaluation]) -> Evaluation:
    """Scores of several sequences together, from the sums of their counts.

    Ratios of CLEAR MOT and the identity scores are those of the sums; HOTA's association and
    localisation are weighted by the number of pairs at each alpha, as in TrackEval. The tables and
    events stay with the sequences.
    """
    found = list(results)
    if not found:
        raise ValueError("results is empty")
    for i, other in enumerate(found):
        if not isinstance(other, Evaluation):
            raise TypeError(f"results[{i}] must be an Evaluation, got {type(other).__name__}")
        if (other.protocol, other.threshold) != (found[0].protocol, found[0].threshold):
            raise ValueError(
                f"results[{i}] has protocol {other.protocol!r} and threshold {other.threshold}, "
                f"results[0] {found[0].protocol!r} and {found[0].threshold}"
            )
    rules = PROTOCOLS[found[0].protocol]
    clear, identity, hotas = (
        [part for r in found if (part := getattr(r, name)) is not None] for name in METRICS
    )
    for name, parts in zip(METRICS, (clear, identity, hotas), strict=True):
        if parts and len(parts) != len(found):
            raise ValueError(f"{len(found) - len(parts)} of {len(found)} results have no {name}")
    idtp, idfn, idfp = (sum(getattr(r, n) for r in identity) for n in ("idtp", "idfn", "idfp"))
    return Evaluation(
        found[0].protocol,
        found[0].threshold,
        combine_clear(clear, rules) if clear else None,
        identity_of_counts(idtp, idfn, idfp, rules) if identity else None,
        combine_hota(hotas) if hotas else None,
    )


def average_classes(results: Mapping[Any, Evaluation]) -> dict[str, Any]:
    """The mean of every score over classes, each class with the same weight.

    ``results`` holds the combined evaluation of each class. Counts are averaged like the ratios.
    """
    if not results:
        raise ValueError("results is empty")
    scores = [result.scores for result in results.values()]
    return {name: np.mean([s[name] for s in scores], axis=0) for name in scores[0]}


def evaluate_sequences(
    sequences: Mapping[str, tuple[TrackTable, TrackTable]],
    *,
    executor: str | Executor | None = None,
    workers: int | None = None,
    **options: Any,
) -> dict[str, Evaluation]:
    """Evaluate several sequences, here, in threads or in processes, with a progress bar.

    Parameters
    ----------
    sequences : mapping
        Name of each sequence, with its truth and its tracks.
    executor : {None, "threads", "processes"} or concurrent.futures.Executor
        Where to work; the numbers are the same.
    workers : int, optional
        How many threads or processes.
    **options
        As in :func:`evaluate`.

    Returns
    -------
    dict
        The evaluation of each sequence, in the order of ``sequences``.
    """
    pools = {"threads": ThreadPoolExecutor, "processes": ProcessPoolExecutor}
    work = partial(evaluate, **options)
    for name, pair in sequences.items():
        if not isinstance(pair, tuple | list) or len(pair) != 2:
            raise ValueError(f"sequences[{name!r}] must be a pair of truth and tracks")
    truths, tracks = zip(*sequences.values(), strict=True) if sequences else ((), ())
    if executor is None:
        results: Iterable[Evaluation] = map(work, truths, tracks)
        return _collected(sequences, results)
    if isinstance(executor, Executor):
        context: Any = nullcontext(executor)
    elif executor in pools:
        context = pools[executor](workers)
    else:
        raise TypeError(
            "executor must be None, 'threads', 'processes' or a concurrent.futures.Executor, "
            f"got {executor!r}"
        )
    with context as pool:
        return _collected(sequences, pool.map(work, truths, tracks))


def _collected(names: Iterable[str], results: Iterable[Evaluation]) -> dict[str, Evaluation]:
    listed = list(names)
    shown = _progress.with_progress(results, "evaluating", len(listed), "sequences")
    return dict(zip(listed, shown, strict=True))
