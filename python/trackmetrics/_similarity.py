"""Similarity and distance of the rows of a frame, every pair."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
EPS = float(np.finfo(np.float64).eps)


def box_iou(truth: Floats, tracks: Floats) -> Floats:
    """Intersection over union of boxes (left, top, width, height), shape (n, m), in [0, 1].

    A box without area has the value 0 with every other.
    """
    corners = np.hstack([truth[:, :2], truth[:, :2] + truth[:, 2:]])
    others = np.hstack([tracks[:, :2], tracks[:, :2] + tracks[:, 2:]])
    low = np.maximum(corners[:, None, :2], others[None, :, :2])
    high = np.minimum(corners[:, None, 2:], others[None, :, 2:])
    shared = np.prod(np.maximum(high - low, 0), axis=2)
    area, other_area = (np.prod(c[:, 2:] - c[:, :2], axis=1) for c in (corners, others))
    union = area[:, None] + other_area - shared
    shared[(area <= EPS)[:, None] | (other_area <= EPS) | (union <= EPS)] = 0
    iou: Floats = np.divide(shared, union, out=np.zeros_like(shared), where=union > EPS)
    return iou


def euclidean_distances(truth: Floats, tracks: Floats) -> Floats:
    """Distance of every pair of positions, shape (n, m), in their unit."""
    distances: Floats = np.sqrt(np.square(truth[:, None] - tracks).sum(axis=2))
    return distances
