"""Old public names: where each is now, and the warning that says so.

One table, read by the modules that the names have left. An old name keeps working and warns once
per call site; it is removed in the second minor release after the one that renamed it.
"""

import functools
import warnings
from collections.abc import Callable
from importlib import import_module
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])
C = TypeVar("C", bound=type)

RENAMED: dict[str, str] = {
    "trackmetrics.Whiteness": "trackmetrics.WhitenessTest",
    "trackmetrics.consistency.Whiteness": "trackmetrics.consistency.WhitenessTest",
    "trackmetrics.diagnostics.EstimatorLog": "trackmetrics.logs.EstimatorLog",
    "trackmetrics.diagnostics.Whiteness": "trackmetrics.diagnostics.InnovationCorrelation",
    "trackmetrics.diagnostics.State": "trackmetrics.logs.State",
    "trackmetrics.diagnostics.read_log": "trackmetrics.logs.read_log",
    "trackmetrics.io.Boxes": "trackmetrics.tracks.Boxes",
    "trackmetrics.io.read_mot_challenge": "trackmetrics.tracks.read_mot_challenge",
    "trackmetrics.io.mot_challenge.Boxes": "trackmetrics.tracks.Boxes",
    "trackmetrics.io.mot_challenge.read_mot_challenge": "trackmetrics.tracks.read_mot_challenge",
    "trackmetrics.monte_carlo.Best": "trackmetrics.monte_carlo.BestSetting",
    "trackmetrics.monte_carlo.FormStatistics": "trackmetrics.monte_carlo.ErrorStatistics",
    "trackmetrics.report.heat_figure": "trackmetrics.report.heatmap_figure",
    "trackmetrics.report.page": "trackmetrics.report.render_page",
    "trackmetrics.report.sweeps.heat_figure": "trackmetrics.report.heatmap_figure",
    "trackmetrics.report.sweeps.sweep_figure": "trackmetrics.report.sweep_figure",
    "trackmetrics.vessel.HeldOut": "trackmetrics.vessel.HeldOutResult",
    "trackmetrics.vessel.KINDS": "trackmetrics.vessel.REPORT_TYPES",
    "trackmetrics.vessel.SetAside": "trackmetrics.vessel.RejectedRow",
    "trackmetrics.vessel.decimated": "trackmetrics.vessel.thin",
    "trackmetrics.vessel.screen": "trackmetrics.vessel.screen_rows",
}
"""Old name: new name, both in full."""

RENAMED_NOISE = {"honest": "consistent", "article": "published"}
"""Old and new values of the argument ``noise`` of ``vessel.three_ships``."""


def warn(old: str, new: str, stacklevel: int = 3) -> None:
    """Say that ``old`` is now called ``new``."""
    warnings.warn(f"{old} is now {new}", DeprecationWarning, stacklevel=stacklevel)


def module_getattr(module: str) -> Callable[[str], Any]:
    """The ``__getattr__`` of a module that names have left: finds them where they are now."""
    moved = {
        old.rpartition(".")[2]: new
        for old, new in RENAMED.items()
        if old.rpartition(".")[0] == module
    }

    def __getattr__(name: str) -> Any:  # noqa: N807 - it becomes the module's
        if name not in moved:
            raise AttributeError(f"module {module!r} has no attribute {name!r}")
        new = moved[name]
        warn(f"{module}.{name}", new)
        place, _, attribute = new.rpartition(".")
        return getattr(import_module(place), attribute)

    return __getattr__


def parameters(**renamed: str) -> Callable[[F], F]:
    """Let a function take keyword arguments by their old names: ``parameters(level="alpha")``."""

    def decorate(function: F) -> F:
        @functools.wraps(function)
        def wrapper(*args: Any, **kwargs: Any) -> Any:
            for old, new in renamed.items():
                if old in kwargs:
                    *owner, name = function.__qualname__.split(".")
                    name = owner[-1] if name in ("__init__", "__new__") else name
                    if new in kwargs:
                        raise TypeError(f"{name}() got both {new!r} and {old!r}, its old name")
                    warn(f"{name}({old}=)", f"{name}({new}=)")
                    kwargs[new] = kwargs.pop(old)
            return function(*args, **kwargs)

        return wrapper  # type: ignore[return-value]

    return decorate


def parameters_of_class(**renamed: str) -> Callable[[C], C]:
    """The same for the arguments of a class: ``parameters_of_class(gate="gate_probability")``."""

    def decorate(cls: C) -> C:
        cls.__init__ = parameters(**renamed)(cls.__init__)  # type: ignore[misc]
        return cls

    return decorate


def attribute(new: str) -> Any:
    """A property for the old name of an attribute or method, to stand in a class body."""

    class Renamed:
        def __set_name__(self, owner: type, name: str) -> None:
            self.name, self.owner = name, owner.__name__
            self.__doc__ = f"Old name of ``{new}``."

        def __get__(self, instance: Any, owner: type | None = None) -> Any:
            if instance is None:
                return self
            warn(f"{self.owner}.{self.name}", f"{self.owner}.{new}")
            return getattr(instance, new)

    return Renamed()
