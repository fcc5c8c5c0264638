"""Files of boxes that py-motmetrics reads, and its table of results."""

import io
from collections.abc import Callable
from enum import Enum
from typing import Any
from xml.etree import ElementTree

import numpy as np
from scipy.io import loadmat

from trackmetrics._tables.data_frames import pandas

_COLUMNS = ["X", "Y", "Width", "Height", "Confidence", "ClassId", "Visibility"]
_SEPARATORS = r"\s+|\t+|,"


class Format(Enum):
    """The formats of files."""

    MOT16 = "mot16"
    """MOTChallenge 2016 and later."""
    MOT15_2D = "mot15-2D"
    """MOTChallenge 2015."""
    VATIC_TXT = "vatic-txt"
    """Text of the annotation tool VATIC."""
    DETRAC_MAT = "detrac-mat"
    """UA-DETRAC, MATLAB file."""
    DETRAC_XML = "detrac-xml"
    """UA-DETRAC, XML."""


def load_motchallenge(fname: Any, **kwargs: Any) -> Any:
    """Boxes of a MOTChallenge file.

    Parameters
    ----------
    fname : path or file
        Where to read.
    sep : str
        The separator, a regular expression; by default spaces, tabs or commas.
    min_confidence : float
        Rows of less confidence are left out; by default -1. Use 1 for truth.

    Returns
    -------
    DataFrame
        Indexed by FrameId and Id; the corner X, Y is counted from 0, the file's from 1.
    """
    sep = kwargs.pop("sep", _SEPARATORS)
    least = kwargs.pop("min_confidence", -1)
    text = fname.read() if hasattr(fname, "read") else None
    source = fname if text is None else io.StringIO(text)
    names = ["FrameId", "Id", *_COLUMNS, "unused"]
    options: dict[str, Any] = {"engine": "python"}
    if sep == _SEPARATORS:
        sep, options = _one_separator(source)
    frame = pandas().read_csv(
        source,
        sep=sep,
        index_col=[0, 1],
        skipinitialspace=True,
        header=None,
        names=names,
        **options,
    )
    frame[["X", "Y"]] -= 1
    del frame["unused"]
    return frame[frame["Confidence"] >= least]


def _one_separator(source: Any) -> tuple[str, dict[str, Any]]:
    """The separator of a file that has only commas or only blanks, which pandas reads fast."""
    exact = {"engine": "c"}
    if int(pandas().__version__.partition(".")[0]) < 3:
        exact["float_precision"] = "round_trip"  # what later releases do by themselves
    if hasattr(source, "read"):
        text = source.getvalue()
    else:
        try:
            with open(source, encoding="utf-8") as file:
                text = file.read()
        except (OSError, UnicodeDecodeError):
            return _SEPARATORS, {"engine": "python"}  # a URL or a packed file
    if "," not in text:
        return r"\s+", exact
    if " " not in text and "\t" not in text:
        return ",", exact
    return _SEPARATORS, {"engine": "python"}


def load_vatictxt(fname: Any, **kwargs: Any) -> Any:
    """Boxes of a VATIC text file; every attribute is a column of True and False.

    Parameters
    ----------
    fname : path
        Where to read.
    sep : str
        The separator; by default a blank.
    """
    sep = kwargs.pop("sep", " ")
    with open(fname, encoding="utf-8") as file:
        lines = [line.rstrip() for line in file]
    attributes = sorted({field for line in lines for field in line.split(sep)[10:]})
    rows = [line.split() for line in lines]
    ids = np.array([row[0] for row in rows], dtype=np.int64)
    low_x, low_y, high_x, high_y = (
        np.array([row[k] for row in rows], dtype=np.float32) for k in range(1, 5)
    )
    columns: dict[str, Any] = {
        "FrameId": np.array([row[5] for row in rows], dtype=np.int64),
        "Id": ids,
        "X": low_x,
        "Y": low_y,
        "Width": high_x - low_x,
        "Height": high_y - low_y,
    }
    for k, name in enumerate(("Lost", "Occluded", "Generated")):
        columns[name] = np.array([row[6 + k] == "1" for row in rows], dtype=np.bool_)
    columns["ClassId"] = [row[9].strip('"') for row in rows]
    for attribute in attributes:
        name = attribute.replace('"', "").capitalize()
        columns[name] = np.array([attribute in row[10:] for row in rows], dtype=np.bool_)
    return pandas().DataFrame(columns).set_index(["FrameId", "Id"])


