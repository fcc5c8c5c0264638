"""pandas, imported when a frame is first asked for."""

from importlib import import_module
from typing import Any


def pandas() -> Any:
    """The module pandas.

    Raises
    ------
    ImportError
        Where it is not installed; the message names the extra that brings it.
    """
    try:
        return import_module("pandas")
    except ModuleNotFoundError as error:
        if error.name != "pandas":
            raise
        raise ImportError(
            "py-motmetrics' frames need pandas: pip install 'trackmetrics[motmetrics]'",
            name="pandas",
        ) from None
