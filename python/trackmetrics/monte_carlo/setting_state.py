"""What is known of one setting: its accumulators, the runs that are done, and those that failed."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

from trackmetrics.monte_carlo import serialization
from trackmetrics.monte_carlo.accumulators.base import Accumulator
from trackmetrics.monte_carlo.run_tree import MAX_RUNS, RunTree, dyadic_blocks, first_overlap
from trackmetrics.results import Result

_KIND = "Tally"
"""What the bytes are called: the name of the first release, whose checkpoints are read."""


@dataclass(frozen=True)
class Failure(Result):
    """A run that raised an exception."""

    run: int
    """Its number."""
    settings: dict[str, Any]
    """What it was called with."""
    error: str
    """The exception and its message, in one line."""
    traceback: str
    """Where it was raised; empty where a worker process died, or where the result of the run did
    not fit those of earlier runs."""


class RunMismatchError(ValueError):
    """Runs that gave other results than the runs before them: other names, or other shapes."""


class SettingState:
    """Accumulators by name, all over the same runs."""

    def __init__(self) -> None:
        self.accumulators: dict[str, Accumulator] = {}
        self.failures: dict[int, tuple[str, str]] = {}
        self._covered = RunTree()

    @property
    def intervals(self) -> list[tuple[int, int]]:
        """The runs that are done, as intervals."""
        return self._covered.intervals()

    def __len__(self) -> int:
        """How many runs are done."""
        return len(self._covered)

    def fail(self, run: int, error: str, traceback: str) -> None:
        """Records a run that failed."""
        self.failures[run] = (error, traceback)
        for accumulator in self.accumulators.values():
            accumulator.add_empty_runs(run)
        self._mark_done(run, run + 1)

    def add(self, name: str, accumulator: Accumulator, first: int, stop: int) -> None:
        """Adds an accumulator of the runs ``first .. stop``; after all of them ``mark_done``."""
        known = self.accumulators.get(name)
        if known is None:
            known = self._new_accumulator(accumulator)
        known.merge(accumulator)
        self.accumulators[name] = known

    def mark_done(self, first: int, stop: int) -> None:
        """Says that these runs are done, in every accumulator."""
        for name, accumulator in self.accumulators.items():
            if accumulator.intervals != _joined(self._covered, first, stop):
                raise ValueError(f"the runs {first}..{stop} gave no {name!r}, earlier runs did")
        self._mark_done(first, stop)

    def merge(self, other: "SettingState") -> None:
        """Adds other runs of the same setting."""
        self._require_mergeable(other)
        for name in self.accumulators.keys() | other.accumulators.keys():
            if name not in other.accumulators:
                _skip_all(self.accumulators[name], other)
            else:
                known = self.accumulators.get(name)
                if known is None:
                    known = self.accumulators[name] = self._new_accumulator(
                        other.accumulators[name]
                    )
                known.merge(other.accumulators[name])
        self.failures |= other.failures
        self._covered.merge(other._covered)

    def _require_mergeable(self, other: "SettingState") -> None:
        """Raise before anything is changed."""
        if overlap := first_overlap(self._covered, other._covered):
            raise ValueError(f"the runs {overlap[0]}..{overlap[1]} are in both")
        if (
            self.accumulators
            and other.accumulators
            and self.accumulators.keys() != other.accumulators.keys()
        ):
            ours, theirs = sorted(self.accumulators), sorted(other.accumulators)
            raise RunMismatchError(
                f"these runs gave {', '.join(theirs)}, earlier runs gave {', '.join(ours)}"
            )
        for name in self.accumulators.keys() & other.accumulators.keys():
            try:
                self.accumulators[name].require_mergeable(other.accumulators[name])
            except (TypeError, ValueError) as error:
                raise RunMismatchError(f"{name}: {error}") from None

    def _new_accumulator(self, like: Accumulator) -> Accumulator:
        """An accumulator for runs of which those so far gave nothing."""
        opened = like.empty_copy()
        _skip_all(opened, self)
        return opened

    def _mark_done(self, first: int, stop: int) -> None:
        for start, level in dyadic_blocks(first, stop):
            self._covered.add(start, level, None)

    def to_bytes(self) -> bytes:
        """Everything as bytes: the same for the same runs, however they were cut."""
        names = sorted(self.accumulators)
        parts = [self.accumulators[name].to_bytes() for name in names]
        kinds = (self.accumulators[name].kind for name in names)
        header = {
            "cells": [[n, k, len(p)] for n, k, p in zip(names, kinds, parts, strict=True)],
            "failures": [[run, *self.failures[run]] for run in sorted(self.failures)],
            "covered": self.intervals,
        }
        return serialization.encode(_KIND, header, b"".join(parts))

    @classmethod
    def from_bytes(cls, data: bytes) -> Self:
        """What ``to_bytes`` was called on."""
        header, body = serialization.decode(data, _KIND)
        made, place = cls(), 0
        kinds = accumulator_kinds()
        with serialization.refusing_malformed():
            for name, kind, size in header["cells"]:
                if kind not in kinds or name in made.accumulators:
                    raise ValueError(f"accumulator {name!r} of kind {kind!r}")
                if not 0 <= serialization.whole(size) <= len(body) - place:
                    raise ValueError(f"accumulator {name!r} of {size} bytes")
                made.accumulators[str(name)] = kinds[kind].from_bytes(body[place : place + size])
                place += size
            for run, error, text in header["failures"]:
                made.failures[serialization.whole(run)] = (str(error), str(text))
            made._read_covered(header["covered"])
        return made

    def _read_covered(self, intervals: list[list[int]]) -> None:
        end = 0
        for first, stop in intervals:
            if not end <= serialization.whole(first) < serialization.whole(stop) <= MAX_RUNS:
                raise ValueError(f"runs {first}..{stop}")
            self._mark_done(first, stop)
            end = stop
        for name, accumulator in self.accumulators.items():
            if accumulator.intervals != self.intervals:
                raise ValueError(f"accumulator {name!r} has other runs")


def accumulator_kinds() -> Mapping[str, type[Accumulator]]:
    """Every accumulator by its kind."""
    found: dict[str, type[Accumulator]] = {}
    open_kinds: list[Any] = [Accumulator]
    while open_kinds:
        for kind in open_kinds.pop().__subclasses__():
            found[kind.kind] = kind
            open_kinds.append(kind)
    return found


def _skip_all(accumulator: Accumulator, state: SettingState) -> None:
    for first, stop in state.intervals:
        accumulator.add_empty_runs(first, stop - first)


def _joined(covered: RunTree, first: int, stop: int) -> list[tuple[int, int]]:
    joined = RunTree()
    joined.merge(covered)
    for start, level in dyadic_blocks(first, stop):
        joined.add(start, level, None)
    return joined.intervals()
