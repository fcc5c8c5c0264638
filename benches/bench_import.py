"""How long a process takes to import us, NumPy alone, and pytcl's module."""

import subprocess
import sys

from harness import Bench


def start(module: str):
    """A fresh interpreter that imports ``module`` and ends."""
    return lambda: subprocess.run([sys.executable, "-c", f"import {module}"], check=True)


if __name__ == "__main__":
    bench = Bench("import")
    bench.compare(
        "import trackmetrics",
        start("trackmetrics"),
        {"numpy": start("numpy"), "pytcl": start("pytcl.performance_evaluation")},
        target={"numpy": 1 / 1.5, "pytcl": 8.0},
        seconds=20.0,
    )
    bench.finish()
