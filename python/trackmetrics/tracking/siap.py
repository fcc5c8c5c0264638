"""SIAP metrics: completeness, ambiguity, spuriousness, accuracy, continuity and identification.

With J(t) targets and N(t) tracks at time t, JT(t) targets and NA(t) tracks that are associated then

    completeness  = sum JT / sum J
    ambiguity     = sum NA / sum JT
    spuriousness  = sum (N - NA) / sum N
    accuracy      = sum of the errors of associated pairs / sum NA
    track changes = sum over targets of (NU - 1) / sum of TT
    longest       = sum over targets of TL / sum of T

NU is the number of associations that a target needs, TT the time for which it is associated, TL
its longest association and T its lifetime.
"""

import math
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _check
from trackmetrics.results import Result
from trackmetrics.tracking.associations import Associations, Interval, find_pairs
from trackmetrics.tracking.continuity import track_changes_and_longest
from trackmetrics.tracking.frames import TrackFrames

Codes = NDArray[np.int64]
Floats = NDArray[np.float64]

_UNIDENTIFIED, _CORRECT, _WRONG = 0, 1, 2


@dataclass(frozen=True, eq=False)
class SIAP(Result):
    """SIAP metrics of a sequence: totals, and the values at each time, shape (T,).

    The three of identification are NaN without identities, velocity accuracy without velocities.
    """

    completeness: float
    """Fraction of the targets that are tracked, in [0, 1]; 1 is best."""
    ambiguity: float
    """Tracks per tracked target, at least 0; 1 is best."""
    spuriousness: float
    """Fraction of the tracks that follow no target, in [0, 1]; 0 is best."""
    position_accuracy: float
    """Mean distance of associated pairs, in the unit of the positions; 0 is best."""
    velocity_accuracy: float
    """Mean difference of their velocities, in the unit of the velocities; 0 is best."""
    rate_of_track_number_change: float
    """Changes of the track per time for which a target is tracked; 0 is best."""
    longest_track_segment: float
    """Fraction of the targets' lifetimes in their longest associations, in [0, 1]; 1 is best."""
    id_completeness: float
    """Fraction of the tracked targets with an identity, in [0, 1]; 1 is best."""
    id_correctness: float
    """Fraction of the tracked targets whose identities are all right, in [0, 1]; 1 is best."""
    id_ambiguity: float
    """Fraction of the tracked targets with different identities, in [0, 1]; 0 is best."""
    times: NDArray[Any]
    """The times of the sequence, shape (T,)."""
    completeness_at: Floats
    """Completeness at each time; so the others."""
    ambiguity_at: Floats
    """Ambiguity at each time."""
    spuriousness_at: Floats
    """Spuriousness at each time."""
    position_accuracy_at: Floats
    """Position accuracy at each time."""
    velocity_accuracy_at: Floats
    """Velocity accuracy at each time."""
    id_completeness_at: Floats
    """Completeness of identification at each time."""
    id_correctness_at: Floats
    """Correctness of identification at each time."""
    id_ambiguity_at: Floats
    """Ambiguity of identification at each time."""


