"""Numbers as people write them: decimal commas, thousands separators, marks of missing values."""

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmetrics._tables.errors import value

MISSING = ("", "NA", "N/A", "NaN", "nan", "NAN", "null", "NULL", "None", "<NA>", "#N/A")
"""Cells that hold no value."""
DECIMAL_COMMA = r"^-?\d+,\d+(?:[eE][+-]?\d+)?$"
"""A number with a comma before its decimals."""
THOUSANDS = r"^-?\d{1,3}(?:,\d{3})+(?:\.\d+)?$"
"""A number with commas between its thousands."""


def from_cells(file: str, name: str, cells: NDArray[np.object_], decimal_comma: bool) -> Any:
    """Cells as numbers where all of them are; None is missing."""
    numbers = _floats([None if c is None else c.strip() for c in cells], decimal_comma)
    if numbers is not None:
        return numbers
    stripped = ["" if c is None else c.strip() for c in cells]
    others = [(row, c) for row, c in enumerate(stripped) if c and _floats([c], False) is None]
    with_comma = [(row, c) for row, c in others if re.match(DECIMAL_COMMA, c)]
    grouped = [(row, c) for row, c in others if re.match(THOUSANDS, c)]
    if len(with_comma) == len(others):
        if len(grouped) == len(others):
            refuse_ambiguous(file, *grouped[0], name)
        return np.array([float(c.replace(",", ".")) if c else np.nan for c in stripped])
    refuse_thousands(file, name, [(row, c) for row, c in grouped if "." in c])
    return cells


def _floats(cells: list[str | None], comma: bool) -> NDArray[np.float64] | None:
    if any(c is not None and "_" in c for c in cells):  # a number for Python only
        return None
    try:
        return np.array(
            [np.nan if c is None else float(c.replace(",", ".") if comma else c) for c in cells],
            np.float64,
        )
    except ValueError:
        return None


def refuse_ambiguous(file: str, row: int, cell: str, name: str) -> None:
    """The error for commas that may be of either kind."""
    raise ValueError(
        f"{file}, row {row}: {name} is {value(cell)}: a thousands separator or a decimal comma? "
        "Write a decimal point"
    )


def refuse_thousands(file: str, name: str, found: list[tuple[int, str]]) -> None:
    """The error for thousands separators, if any were found."""
    if found:
        row, cell = found[0]
        raise ValueError(
            f"{file}, row {row}: {name} is {value(cell)}, with a thousands separator: write it "
            "without"
        )
