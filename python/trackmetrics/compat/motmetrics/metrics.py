"""py-motmetrics' host of metrics: registration, dependencies, tables of sequences."""

import inspect
from collections import OrderedDict
from collections.abc import Callable, Sequence
from typing import Any

from trackmetrics._tables.data_frames import pandas
from trackmetrics.compat.motmetrics._definitions import (
    MERGES,
    METRICS,
    id_global_assignment,
    idf1,
    idfn,
    idfp,
    idp,
    idr,
    idtp,
    mostly_lost,
    mostly_tracked,
    mota,
    motp,
    motp_m,
    num_ascend,
    num_detections,
    num_false_positives,
    num_fragmentations,
    num_frames,
    num_matches,
    num_migrate,
    num_misses,
    num_objects,
    num_predictions,
    num_switches,
    num_transfer,
    num_unique_objects,
    obj_frequencies,
    partially_tracked,
    precision,
    pred_frequencies,
    recall,
    track_ratios,
)
from trackmetrics.compat.motmetrics._frame_map import DataFrameMap, events_to_df_map
from trackmetrics.compat.motmetrics._identity import extract_counts_from_df_map
from trackmetrics.compat.motmetrics.mot import MOTAccumulator

__all__ = [
    "DataFrameMap",
    "MetricsHost",
    "create",
    "events_to_df_map",
    "extract_counts_from_df_map",
    "id_global_assignment",
    "idf1",
    "idfn",
    "idfp",
    "idp",
    "idr",
    "idtp",
    "mostly_lost",
    "mostly_tracked",
    "mota",
    "motchallenge_metrics",
    "motp",
    "motp_m",
    "num_ascend",
    "num_detections",
    "num_false_positives",
    "num_fragmentations",
    "num_frames",
    "num_matches",
    "num_migrate",
    "num_misses",
    "num_objects",
    "num_predictions",
    "num_switches",
    "num_transfer",
    "num_unique_objects",
    "obj_frequencies",
    "partially_tracked",
    "precision",
    "pred_frequencies",
    "recall",
    "track_ratios",
]

motchallenge_metrics = [
    *("idf1", "idp", "idr", "recall", "precision", "num_unique_objects", "mostly_tracked"),
    *("partially_tracked", "mostly_lost", "num_false_positives", "num_misses", "num_switches"),
    *("num_fragmentations", "mota", "motp", "num_transfer", "num_ascend", "num_migrate"),
]
"""The metrics of MOTChallenge, in its order."""


