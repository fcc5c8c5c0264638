"""Masks as run-length codes: the strings of COCO, and pycocotools between them and pixels."""

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics import errors

Sizes = NDArray[np.int64]


def pycocotools() -> Any:
    """The module that codes masks; an error that names the extra where it is not installed."""
    try:
        from pycocotools import mask
    except ImportError:
        raise ModuleNotFoundError(
            "masks need pycocotools: pip install 'trackmetrics[masks]'", name="pycocotools"
        ) from None
    return mask


def columns(masks: Any, sizes: Any, length: int) -> tuple[NDArray[np.object_], Sizes]:
    """Run-length strings and heights and widths, of masks in any of their forms.

    ``masks`` holds strings (``sizes`` then gives height and width, one pair or one a row), the
    dictionaries of pycocotools (``size``, ``counts``), or arrays of pixels.
    """
    if isinstance(masks, np.ndarray) and masks.dtype != object and masks.dtype.kind not in "US":
        masks = list(masks)
    masks = masks.tolist() if isinstance(masks, np.ndarray) else list(masks)
    if len(masks) != length:
        raise errors.length("mask", len(masks), "time", length, "rows")
    codes = np.empty(length, dtype=object)
    if all(isinstance(m, str | bytes) for m in masks):
        codes[:] = [m.decode("ascii") if isinstance(m, bytes) else m for m in masks]
        return codes, _sizes(sizes, length)
    found = [_code(row, mask) for row, mask in enumerate(masks)]
    codes[:] = [counts for counts, _ in found]
    return codes, np.array([size for _, size in found], dtype=np.int64).reshape(length, 2)


def _sizes(sizes: Any, length: int) -> Sizes:
    if sizes is None and length:
        raise ValueError("mask_size must be (height, width) where masks are strings, got None")
    array = np.asarray((0, 0) if sizes is None else sizes)
    if array.shape not in ((2,), (length, 2)):
        raise errors.shape("mask_size", array.shape, f"(2,) or ({length}, 2)")
    return np.array(np.broadcast_to(array, (length, 2)), dtype=np.int64)


def _code(row: int, mask: Any) -> tuple[str, Sequence[int]]:
    if isinstance(mask, Mapping):
        counts, size = mask["counts"], [int(n) for n in mask["size"]]
        if isinstance(counts, list):
            counts = pycocotools().frPyObjects({"size": size, "counts": counts}, *size)["counts"]
        return (counts.decode("ascii") if isinstance(counts, bytes) else counts), size
    pixels = np.asarray(mask)
    if pixels.ndim != 2:
        raise ValueError(
            f"mask[{row}] must be a run-length string, a dictionary with size and counts, or an "
            f"array (height, width), got {type(mask).__name__}"
        )
    counts = pycocotools().encode(np.asfortranarray(pixels.astype(bool), dtype=np.uint8))["counts"]
    return counts.decode("ascii"), list(pixels.shape)


def dictionaries(codes: NDArray[np.object_], sizes: Sizes) -> list[dict[str, Any]]:
    """The form that pycocotools takes: one dictionary of size and counts a mask."""
    pairs = zip(sizes.tolist(), codes.tolist(), strict=True)
    return [{"size": size, "counts": counts.encode("ascii")} for size, counts in pairs]


def pixels(codes: NDArray[np.object_], sizes: Sizes) -> list[NDArray[np.bool_]]:
    """Each mask as an array of height x width, by pycocotools."""
    coder = pycocotools()
    with warnings.catch_warnings():  # pycocotools 2.0.11 warns of its own arrays on NumPy 2
        warnings.simplefilter("ignore", DeprecationWarning)
        return [coder.decode(code).astype(bool) for code in dictionaries(codes, sizes)]
