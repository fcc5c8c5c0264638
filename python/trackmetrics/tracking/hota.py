"""HOTA: detection and association over 19 thresholds of similarity."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import _backend
from trackmetrics._similarity import EPS
from trackmetrics.results import Result
from trackmetrics.tracking.frames import TrackFrames, as_frames
from trackmetrics.tracking.similarity import PairMeasure, pair_measure
from trackmetrics.tracks import TrackTable

Codes = NDArray[np.int64]
Floats = NDArray[np.float64]

_ALPHAS = np.arange(0.05, 0.99, 0.05)  # as TrackEval rounds them


@dataclass(frozen=True, eq=False)
class HOTA(Result):
    """HOTA of a sequence: means over alpha, and the values at each alpha, shape (19,).

    All scores lie in [0, 1], and 1 is best.
    """

    hota: float
    """Mean of ``hota_alpha``."""
    deta: float
    """Mean of ``deta_alpha``."""
    assa: float
    """Mean of ``assa_alpha``."""
    detre: float
    """Mean of ``detre_alpha``."""
    detpr: float
    """Mean of ``detpr_alpha``."""
    assre: float
    """Mean of ``assre_alpha``."""
    asspr: float
    """Mean of ``asspr_alpha``."""
    loca: float
    """Mean of ``loca_alpha``."""
    owta: float
    """Mean of ``owta_alpha``."""
    hota_0: float
    """HOTA at the lowest alpha, 0.05: TrackEval's HOTA(0)."""
    loca_0: float
    """LocA at the lowest alpha."""
    hotaloca_0: float
    """Their product."""
    alphas: Floats
    """Least similarity of a pair: 0.05, 0.10 ... 0.95."""
    hota_alpha: Floats
    """``sqrt(deta * assa)``."""
    deta_alpha: Floats
    """Detection accuracy ``tp / (tp + fn + fp)``."""
    assa_alpha: Floats
    """Association accuracy: mean over the pairs (i, j) of ``n / (n_i + n_j - n)``, with n the
    number of pairs of target i and track j, and n_i and n_j their numbers of rows."""
    detre_alpha: Floats
    """Detection recall ``tp / (tp + fn)``."""
    detpr_alpha: Floats
    """Detection precision ``tp / (tp + fp)``."""
    assre_alpha: Floats
    """Association recall: mean over the pairs of ``n / n_i``."""
    asspr_alpha: Floats
    """Association precision: mean over the pairs of ``n / n_j``."""
    loca_alpha: Floats
    """Mean similarity of the pairs; 1 without a pair."""
    owta_alpha: Floats
    """``sqrt(detre * assa)``: HOTA that does not count false alarms."""
    tp_alpha: Codes
    """Number of pairs."""
    fn_alpha: Codes
    """Number of truth rows without a pair."""
    fp_alpha: Codes
    """Number of track rows without a pair."""


def hota(
    frames: TrackFrames | TrackTable,
    tracks: TrackTable | None = None,
    *,
    similarity: str | Sequence[Any] = "iou",
    threshold: float = 0.5,
) -> HOTA:
    """HOTA: the geometric mean of detection and association accuracy, over 19 thresholds.

    In each frame the pairs with the largest total of (similarity x how well the two identities
    agree over the whole sequence) are taken; at each alpha those count that have a similarity of at
    least alpha. Then

        HOTA(alpha) = sqrt(DetA(alpha) * AssA(alpha)),  HOTA = mean over alpha

    Parameters
    ----------
    frames, tracks, similarity
        As in :func:`clear_mot`.
    threshold : float
        For ``similarity="euclidean"`` the distance at which the similarity is 0.5, in the unit of
        the positions: the similarity is ``max(0, 1 - d / (2 * threshold))``. Not used otherwise.

    Returns
    -------
    HOTA
        Means over alpha and the values at each alpha, in [0, 1], 1 at best.

    Raises
    ------
    ValueError, TypeError
        As in :func:`clear_mot`.

    Notes
    -----
    The numbers are those of TrackEval 1.3.0, whose authors defined the score; other than with CLEAR
    MOT there are no two sets of rules. A pair may be 2.2e-16 below alpha. Without a pair LocA is 1
    and all else is 0, as in TrackEval.

    References
    ----------
    Luiten et al., "HOTA: A higher order metric for evaluating multi-object tracking", Int. J.
    Computer Vision 129, 2021, doi:10.1007/s11263-020-01375-2.

    Examples
    --------
    A target is followed without an error of position, by one track in each half:

    >>> frames = TrackFrames.from_columns(
    ...     [1, 2, 3, 4], ["ferry"] * 4, [1, 2, 3, 4], [7, 7, 8, 8],
    ...     truth_boxes=[[0, 0, 2, 2]] * 4, track_boxes=[[0, 0, 2, 2]] * 4,
    ... )
    >>> scores = hota(frames)
    >>> scores.deta, scores.assa, scores.loca
    (1.0, 0.5, 1.0)
    >>> round(scores.hota, 4)
    0.7071
    """
    return hota_of(pair_measure(as_frames(frames, tracks), similarity, threshold))


def combine_hota(results: Sequence[HOTA]) -> HOTA:
    """HOTA of several sequences: counts summed, the rest weighted by the number of pairs."""
    tp, fn, fp = (sum(getattr(r, f"{n}_alpha") for r in results) for n in ("tp", "fn", "fp"))
    shares = [np.stack([r.assa_alpha, r.assre_alpha, r.asspr_alpha]) * r.tp_alpha for r in results]
    association = np.sum(shares, axis=0) / np.maximum(1, tp)
    sums = np.sum([r.loca_alpha * r.tp_alpha for r in results], axis=0)
    return _result(tp, fn, fp, association, sums)


def hota_of(measure: PairMeasure) -> HOTA:
    """HOTA of pairs that were found before."""
    truth, tracks = measure.frames.truth, measure.frames.tracks
    kernel = _backend.kernels.hota
    tp, sums, *means = kernel(truth.coded(), tracks.coded(), measure.pairs, _ALPHAS - EPS)
    fn, fp = len(truth) - tp, len(tracks) - tp
    return _result(tp, fn, fp, np.stack(means), sums)


def _result(tp: Codes, fn: Codes, fp: Codes, association: Floats, sums: Floats) -> HOTA:
    deta, detre, detpr = (tp / np.maximum(1, tp + other) for other in (fn + fp, fn, fp))
    assa, assre, asspr = association
    loca = np.divide(sums, tp, out=np.ones_like(sums), where=tp > 0)
    series = {
        "hota": np.sqrt(deta * assa),
        "deta": deta,
        "assa": assa,
        "detre": detre,
        "detpr": detpr,
        "assre": assre,
        "asspr": asspr,
        "loca": loca,
        "owta": np.sqrt(detre * assa),
    }
    lowest = float(series["hota"][0]), float(loca[0])
    means: dict[str, Any] = {name: float(values.mean()) for name, values in series.items()}
    by_alpha: dict[str, Any] = {f"{name}_alpha": values for name, values in series.items()}
    return HOTA(
        **means,
        hota_0=lowest[0],
        loca_0=lowest[1],
        hotaloca_0=lowest[0] * lowest[1],
        alphas=_ALPHAS.copy(),
        **by_alpha,
        tp_alpha=tp,
        fn_alpha=fn,
        fp_alpha=fp,
    )