def siap(
    frames: TrackFrames,
    associations: Iterable[Interval],
    *,
    position: Sequence[int] | slice | None = None,
    velocity: Sequence[int] | slice | None = None,
    truth_identities: Mapping[Hashable, Any] | None = None,
    track_identities: Mapping[Hashable, Any] | None = None,
    protocol: str = "stonesoup",
) -> SIAP:
    """SIAP metrics of tracks that were associated with targets.

    With J(t) targets and N(t) tracks at time t, of which JT(t) and NA(t) are associated,

        completeness = sum JT / sum J,   ambiguity = sum NA / sum JT,
        spuriousness = sum (N - NA) / sum N,   accuracy = sum of errors / sum NA

    and the continuity of the association of each target.

    Parameters
    ----------
    frames : TrackFrames
        Truth and tracks of one sequence. Their positions may be whole states.
    associations : iterable of (truth id, track id, first time, last time)
        Which track follows which target, and when, both times included; :func:`associate` makes
        them. A pair counts at the times at which both have a row.
    position, velocity : sequence of int or slice, optional
        Components of the positions that are the position and the velocity. Without ``position``
        all that are not velocity.
    truth_identities : mapping, optional
        Identity of targets by their id; None, or no entry, where it is not known.
    track_identities : mapping, optional
        Identity that tracks declare, by their id: a value, or a mapping of time to value.
    protocol : {"stonesoup", "definition"}
        The numbers of Stone Soup, or the definitions without its particulars; see Notes.

    Returns
    -------
    SIAP
        Totals and series, each with its range and its best value.

    Raises
    ------
    ValueError
        Where an association names an unknown id or ends before it starts, only one of the two
        mappings of identities is given, there are neither positions nor boxes, or ``protocol`` is
        none of these.

    Notes
    -----
    ``"stonesoup"`` gives the numbers of Stone Soup 1.9: a total without a denominator is 0
    (ambiguity 1); the longest association of a target is the total time with one track; and in the
    number of associations a target needs, the track whose last association ends last comes first,
    and no more are counted after an association with one remaining time of the target.
    ``"definition"`` has NaN without a denominator, takes the longest single association, and
    counts the least number of associations that cover the time for which the target is tracked.
    Times are in seconds where they are dates, otherwise in their own unit.

    References
    ----------
    Votruba et al., "Single Integrated Air Picture (SIAP) metrics implementation", SIAP Systems
    Engineering Task Force, 2001, DTIC ADA397225. Stone Soup, ``SIAPMetrics`` and
    ``IDSIAPMetrics``, https://stonesoup.readthedocs.io.

    Examples
    --------
    >>> frames = TrackFrames.from_columns(
    ...     [0, 1, 2, 3], ["ferry"] * 4, [0, 1, 2, 3, 3], [7, 7, 8, 8, 9],
    ...     truth_positions=[[0.0], [1.0], [2.0], [3.0]],
    ...     track_positions=[[0.5], [1.5], [2.5], [3.5], [9.0]],
    ... )
    >>> found = siap(frames, [("ferry", 7, 0, 1), ("ferry", 8, 2, 3)])
    >>> found.completeness, found.ambiguity, found.spuriousness, found.position_accuracy
    (1.0, 1.0, 0.2, 0.5)
    >>> found.rate_of_track_number_change, round(found.longest_track_segment, 3)
    (0.5, 0.333)
    >>> found.spuriousness_at
    array([0. , 0. , 0. , 0.5])
    """
    if not isinstance(frames, TrackFrames):
        raise TypeError(f"frames must be TrackFrames, got {type(frames).__name__}")
    if protocol not in ("stonesoup", "definition"):
        raise ValueError(f"protocol must be 'stonesoup' or 'definition', got {protocol!r}")
    pairs = find_pairs(frames, associations)
    empty = 0.0 if protocol == "stonesoup" else math.nan
    changes, longest = track_changes_and_longest(frames, pairs, protocol == "stonesoup")
    parts = {
        **_counts(frames, pairs, empty),
        **_accuracies(frames, pairs, position, velocity, empty),
        **_identification(frames, pairs, truth_identities, track_identities, empty),
    }
    totals: dict[str, Any] = {}
    series: dict[str, Any] = {}
    for name, (part, whole, value) in parts.items():
        totals[name] = _ratio(part.sum(), whole.sum(), value)
        series[f"{name}_at"] = _ratios(part, whole, value)
    return SIAP(
        **totals,
        rate_of_track_number_change=_ratio(*changes, empty),
        longest_track_segment=_ratio(*longest, empty),
        times=frames.times,
        **series,
    )


Part = tuple[Floats, Floats, float]


def _ratio(part: float, whole: float, empty: float) -> float:
    return float(part / whole) if whole else empty


def _ratios(part: Floats, whole: Floats, empty: float) -> Floats:
    found: Floats = np.divide(part, whole, out=np.full(len(part), empty), where=whole != 0)
    return found


def _distinct(pairs: Associations, rows: Codes, frames: int) -> Floats:
    """At each time, how many of the rows there are in pairs."""
    _, first = np.unique(rows, return_index=True)
    return np.bincount(pairs.frame[first], minlength=frames).astype(np.float64)


