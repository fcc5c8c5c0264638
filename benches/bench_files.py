"""Logs and MOTChallenge files of a million rows: seconds, and memory beside the data's own.

Every row runs in a process of its own, so that its peak of memory is its own as well. What is read
is compared with what was written, to the bit, before the time counts.
"""

import json
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

ROWS, TRACKS, STATES = 1_000_000, 1000, 5
TARGETS = {"parquet": 2.0, "csv": 5.0, "jsonl": 8.0, "mot": 1.0}
MAX_OVER = 1000.0
"""Memory wanted at most beside the data's own, in megabytes."""
COLUMNS = ("time", "x", "P", "truth", "innovation", "S")


def columns() -> dict[str, np.ndarray]:
    """A log with everything that a filter of five states can say, covariances not diagonal."""
    rng = np.random.default_rng(0)
    x = rng.normal(size=(ROWS, STATES))
    return {
        "track": np.repeat(np.array([f"track {i}" for i in range(TRACKS)], object), ROWS // TRACKS),
        "time": np.tile(np.arange(ROWS // TRACKS) * 0.1, TRACKS),
        "x": x,
        "P": covariances(rng, STATES),
        "truth": x + rng.normal(size=(ROWS, STATES)),
        "innovation": rng.normal(size=(ROWS, 2)),
        "S": covariances(rng, 2),
    }


def covariances(rng: np.random.Generator, n: int) -> np.ndarray:
    root = rng.normal(size=(ROWS, n, n)) * 0.1
    return root @ root.swapaxes(1, 2) + np.eye(n)


def mot_file(path: Path) -> None:
    frames, ids = np.divmod(np.arange(ROWS), 100)
    rng = np.random.default_rng(0)
    boxes = rng.uniform(0, 1000, (ROWS, 4)).round(2)
    rows = zip(frames + 1, ids + 1, *boxes.T, strict=True)
    path.write_text("".join(f"{f},{i},{a},{b},{w},{h},1,-1,-1,-1\n" for f, i, a, b, w, h in rows))


def write(path: Path) -> dict[str, float]:
    from trackmetrics.logs import EstimatorLog

    log = EstimatorLog.from_columns(**columns())
    _, seconds, peak = watched(lambda: log.write(path))
    return {"seconds": seconds, "over": peak}


def read(path: Path) -> dict[str, float]:
    from trackmetrics.logs import read_log

    log, seconds, peak = watched(lambda: read_log(path))
    own = sum(v.nbytes for v in vars(log.columns).values() if isinstance(v, np.ndarray)) / 1e6
    given = columns()
    for name in COLUMNS:
        np.testing.assert_array_equal(getattr(log.columns, name), given[name], name)
    return {"seconds": seconds, "over": peak - own}


def read_mot(path: Path) -> dict[str, float]:
    from trackmetrics.tracks import read_mot_challenge

    found, seconds, peak = watched(lambda: read_mot_challenge(path))
    assert len(found) == ROWS
    assert found.targets == 100
    own = (found.frames.nbytes + found.ids.nbytes + found.boxes.nbytes) / 1e6
    return {"seconds": seconds, "over": peak - own}


def watched(call: Callable[[], Any]) -> tuple[Any, float, float]:
    """What a call gives, its seconds, and the most memory that it held at once, in megabytes."""
    import polars  # noqa: F401 - imported once, not with every file

    Path("/proc/self/clear_refs").write_text("5")  # the peak is what is held now
    before, start = memory("VmRSS"), time.perf_counter()
    found = call()
    return found, time.perf_counter() - start, memory("VmHWM") - before


def memory(field: str) -> float:
    """A size of this process that Linux keeps, in megabytes."""
    status = Path("/proc/self/status").read_text()
    return int(re.search(rf"{field}:\s+(\d+)", status).group(1)) / 1e3


WORK = {"write": write, "read": read, "read_mot": read_mot}


def in_new_process(what: str, path: Path) -> dict[str, float]:
    call = [sys.executable, __file__, "--row", what, str(path)]
    return json.loads(subprocess.run(call, check=True, capture_output=True, text=True).stdout)


def main() -> None:
    import trackmetrics
    from harness import Bench

    bench = Bench("files")
    trackmetrics.set_threads(0)  # as many as the machine has, as in the processes of the rows
    with tempfile.TemporaryDirectory() as folder:
        for kind, target in TARGETS.items():
            path = Path(folder) / f"log.{kind}"
            if kind == "mot":
                mot_file(path)
            for what in ("read_mot",) if kind == "mot" else ("write", "read"):
                runs = [in_new_process(what, path) for _ in range(3)]
                best = min(runs, key=lambda run: run["seconds"])
                size = path.stat().st_size / 1e6
                name = f"{kind}, {what.partition('_')[0]}"
                bench.report(f"{name}, 1e6 rows, {size:.0f} MB", best["seconds"], "s", target)
                bench.report(f"{name}, memory over the data's", best["over"], "MB", MAX_OVER)
            path.unlink()
    bench.finish()


if __name__ == "__main__":
    if "--row" in sys.argv:
        print(json.dumps(WORK[sys.argv[2]](Path(sys.argv[3]))))
    else:
        main()
