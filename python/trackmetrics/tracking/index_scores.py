"""Scores over the identities of tracks."""

from typing import Any

from trackmetrics import _backend, _check
from trackmetrics.errors import NotPlain
from trackmetrics.results import MOTMetrics
from trackmetrics.tracking.labels import labels, times


def mot_metrics(ground_truth: Any, estimates: Any, threshold: float = 10.0) -> MOTMetrics:
    """CLEAR MOT scores of frames in which the place in the list is the identity.

    In each frame the truth is matched with the estimates at the least total distance over all
    pairs; then pairs farther apart than ``threshold`` are dropped. Over all frames, with g points
    of truth,

        MOTA = 1 - (misses + false positives + switches) / g
        MOTP = mean distance of the pairs

    A switch is a pair whose truth index had another estimate index in the remembered frame; a
    fragmentation is a pair whose truth index had a pair before, but none in the remembered frame.
    The remembered frame is the last one that had truth.

    Parameters
    ----------
    ground_truth, estimates : list of list of array_like, or array of shape (T, n, d)
        For each of T frames the points of the truth and of the estimates, all in one unit. Or a
        tuple of all points, shape (N, d), and their offsets, int64 of shape (T + 1,).
    threshold : float
        Largest distance of a pair (inclusive), in the unit of the points; at least 0, may be
        infinite.

    Returns
    -------
    MOTMetrics
        ``mota``, 1 at best and without a lower bound; ``motp`` in the unit of the points, 0 at
        best; and four counts, 0 at best.

    Raises
    ------
    ValueError
        Where the sequences differ in length, points have different numbers of coordinates, a
        coordinate is not finite, or the threshold is NaN or negative.
    TypeError
        Where a frame is not a list, tuple or array of points.

    Notes
    -----
    This is ``pytcl.performance_evaluation.mot_metrics``: switches, fragmentations and so MOTA mean
    something only where every target and every track keeps its place in the lists. There is no
    preference for the pairs of the last frame, and the gate comes after the assignment, so that
    there may be fewer pairs than with the gate first. Ties are broken as SciPy's
    ``linear_sum_assignment`` does. MOTA is 1 without truth, MOTP is 0 without a pair.

    References
    ----------
    Bernardin and Stiefelhagen, "Evaluating multiple object tracking performance: the CLEAR MOT
    metrics", EURASIP J. Image and Video Processing, 2008, doi:10.1155/2008/246309.

    Examples
    --------
    >>> truth = [[[0.0, 0.0], [10.0, 10.0]], [[1.0, 0.0], [11.0, 10.0]]]
    >>> estimates = [[[0.5, 0.0], [10.5, 10.0]], [[1.5, 0.0]]]
    >>> scores = mot_metrics(truth, estimates, threshold=5.0)
    >>> scores.mota, scores.motp, scores.num_misses
    (0.75, 0.5, 1)
    """
    kernel = _backend.kernels.mot_metrics
    try:
        scores = kernel(ground_truth, estimates, threshold)
    except NotPlain:
        truth = _check.frames("ground_truth", ground_truth)
        found = _check.frames("estimates", estimates)
        scores = kernel(truth, found, _check.number("threshold", threshold))
    return MOTMetrics(*scores)