def load_detrac_mat(fname: Any) -> Any:
    """Boxes of a UA-DETRAC file of MATLAB."""
    info = loadmat(fname)["gtInfo"][0][0]
    frames = info[4][0].astype(np.int64)
    left, top, height, width = (info[k].astype(np.float32)[frames - 1] for k in range(4))
    rows, targets = np.nonzero(left > 0)
    at = rows, targets
    boxes = left[at] - width[at] / 2, top[at] - height[at], width[at], height[at]
    return _detrac(frames[rows], targets + 1, boxes)


def load_detrac_xml(fname: Any) -> Any:
    """Boxes of a UA-DETRAC file of XML."""
    found = [
        (int(frame.attrib["num"]), int(target.attrib["id"]), box)
        for frame in ElementTree.parse(fname).getroot().iter("frame")
        for target in frame.iter("target")
        if (box := target.find("box")) is not None
    ]
    boxes = [
        np.array([float(box.attrib[name]) for _, _, box in found])
        for name in ("left", "top", "width", "height")
    ]
    return _detrac([row[0] for row in found], [row[1] for row in found], boxes)


def _detrac(frames: Any, ids: Any, boxes: Any) -> Any:
    left, top, width, height = boxes
    values = (left - 1, top - 1, width, height, 1, -1, -1)
    index = pandas().MultiIndex.from_arrays([frames, ids], names=["FrameId", "Id"])
    return pandas().DataFrame(dict(zip(_COLUMNS, values, strict=True)), index=index)


_READERS: dict[Format, Callable[..., Any]] = {
    Format.MOT16: load_motchallenge,
    Format.MOT15_2D: load_motchallenge,
    Format.VATIC_TXT: load_vatictxt,
    Format.DETRAC_MAT: load_detrac_mat,
    Format.DETRAC_XML: load_detrac_xml,
}


def loadtxt(fname: Any, fmt: Format | str = Format.MOT15_2D, **kwargs: Any) -> Any:
    """Boxes of a file of a known format.

    Parameters
    ----------
    fname : path or file
        Where to read.
    fmt : Format or str
        The format.
    **kwargs
        The reader's own.

    Raises
    ------
    ValueError
        Where ``fmt`` is no format.
    """
    return _READERS[Format(fmt)](fname, **kwargs)


def render_summary(
    summary: Any,
    formatters: dict[str, Callable[[Any], str]] | None = None,
    namemap: dict[str, str] | None = None,
    buf: Any = None,
) -> Any:
    """A table of results as text.

    Parameters
    ----------
    summary : DataFrame
        Sequences in rows, metrics in columns.
    formatters : dict, optional
        What makes text of a metric's value.
    namemap : dict, optional
        Headings, by metric.
    buf : file, optional
        Where to write; without it the text is returned.
    """
    names = namemap or {}
    formats = None if formatters is None else {names.get(k, k): f for k, f in formatters.items()}
    return summary.rename(columns=names).to_string(buf=buf, formatters=formats)


motchallenge_metric_names = {
    "idf1": "IDF1",
    "idp": "IDP",
    "idr": "IDR",
    "recall": "Rcll",
    "precision": "Prcn",
    "num_unique_objects": "GT",
    "mostly_tracked": "MT",
    "partially_tracked": "PT",
    "mostly_lost": "ML",
    "num_false_positives": "FP",
    "num_misses": "FN",
    "num_switches": "IDs",
    "num_fragmentations": "FM",
    "mota": "MOTA",
    "motp": "MOTP",
    "num_transfer": "IDt",
    "num_ascend": "IDa",
    "num_migrate": "IDm",
}
"""MOTChallenge's headings."""
