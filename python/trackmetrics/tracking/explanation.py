"""Where two evaluations of the same truth differ: counts, frames, and the rule behind it."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from trackmetrics.results import Result
from trackmetrics.tracking.evaluation import Evaluation
from trackmetrics.tracking.protocols import PROTOCOLS

_EMPTY = object()


@dataclass(frozen=True)
class Explanation(Result):
    """How two evaluations differ."""

    counts: dict[str, tuple[float, float]]
    """Every count of CLEAR MOT and of the identity scores that differs: its two values."""
    events: tuple[dict[str, Any], ...]
    """Events that only one of the two has: time, truth, track, event, ``only_in`` (``"a"`` or
    ``"b"``) and the rule, in the order of time."""
    sentences: tuple[str, ...]
    """The same as text: a sentence for each count, then for each event."""

    def __str__(self) -> str:
        return "\n".join(self.sentences)


def explain(result_a: Evaluation, result_b: Evaluation) -> Explanation:
    """Say in which counts two evaluations differ, in which frames, and by which rule.

    Parameters
    ----------
    result_a, result_b : Evaluation
        Of the same truth: with two protocols, two thresholds or two trackers.

    Returns
    -------
    Explanation

    Notes
    -----
    Where the protocols differ, the rule of a fragmentation is the protocols' definition of a
    fragmentation, if both have the same pairs of that object in that frame; else, the rule of a
    pair is continuation or the objective of the assignment. Where the threshold differs, the rule
    is the threshold; where nothing differs, the tracks themselves do.

    Examples
    --------
    >>> from trackmetrics.tracking import evaluate
    >>> from trackmetrics.tracks import TrackTable
    >>> truth = TrackTable.from_columns(time=[1, 2, 3], id=["ferry"] * 3, position=[[0], [1], [2]])
    >>> tracks = TrackTable.from_columns(time=[1, 3], id=[7, 7], position=[[0], [2]])
    >>> options = {"similarity": "euclidean", "threshold": 1}
    >>> a = evaluate(truth, tracks, **options)
    >>> b = evaluate(truth, tracks, protocol="motmetrics", **options)
    >>> print(explain(a, b))
    frag is 0 in a and 1 in b.
    Frame 3: only b has a fragmentation of object ferry with track 7 (rule: fragmentation).
    """
    for name, result in (("result_a", result_a), ("result_b", result_b)):
        if not isinstance(result, Evaluation):
            raise TypeError(f"{name} must be an Evaluation, got {type(result).__name__}")
    counts = dict(_differing_counts(result_a, result_b))
    rows_a, rows_b = _rows(result_a), _rows(result_b)
    left = [(row, "a") for row in rows_a if row not in rows_b]
    left += [(row, "b") for row in rows_b if row not in rows_a]
    place = {row: i for rows in (rows_b, rows_a) for i, row in enumerate(rows)}
    left.sort(key=lambda item: (item[0][0], place[item[0]], item[1]))
    moved = {(row[0], row[1]) for row, _ in left if row[3] == "match"}
    events = tuple(_event(row, side, result_a, result_b, moved) for row, side in left)
    sentences = [f"{name} is {x:g} in a and {y:g} in b." for name, (x, y) in counts.items()]
    return Explanation(counts, events, (*sentences, *map(_sentence, events)))


def _differing_counts(a: Evaluation, b: Evaluation) -> Iterator[tuple[str, tuple[Any, Any]]]:
    first, second = a.scores, b.scores
    for name, value in first.items():
        other = second.get(name, _EMPTY)
        if isinstance(value, int) and isinstance(other, int) and value != other:
            yield name, (value, other)


def _rows(result: Evaluation) -> dict[tuple[Any, ...], None]:
    columns = [result.events[name].tolist() for name in ("time", "truth", "track", "event")]
    return dict.fromkeys(zip(*columns, strict=True))


def _event(
    row: tuple[Any, ...], side: str, a: Evaluation, b: Evaluation, moved: set[Any]
) -> dict[str, Any]:
    time, truth, track, event = row
    rule = _rule(event, (time, truth) in moved, a, b)
    return {
        **{"time": time, "truth": truth, "track": track, "event": event},
        **{"only_in": side, "rule": rule},
    }


def _rule(event: str, is_moved: bool, a: Evaluation, b: Evaluation) -> str:
    if a.threshold != b.threshold:
        return "threshold"
    if a.protocol == b.protocol:
        return "tracks"
    first, second = PROTOCOLS[a.protocol], PROTOCOLS[b.protocol]
    if event == "fragmentation" and not is_moved:
        return "fragmentation"
    if event in ("switch", "transfer") and not is_moved:
        return "an earlier pair"
    if first.forgets != second.forgets or first.most_similar != second.most_similar:
        return "continuation or objective"
    return "threshold rounding"


def _sentence(event: dict[str, Any]) -> str:
    text = f"Frame {event['time']}: only {event['only_in']} has a {event['event']}"
    if event["truth"] is not None:
        text += f" of object {event['truth']}"
    if event["track"] is not None:
        text += f" {'with' if event['truth'] is not None else 'of'} track {event['track']}"
    return f"{text} (rule: {event['rule']})."