def _counts(frames: TrackFrames, pairs: Associations, empty: float) -> dict[str, Part]:
    """Numerator, denominator and empty value of the three fractions, at each time."""
    J, N = (np.diff(side.starts).astype(np.float64) for side in (frames.truth, frames.tracks))
    JT = _distinct(pairs, pairs.truth_row, len(frames))
    NA = _distinct(pairs, pairs.track_row, len(frames))
    return {
        "completeness": (JT, J, empty),
        "ambiguity": (NA, JT, 1.0 + empty),
        "spuriousness": (N - NA, N, empty),
    }


def _accuracies(
    frames: TrackFrames,
    pairs: Associations,
    position: Sequence[int] | slice | None,
    velocity: Sequence[int] | slice | None,
    empty: float,
) -> dict[str, Part]:
    truth, tracks = frames.truth.centres("truth"), frames.tracks.centres("tracks")
    d = truth.shape[1] if len(truth) else tracks.shape[1]
    moving = _check.indices("velocity", velocity, d) if velocity is not None else []
    still = [i for i in range(d) if i not in moving]
    still = _check.indices("position", position, d) if position is not None else still
    difference = truth[pairs.truth_row] - tracks[pairs.track_row] if len(pairs.frame) else None
    NA = _distinct(pairs, pairs.track_row, len(frames))

    def part(components: list[int]) -> Floats:
        if difference is None:
            return np.zeros(len(frames))
        error = np.sqrt(np.square(difference[:, components]).sum(axis=1))
        return np.bincount(pairs.frame, error, minlength=len(frames)).astype(np.float64)

    unknown = np.full(len(frames), math.nan)
    of_velocity = (part(moving), NA, empty) if moving else (unknown, unknown, math.nan)
    return {"position_accuracy": (part(still), NA, empty), "velocity_accuracy": of_velocity}


def _identification(
    frames: TrackFrames,
    pairs: Associations,
    truth: Mapping[Hashable, Any] | None,
    tracks: Mapping[Hashable, Any] | None,
    empty: float,
) -> dict[str, Part]:
    names = ("id_completeness", "id_correctness", "id_ambiguity")
    if truth is None and tracks is None:
        unknown = np.full(len(frames), math.nan)
        return dict.fromkeys(names, (unknown, unknown, math.nan))
    if truth is None or tracks is None:
        missing = "truth_identities" if truth is None else "track_identities"
        raise ValueError(f"{missing} is missing: identification needs both mappings")
    kinds = _kinds(frames, pairs, truth, tracks)
    rows, of_pair = np.unique(pairs.truth_row, return_inverse=True)
    total = np.bincount(of_pair, minlength=len(rows))
    frame = np.zeros(len(rows), dtype=np.int64)
    frame[of_pair] = pairs.frame

    def targets(kind: int) -> Floats:
        """At each time, the targets all of whose pairs are of this kind."""
        whole = np.bincount(of_pair[kinds == kind], minlength=len(rows)) == total
        return np.bincount(frame[whole], minlength=len(frames)).astype(np.float64)

    JT = np.bincount(frame, minlength=len(frames)).astype(np.float64)
    JU, JC, JI = targets(_UNIDENTIFIED), targets(_CORRECT), targets(_WRONG)
    found = (JT - JU, JC, JT - JC - JI - JU)
    return {name: (part, JT, empty) for name, part in zip(names, found, strict=True)}


def _kinds(
    frames: TrackFrames,
    pairs: Associations,
    truth: Mapping[Hashable, Any],
    tracks: Mapping[Hashable, Any],
) -> Codes:
    """Of each pair, whether the track's identity is missing, the target's own, or another."""
    true = [truth.get(name) for name in frames.truth.names]
    said = [tracks.get(name) for name in frames.tracks.names]
    times = frames.times.tolist()
    kinds = np.empty(len(pairs.frame), dtype=np.int64)
    targets = frames.truth.ids[pairs.truth_row].tolist()
    others = frames.tracks.ids[pairs.track_row].tolist()
    for k, (t, i, j) in enumerate(zip(pairs.frame.tolist(), targets, others, strict=True)):
        identity = said[j]
        if isinstance(identity, Mapping):
            identity = identity.get(times[t])
        if identity is None:
            kinds[k] = _UNIDENTIFIED
        else:
            kinds[k] = _CORRECT if identity == true[i] else _WRONG
    return kinds
