"""Numbers as text, the same in sentences, tables and figures; and JSON that is always valid."""

import json
import math
from typing import Any

from trackmetrics.results import to_json

MISSING = "–"
"""Shown for what is undefined."""
SMALLEST_P_VALUE = 1e-300


def number(value: float | None, digits: int = 3) -> str:
    """``digits`` significant digits, without an exponent where that reads well.

    >>> number(0.12345), number(12345.6), number(1.2e-7), number(float("nan"))
    ('0.123', '12346', '1.2e-07', '–')
    """
    if value is None or math.isnan(value):
        return MISSING
    if math.isinf(value):
        return "inf" if value > 0 else "-inf"
    if 10**digits <= abs(value) < 1e5:
        return f"{value:.0f}"
    return f"{value:.{digits}g}"


def p_value(value: float | None) -> str:
    """A probability; one too small for a float is said to be so.

    >>> p_value(0.0123), p_value(0.0)
    ('0.012', '< 1e-300')
    """
    if value is not None and value < SMALLEST_P_VALUE:
        return f"< {SMALLEST_P_VALUE:g}"
    return number(value, 2)


def json_text(value: Any, indent: int | None = 2) -> str:
    """Valid JSON of a result or of what holds results: what is undefined is null."""
    return json.dumps(to_json(value), indent=indent, allow_nan=False, ensure_ascii=False)