def track_purity(true_labels: Any, estimated_labels: Any) -> float:
    """Share of observations that belong to the main target of their estimated track.

    For observations i = 1 .. n with true label t_i and estimated label e_i,

        purity = 1/n sum over labels e of max over labels t of |{i : e_i = e, t_i = t}|

    Parameters
    ----------
    true_labels, estimated_labels : array_like of shape (n,)
        For each observation the target it belongs to and the track it was given to. Labels are
        anything hashable: integers, strings, tuples. Only equality counts.

    Returns
    -------
    float
        In (0, 1]; 1 is best: every track holds observations of one target only.

    Raises
    ------
    ValueError
        Where the lists differ in length, have more than one axis, or hold a NaN.
    TypeError
        Where a label cannot be hashed.

    Notes
    -----
    The purity of no observations is 1. A track of one observation is pure, so that purity alone
    rewards short tracks: read it beside `track_fragmentation`. ``-1`` is a label like any other.

    References
    ----------
    Manning, Raghavan and Schütze, *Introduction to Information Retrieval*, section 16.3, 2008,
    doi:10.1017/CBO9780511809071.

    Examples
    --------
    >>> track_purity([0, 0, 0, 1, 1, 1], ["a", "a", "b", "b", "b", "b"])
    0.8333333333333334
    """
    kernel = _backend.kernels.track_purity
    try:
        purity: float = kernel(true_labels, estimated_labels)
    except NotPlain:
        purity = kernel(
            labels("true_labels", true_labels), labels("estimated_labels", estimated_labels)
        )
    return purity


def track_fragmentation(true_labels: Any, estimated_labels: Any, time_indices: Any = None) -> int:
    """Number of times that a target passes from one estimated track to another.

    Along the observations of each true label, in the order of time, the changes of the estimated
    label are counted.

    Parameters
    ----------
    true_labels, estimated_labels : array_like of shape (n,)
        For each observation the target it belongs to and the track it was given to; anything
        hashable.
    time_indices : array_like of shape (n,), optional
        The time of each observation: numbers, dates, anything that can be ordered. Equal times keep
        the order in which they are given. Without it the observations stand in the order of time.

    Returns
    -------
    int
        At least 0, which is best.

    Raises
    ------
    ValueError
        Where the lists differ in length, have more than one axis, or hold a NaN.
    TypeError
        Where a label cannot be hashed, or times cannot be ordered.

    Notes
    -----
    This is what CLEAR MOT calls an identity switch; the names here are those of
    ``pytcl.performance_evaluation``. See `identity_switches` for the other view.

    References
    ----------
    Bernardin and Stiefelhagen, "Evaluating multiple object tracking performance: the CLEAR MOT
    metrics", EURASIP J. Image and Video Processing, 2008, doi:10.1155/2008/246309.

    Examples
    --------
    >>> track_fragmentation(["ferry"] * 4, [7, 7, 9, 9])
    1
    """
    kernel = _backend.kernels.track_fragmentation
    try:
        count: int = kernel(true_labels, estimated_labels, time_indices)
    except NotPlain:
        count = kernel(*_labels_and_times(true_labels, estimated_labels, time_indices))
    return count


def identity_switches(true_labels: Any, estimated_labels: Any, time_indices: Any = None) -> int:
    """Number of times that an estimated track passes from one target to another.

    Along the observations of each estimated label, in the order of time, the changes of the true
    label are counted.

    Parameters
    ----------
    true_labels, estimated_labels, time_indices
        As in :func:`track_fragmentation`.

    Returns
    -------
    int
        At least 0, which is best.

    Raises
    ------
    ValueError, TypeError
        As in :func:`track_fragmentation`.

    Notes
    -----
    py-motmetrics counts this as a transfer. CLEAR MOT's identity switch is the other view,
    `track_fragmentation`; the names here are those of ``pytcl.performance_evaluation``.

    Examples
    --------
    >>> identity_switches(["ferry", "ferry", "tug", "tug"], [7, 7, 7, 7])
    1
    >>> identity_switches(["tug", "ferry", "tug", "ferry"], [7, 7, 7, 7], time_indices=[4, 1, 3, 2])
    1
    """
    kernel = _backend.kernels.identity_switches
    try:
        count: int = kernel(true_labels, estimated_labels, time_indices)
    except NotPlain:
        count = kernel(*_labels_and_times(true_labels, estimated_labels, time_indices))
    return count


def _labels_and_times(
    true_labels: Any, estimated_labels: Any, time_indices: Any
) -> tuple[Any, ...]:
    return (
        labels("true_labels", true_labels),
        labels("estimated_labels", estimated_labels),
        times("time_indices", time_indices),
    )
