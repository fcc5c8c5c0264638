"""A log of an estimator: one row per update, many tracks, whatever columns there are."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, Unpack

import numpy as np
from numpy.typing import NDArray

from trackmetrics.logs import filterpy, formats, frames, stone_soup
from trackmetrics.logs.columns import Columns, has_value
from trackmetrics.logs.header import HeaderArguments, LogHeader, State, to_record
from trackmetrics.logs.normalize import LogParts, normalize
from trackmetrics.logs.schema import NUMERIC_COLUMNS
from trackmetrics.logs.selection import Renaming, check_selected, notes_on_unused, select_columns
from trackmetrics.logs.serialization import to_table


class EstimatorLog:
    """What an estimator said at each update, and the truth where it is known.

    Made by :meth:`from_columns`, :meth:`from_frame`, :meth:`from_stone_soup`,
    :meth:`from_filterpy` or :func:`read_log`. The rows stand track by track, each in the order of
    time; repeated rows are gone; NIS, NEES and what they need are filled in where they follow from
    other columns (``computed`` says where).

    >>> log = EstimatorLog.from_columns(track=["a", "a", "b"], nis=[2.0, 1.5, 0.3], nis_dof=2)
    >>> log.tracks
    ('a', 'b')
    >>> log["a"].nis
    array([2. , 1.5])
    """

    def __init__(
        self,
        columns: Columns,
        tracks: Sequence[str],
        starts: Sequence[int],
        states: Sequence[State] = (),
        measurement_angles: Mapping[str, Mapping[int, float]] | None = None,
        computed: Mapping[str, NDArray[np.bool_]] | None = None,
        repeated: Sequence[int] | None = None,
        time_unit: str = "s",
        epoch: str | None = None,
        notes: Sequence[str] = (),
    ) -> None:
        self.columns = columns
        """All rows, track by track."""
        self.tracks = tuple(tracks)
        """Names of the tracks, in the order in which they first appear."""
        self.starts = tuple(starts)
        """First row of each track, and the number of rows at the end."""
        self.states = tuple(states)
        """The states, in the order of their columns."""
        self.measurement_angles = {k: dict(v) for k, v in (measurement_angles or {}).items()}
        """Of each measurement type, which components are angles and their periods."""
        self.computed = dict(computed or {})
        """Which rows of a column were computed here instead of logged."""
        self.repeated = tuple(repeated or [0] * len(self.tracks))
        """How many repeated rows of each track were dropped."""
        self.time_unit = time_unit
        """Unit of the times."""
        self.epoch = epoch
        """Moment of time 0 in ISO 8601; None where the log does not say."""
        self.notes = tuple(notes)
        """What was recognised or left out while reading."""
        self.start_time = float(columns.time[list(self.starts[:-1])].min())
        """Time of the first update of any track."""

    @classmethod
    def from_parts(cls, parts: LogParts) -> "EstimatorLog":
        """A log from its normalised parts; for readers."""
        return cls(**{f.name: getattr(parts, f.name) for f in fields(parts)})

    @classmethod
    def from_columns(
        cls,
        *,
        states: Sequence[State | str] | None = None,
        state_dim: int | None = None,
        angles: Mapping[str | int, float] | None = None,
        measurement_angles: Mapping[str, Mapping[int, float]] | None = None,
        time_unit: str | None = None,
        date_order: str | None = None,
        covariance_forms: Mapping[str, str] | None = None,
        on_repeats: str = "drop",
        nis_scale: float = 1.0,
        **columns: Any,
    ) -> "EstimatorLog":
        """A log from columns of equal length, any subset that makes sense.

        Parameters
        ----------
        states
            The states, as names or :class:`State`; without it ``x[0]``, ``x[1]``, ...
        state_dim
            How many states, where no column tells (NEES alone).
        angles
            Periods of the states that are angles, by name or index: ``{"cog": 360.0}``.
        measurement_angles
            Periods of the components of ``z`` and ``innovation`` that are angles, by measurement
            type: ``{"radar": {1: 2 * math.pi}}``. With ``observed`` it follows from ``angles``.
        time_unit
            Unit of ``time``, seconds by default. Where it is not given, Unix times in milliseconds,
            microseconds or nanoseconds are recognised by their magnitude, and a note says so.
        date_order
            ``"dmy"`` or ``"mdy"``, for dates with slashes that could be either.
        covariance_forms
            How covariances given as lists are meant where their length does not tell:
            ``{"S": "diagonal"}``, ``"upper"`` (triangle row by row) or ``"full"``.
        on_repeats
            What to do with rows that are no updates (they repeat the row before to the bit, or
            their NIS is exactly 0 and no innovation is logged): ``"drop"`` and count them in the
            notes, ``"keep"``, or ``"raise"``.
        nis_scale
            Factor of the NIS: the gate, where the log has test ratios (NIS divided by a gate).
        **columns
            ``track`` (default: one track), ``time`` (numbers, dates or text; default: 0, 1, ... in
            each track),
            ``status`` (``"tentative"``, ``"active"`` or ``"rejected"``), ``measurement_type``,
            ``observed`` (the states that each component of the measurement observes, by name or
            index); of each row
            one number: ``nis``, ``nis_dof``, ``nees``, ``nees_dof``; a vector of the measurement:
            ``z``, ``innovation``; a vector of the state: ``x_pred``, ``x``, ``truth``, ``error``,
            ``std``; a matrix: ``S``, ``R``, ``P_pred``, ``P``, ``A`` (covariances also as the upper
            triangle), and ``H``, ``m x n``. Rows are in the order of time within each track; None
            or NaN is missing, a row or single components of it (of a matrix with their rows and
            columns).

        Returns
        -------
        EstimatorLog
            With NIS from ``innovation`` and ``S`` (and these from ``z``, ``x_pred``, ``P_pred``,
            ``R`` and ``observed``), errors from ``x`` and ``truth``, and NEES from errors and ``P``
            where absent, each over the components that there are, with so many degrees of freedom.

        Raises
        ------
        ValueError
            If there is no row; columns differ in length or a value in form; a time is not finite,
            falls; a state is unknown; a row holds nothing.
        numpy.linalg.LinAlgError
            If a covariance is not positive definite; names the row.

        Examples
        --------
        >>> EstimatorLog.from_columns(nis=[2.0, 1.5, 0.3], nis_dof=[2, 4, 2], nees=[4.0, 5.5, 3.9],
        ...                           state_dim=5)
        EstimatorLog(1 track, 3 updates, columns: nis, nis_dof, nees, nees_dof)
        """
        header = LogHeader(
            states,
            state_dim,
            angles,
            measurement_angles,
            time_unit,
            date_order=date_order,
            covariance_forms=covariance_forms,
            on_repeats=on_repeats,
            nis_scale=nis_scale,
        )
        return cls.from_parts(normalize(columns, header))

    @classmethod
    def from_frame(
        cls,
        frame: Any,
        *,
        columns: Renaming | None = None,
        **header: Unpack[HeaderArguments],
    ) -> "EstimatorLog":
        """A log from a data frame (pandas, Polars, PyArrow, ...; needs ``narwhals``).

        ``columns`` names the frame's columns where they differ from those of
        :meth:`from_columns`; a vector is a column of lists, or a list of columns:
        ``{"nis_dof": "df", "std": ["std_x", "std_y"]}``. The header is that of
        :meth:`from_columns`; ``time="row"`` takes the numbers of the rows in each track as times,
        where the frame has no column ``time``.
        """
        table, wanted = frames.read(frame), LogHeader(**header)
        chosen = check_selected(select_columns(table, columns or {}), table, wanted.time)
        parts = normalize(chosen, wanted)
        notes = notes_on_unused(table, chosen, columns or {})
        return cls.from_parts(replace(parts, notes=(*parts.notes, *notes)))

    @classmethod
    def from_filterpy(
        cls,
        savers: Any,
        *,
        truth: Any = None,
        times: Any = None,
        **header: Unpack[HeaderArguments],
    ) -> "EstimatorLog":
        """A log from a ``filterpy.common.Saver``, or from several by the names of their tracks.

        The saver is called once after each update. ``truth`` holds the true states, ``times`` the
        times, one for each epoch; with several savers, dictionaries of them by name. The header is
        that of :meth:`from_columns`.
        """
        table = filterpy.read(savers, truth, times)
        return cls.from_parts(normalize(table, LogHeader(**header)))

    @classmethod
    def from_stone_soup(
        cls,
        tracks: Any,
        *,
        truths: Mapping[Any, Any] | None = None,
        **header: Unpack[HeaderArguments],
    ) -> "EstimatorLog":
        """A log from Stone Soup's tracks, times in seconds since the first update.

        ``truths`` gives the ground truth path of a track, by the track or by its id; it is matched
        by time stamps. The header is that of :meth:`from_columns`.
        """
        return cls.from_parts(normalize(stone_soup.read(tracks, truths), LogHeader(**header)))

    def __getitem__(self, track: str) -> Columns:
        """The columns of one track."""
        if track not in self.tracks:
            raise KeyError(f"no track {track!r}; the log has {', '.join(map(repr, self.tracks))}")
        return self.columns.take(self.rows(self.tracks.index(track)))

    def __iter__(self) -> Iterator[str]:
        """The names of the tracks."""
        return iter(self.tracks)

    def __contains__(self, track: object) -> bool:
        """Whether there is a track of this name."""
        return track in self.tracks

    def __len__(self) -> int:
        """How many rows in all."""
        return len(self.columns)

    def rows(self, track: int) -> slice:
        """The rows of the track of this index."""
        return slice(self.starts[track], self.starts[track + 1])

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the states."""
        return tuple(state.name for state in self.states)

    def was_logged(self, column: str) -> NDArray[np.bool_]:
        """Which rows of a column hold a value that was read, not computed here."""
        values = getattr(self.columns, column)
        if values is None:
            return np.zeros(len(self), bool)
        return has_value(values) & ~self.computed.get(column, np.zeros(len(self), bool))

    def write(self, path: str | Path) -> None:
        """Write the log to a file for :func:`read_log`; its ending says in which form.

        ``.jsonl`` (JSON Lines), ``.csv`` or ``.parquet`` (needs Polars, the extra ``files``).
        """
        path = Path(path)
        form = formats.to_write(path)
        header = to_record(self.states, self.measurement_angles, self.time_unit, self.epoch)
        form.write(path, header, self._table())

    def to_frame(self, library: str = "polars") -> Any:
        """What was logged as a data frame of ``"polars"``, ``"pandas"`` or ``"pyarrow"``.

        A row per update. Vectors and matrices are lists, in pandas a column for each element
        (``x[0]``, ``x[1]``, ...), covariances as their upper triangles. :meth:`from_frame` takes it
        back with ``covariance_forms={"P": "upper", ...}`` where a covariance stands alone.
        """
        return frames.write(self._table(), library)

    def _table(self) -> dict[str, Any]:
        """What was logged, as files hold it."""
        logged = {
            name: self.was_logged(name)
            for name in NUMERIC_COLUMNS
            if getattr(self.columns, name) is not None
        }
        return to_table(self.columns, self.tracks, self.starts, logged)

    def shifted(self, seconds: float) -> "EstimatorLog":
        """The same log with every time later by ``seconds``."""
        columns = self.columns.replace(time=self.columns.time + seconds)
        return EstimatorLog(
            columns,
            self.tracks,
            self.starts,
            self.states,
            self.measurement_angles,
            self.computed,
            self.repeated,
            self.time_unit,
            self.epoch,
            self.notes,
        )

    def __repr__(self) -> str:
        """Its size and columns."""
        names = ", ".join(
            name for name in NUMERIC_COLUMNS if getattr(self.columns, name) is not None
        )
        tracks = f"{len(self.tracks)} track{'s' if len(self.tracks) != 1 else ''}"
        return f"EstimatorLog({tracks}, {len(self)} updates, columns: {names})"
