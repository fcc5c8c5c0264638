"""Reads track tables from files of any form that :mod:`trackmetrics.tracks.formats` lists."""

import os

from trackmetrics._tables import opening
from trackmetrics.tracks import formats
from trackmetrics.tracks.named import Mapped
from trackmetrics.tracks.table import RepeatedRowError, TrackTable


def read_tracks(
    path: str | os.PathLike[str],
    *,
    format: str | None = None,
    columns: Mapped | None = None,
    box_format: str | None = None,
) -> TrackTable:
    """Read tracks or truth from a file.

    Parameters
    ----------
    path : str or path
        The file; it may be packed (gzip, xz, zip).
    format : {"motchallenge", "kitti", "kitti_mots", "csv", "parquet"}, optional
        Without it the first line tells.
    columns : mapping, optional
        For CSV and Parquet, the file's names where they differ from those that
        :meth:`TrackTable.write` writes: ``{"id": "mmsi", "position": ["lon", "lat"]}``.
    box_format : {"ltwh", "ltrb"}, optional
        How the box that ``columns`` names is given; ``"ltwh"`` without it.

    Returns
    -------
    TrackTable
        All rows, in the order of the file.

    Raises
    ------
    ValueError
        Where something is wrong with the file; the message names file and line.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp(), "gt.txt")
    >>> _ = path.write_text("1,7,10,20,4,8,1,-1,-1,-1\\n2,7,12,20,4,8,1,-1,-1,-1\\n")
    >>> read_tracks(path)
    TrackTable(2 rows, 1 id, 2 times from 1 to 2; box, score)
    """
    content = opening.read(path, may_be_empty=True)
    form = formats.to_read(content, format)
    if form.pattern:
        if columns or box_format:
            raise ValueError(
                f"columns and box_format are for files with headings, not {form.title}"
            )
        arguments, lines = form.read(content)
        arguments["counts_frames"] = True
    else:
        arguments, lines = form.read(content, columns or {}), None
        if box_format is not None:
            arguments["box_format"] = box_format
    try:
        return TrackTable.from_columns(**arguments)
    except RepeatedRowError as error:
        if lines is None:
            raise ValueError(f"{content.name}: {error}") from None
        first, second = lines[error.first], lines[error.second]
        raise ValueError(
            f"{content.name}:{second}: frame {error.time} has id {error.id} twice, "
            f"first on line {first}"
        ) from None
    except ValueError as error:
        raise ValueError(f"{content.name}: {error}") from None
