"""The ships of the demo: simulated, tracked, diagnosed, on one page."""

import argparse
import time

from trackmetrics.cli._output import print_verdicts, write_html
from trackmetrics.diagnostics import diagnose
from trackmetrics.vessel import three_ships


def run(arguments: argparse.Namespace) -> int:
    """Simulate, track, diagnose; print the verdicts and write the page."""
    start = time.perf_counter()
    simulation = three_ships(arguments.seed, arguments.noise)
    log = simulation.track()
    diagnosis = diagnose(log)
    seconds = time.perf_counter() - start
    print(
        f"three ships, {len(log)} updates, {arguments.noise} noise, seed {arguments.seed}: "
        f"simulated, tracked and diagnosed in {seconds:.2f} s\n"
    )
    print_verdicts(diagnosis)
    page = arguments.html
    if page is None and not _can_write_pages():
        print("\nno page: it needs the extra report (pip install 'trackmetrics[report]')")
    elif page != "":
        write_html(page or "demo.html", diagnosis, log, "Three ships")
    return 0


def _can_write_pages() -> bool:
    """Whether what the page is made with is installed."""
    from importlib.util import find_spec

    return all(find_spec(name) for name in ("jinja2", "plotly", "matplotlib"))
