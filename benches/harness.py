"""What every bench shares: interleaved timing in one process, ratios of medians, the machine.

A bench asserts the answer before it times it, times our function and its peers in turn (so that a
change of the machine's speed meets all of them), and reports the ratio of the medians.

    python benches/bench_point_sets.py            # prints a table
    python benches/bench_point_sets.py --save     # and writes benches/results/point_sets.json
"""

import argparse
import json
import os
import platform
import statistics
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from datetime import date
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import trackmetrics
from trackmetrics import _native

RESULTS = Path(__file__).parent / "results"
_SLOWING = ("OPENBLAS_CORETYPE", "OPENBLAS_L2_SIZE")


@dataclass
class Row:
    """One comparison, in seconds a call."""

    what: str
    peer: str
    ours: float
    theirs: float
    ratio: float
    target: float | None
    """The least ratio wanted, where there is one."""


class Bench:
    """The rows of one bench, and what becomes of them."""

    def __init__(self, name: str) -> None:
        parser = argparse.ArgumentParser(description=f"bench {name}")
        parser.add_argument("--save", action="store_true", help="write benches/results/NAME.json")
        parser.add_argument("--simd", choices=["scalar", "avx2", "widest"], default="widest")
        parser.add_argument("--threads", type=int, default=1)
        parser.add_argument("--only", default="", help="only rows whose name contains this")
        self.options = parser.parse_args()
        self.name = name
        self.rows: list[Row] = []
        _without_slow_blas()
        _native.set_simd(self.options.simd)
        trackmetrics.set_threads(self.options.threads)
        print(f"{name}: {_native.simd()}, {trackmetrics.threads()} thread(s), {cpu()}")

    def compare(
        self,
        what: str,
        ours: Callable[[], object],
        peers: Mapping[str, Callable[[], object]],
        target: float | Mapping[str, float] | None = None,
        seconds: float = 2.0,
        rounds: int = 15,
    ) -> None:
        """Times ``ours`` and every peer in turn; ``target`` is the least ratio wanted."""
        if self.options.only not in what:
            return
        medians = interleave({"": ours, **peers}, seconds, rounds)
        for peer in peers:
            wanted = target.get(peer) if isinstance(target, Mapping) else target
            row = Row(what, peer, medians[""], medians[peer], medians[peer] / medians[""], wanted)
            self.rows.append(row)
            print(_line(row))

    def report(self, what: str, value: float, unit: str, target: float | None = None) -> None:
        """Adds a figure that is not a ratio of two calls (``unit`` stands where the peer does)."""
        if self.options.only not in what:
            return
        self.rows.append(Row(what, unit, value, value, value, target))
        print(f"  {what:52} {value:10.3f}  {unit}")

    def finish(self) -> None:
        """Writes the rows where ``--save`` asks for it."""
        if not self.options.save:
            return
        RESULTS.mkdir(exist_ok=True)
        suffix = "" if self.options.simd == "widest" else f"-{self.options.simd}"
        suffix += "" if self.options.threads == 1 else f"-{self.options.threads}threads"
        path = RESULTS / f"{self.name}{suffix}.json"
        content = {"machine": machine(), "rows": [asdict(row) for row in self.rows]}
        path.write_text(json.dumps(content, indent=1) + "\n")


def interleave(
    calls: Mapping[str, Callable[[], object]], seconds: float, rounds: int
) -> dict[str, float]:
    """Median seconds of each call; every round runs all of them, each as often as fits."""
    slot = seconds / rounds / len(calls)
    loops = {name: max(1, int(slot / _once(call))) for name, call in calls.items()}
    times: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(rounds):
        for name, call in calls.items():
            times[name].append(_repeat(call, loops[name]))
    return {name: statistics.median(values) for name, values in times.items()}


def _once(call: Callable[[], object]) -> float:
    call()
    return max(_repeat(call, 1), 1e-7)


def _repeat(call: Callable[[], object], loops: int) -> float:
    start = time.perf_counter()
    for _ in range(loops):
        call()
    return (time.perf_counter() - start) / loops


def machine() -> dict[str, object]:
    """Where and with what the figures were measured."""
    packages = [
        "numpy",
        "scipy",
        "nrl-tracker",
        "lapx",
        "stonesoup",
        "motmetrics",
        "motrics",
        "trackeval",
        "filterpy",
    ]
    return {
        "date": date.today().isoformat(),
        "cpu": cpu(),
        "cores": os.cpu_count(),
        "simd": _native.simd(),
        "threads": trackmetrics.threads(),
        "python": platform.python_version(),
        "trackmetrics": trackmetrics.__version__,
        **{name: found for name in packages if (found := _version(name))},
    }


def cpu() -> str:
    """The processor's own name for itself."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    return next((x.partition(":")[2].strip() for x in lines if x.startswith("model name")), "")


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _without_slow_blas() -> None:
    """These variables choose older, slower kernels for NumPy: they would flatter us."""
    if any(name in os.environ for name in _SLOWING):
        for name in _SLOWING:
            os.environ.pop(name, None)
        os.execv(sys.executable, [sys.executable, *sys.argv])


def _line(row: Row) -> str:
    verdict = "" if row.target is None else f"  (at least {row.target:g}x)"
    verdict += "" if row.target is None or row.ratio >= row.target else "  SHORT"
    return f"  {row.what:52} {_time(row.ours)}  {row.ratio:9.1f}x {row.peer}{verdict}"


def _time(seconds: float) -> str:
    for unit, size in (("s ", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:8.2f} {unit}"
    return f"{seconds / 1e-9:8.1f} ns"