class MetricsHost:
    """Metrics by name, each a function of the events and of other metrics."""

    def __init__(self) -> None:
        self.metrics: OrderedDict[str, dict[str, Any]] = OrderedDict()

    def register(
        self,
        fnc: Callable[..., Any],
        deps: str | Sequence[str] | None = "auto",
        name: str | None = None,
        helpstr: str | None = None,
        formatter: Callable[[Any], str] | None = None,
        fnc_m: Callable[..., Any] | None = None,
        deps_m: str | Sequence[str] | None = "auto",
    ) -> None:
        """Add a metric.

        Parameters
        ----------
        fnc : callable
            Takes a :class:`DataFrameMap` and the metrics that it depends on.
        deps : "auto" or list of str, optional
            Those metrics; by default the names of the function's arguments.
        name : str, optional
            By default the function's.
        helpstr : str, optional
            By default the function's docstring.
        formatter : callable, optional
            Makes text of a value.
        fnc_m : callable, optional
            Takes the results of several sequences and the merged metrics that it depends on; by
            default what merges the metric of that name here.
        deps_m : "auto" or list of str, optional
            Those metrics.

        Raises
        ------
        AssertionError
            Where ``fnc`` is None (py-motmetrics' type of error).
        """
        if fnc is None:
            raise AssertionError(f"fnc must be a function, got None for the metric {name}")
        name = name or fnc.__name__
        merge = fnc_m or MERGES.get(name)
        doc = inspect.getdoc(fnc) or "No description."
        self.metrics[name] = {
            "name": name,
            "fnc": fnc,
            "fnc_m": merge,
            "deps": _dependencies(fnc, deps),
            "deps_m": _dependencies(merge, deps_m) if merge else None,
            "help": " ".join(doc.split()) if helpstr is None else helpstr,
            "formatter": formatter,
        }

    @property
    def names(self) -> list[str]:
        """Names of the metrics."""
        return list(self.metrics)

    @property
    def formatters(self) -> dict[str, Callable[[Any], str]]:
        """What makes text of the metrics that have it."""
        formats = {name: entry["formatter"] for name, entry in self.metrics.items()}
        return {name: function for name, function in formats.items() if function is not None}

    def list_metrics(self, include_deps: bool = False) -> Any:
        """A table of names, descriptions and, if wanted, dependencies."""
        keys = {"Name": "name", "Description": "help", "Dependencies": "deps"}
        if not include_deps:
            del keys["Dependencies"]
        rows = [[entry[key] for key in keys.values()] for entry in self.metrics.values()]
        return pandas().DataFrame(rows, columns=list(keys))

    def list_metrics_markdown(self, include_deps: bool = False) -> Any:
        """:meth:`list_metrics` as a table in Markdown."""
        table = self.list_metrics(include_deps=include_deps)
        rule = pandas().DataFrame([[":---"] * len(table.columns)], columns=table.columns)
        return pandas().concat([rule, table]).to_csv(sep="|", index=False)

    def compute(
        self,
        df: Any,
        ana: Any = None,
        metrics: str | Sequence[str] | None = None,
        return_dataframe: bool = True,
        return_cached: bool = False,
        name: Any = None,
    ) -> Any:
        """Metrics of a sequence.

        Parameters
        ----------
        df : MOTAccumulator or DataFrame
            Its events.
        ana
            Passed to metrics with default arguments.
        metrics : str or list of str, optional
            Names; by default ``motchallenge_metrics``.
        return_dataframe : bool
            Whether the result is a frame with one row, or a dict.
        return_cached : bool
            Whether the metrics that others depend on are returned as well.
        name : optional
            The row's name.

        Raises
        ------
        AssertionError
            Where a metric is not registered (py-motmetrics' type of error).
        """
        events = df.events if isinstance(df, MOTAccumulator) else df
        df_map, cache = events_to_df_map(events), dict[str, Any]()
        names = _names(metrics)

        def value(entry: dict[str, Any], values: list[Any]) -> Any:
            options = {} if inspect.getfullargspec(entry["fnc"]).defaults is None else {"ana": ana}
            return entry["fnc"](df_map, *values, **options)

        for metric in names:
            self._resolve(metric, "deps", value, cache, "summarize")
        return _result(cache if return_cached else _chosen(cache, names), name, return_dataframe)

    def compute_overall(
        self,
        partials: Sequence[Any],
        metrics: str | Sequence[str] | None = None,
        return_dataframe: bool = True,
        return_cached: bool = False,
        name: Any = None,
    ) -> Any:
        """Metrics over several sequences, from each one's dict of results.

        Parameters are as in :meth:`compute`.
        """
        cache: dict[str, Any] = {}
        names = _names(metrics)

        def value(entry: dict[str, Any], values: list[Any]) -> Any:
            if entry["fnc_m"] is None:
                raise AssertionError(f"the metric {entry['name']} has no function fnc_m")
            return entry["fnc_m"](partials, *values)

        for metric in names:
            self._resolve(metric, "deps_m", value, cache, "summarize")
        return _result(cache if return_cached else _chosen(cache, names), name, return_dataframe)

    def compute_many(
        self,
        dfs: Sequence[Any],
        anas: Sequence[Any] | None = None,
        metrics: str | Sequence[str] | None = None,
        names: Sequence[Any] | None = None,
        generate_overall: bool = False,
    ) -> Any:
        """A table with one row for each sequence and, if wanted, a row OVERALL.

        Parameters
        ----------
        dfs : list of MOTAccumulator or DataFrame
            The sequences.
        anas : list, optional
            As in :meth:`compute`, for each sequence.
        metrics : str or list of str, optional
            Names; by default ``motchallenge_metrics``.
        names : list, optional
            The rows' names.
        generate_overall : bool
            Whether to add the row OVERALL.

        Raises
        ------
        AssertionError
            Where ``names`` and ``dfs`` differ in length (py-motmetrics' type of error).
        """
        if names is not None and len(names) != len(dfs):
            raise AssertionError(f"names has {len(names)} elements, dfs has {len(dfs)}")
        rows = list(range(len(dfs))) if names is None else list(names)
        anas = [None] * len(dfs) if anas is None else anas
        details = [
            self.compute(df, ana=ana, metrics=metrics, return_dataframe=False, return_cached=True)
            for df, ana in zip(dfs, anas, strict=True)
        ]
        tables = [
            _result(_chosen(cache, _names(metrics)), name, True)
            for cache, name in zip(details, rows, strict=True)
        ]
        if generate_overall:
            tables.append(self.compute_overall(details, metrics=metrics, name="OVERALL"))
        return pandas().concat(tables)

    def _resolve(
        self, name: str, kind: str, value: Callable[..., Any], cache: dict[str, Any], parent: str
    ) -> Any:
        """A metric's value, after those that it depends on."""
        if cache.get(name) is not None:
            return cache[name]
        if name not in self.metrics:
            raise AssertionError(f"no metric {name} is registered, {parent} needs it")
        entry = self.metrics[name]
        needed = entry[kind] or ()
        values = [self._resolve(one, kind, value, cache, name) for one in needed]
        cache[name] = value(entry, values)
        return cache[name]


def _dependencies(function: Any, deps: str | Sequence[str] | None) -> Any:
    if deps is None:
        return []
    if deps != "auto":
        return deps
    arguments = inspect.getfullargspec(function)
    return arguments.args[1 : len(arguments.args) - len(arguments.defaults or ())]


def _names(metrics: str | Sequence[str] | None) -> Sequence[str]:
    if metrics is None:
        return motchallenge_metrics
    return [metrics] if isinstance(metrics, str) else metrics


def _chosen(cache: dict[str, Any], names: Sequence[str]) -> Any:
    return OrderedDict((name, cache[name]) for name in names)


def _result(data: Any, name: Any, as_frame: bool) -> Any:
    return pandas().DataFrame(data, index=[0 if name is None else name]) if as_frame else data


def create() -> MetricsHost:
    """A host of every metric of py-motmetrics."""
    host = MetricsHost()
    for function, text in METRICS.items():
        host.register(function, formatter=text.format if text else None)
    return host
