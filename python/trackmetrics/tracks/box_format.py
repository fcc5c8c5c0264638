"""The forms in which boxes are given."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
FORMATS = ("ltwh", "ltrb")


def check(box_format: Any) -> None:
    """Refuse a form that is none of ours."""
    if box_format not in FORMATS:
        raise ValueError(f"box_format must be 'ltwh' or 'ltrb', got {box_format!r}")


def to_ltwh(argument: str, boxes: Floats | None, box_format: str) -> Floats | None:
    """Left, top, width and height; a box that ends before it begins is refused."""
    if boxes is None:
        return None
    if box_format == "ltrb":
        boxes = np.hstack([boxes[:, :2], boxes[:, 2:] - boxes[:, :2]])
    wrong = np.flatnonzero((boxes[:, 2:] < 0).any(axis=1))
    if len(wrong):
        width, height = boxes[wrong[0], 2:].tolist()
        raise ValueError(
            f"{argument}[{wrong[0]}] is {width:g} wide and {height:g} high with "
            f"box_format={box_format!r}, expected at least 0"
        )
    return boxes
