"""The three ships of the demo: simulated, tracked, diagnosed, on one page."""

import time

from trackmetrics.cli._output import Output, write_diagnosis_page
from trackmetrics.cli._verdicts import diagnosis_table, most_severe
from trackmetrics.diagnostics import diagnose
from trackmetrics.vessel import three_ships


def run_ships(output: Output, noise: str, page: str | None, seed: int) -> None:
    """Simulate, track, diagnose; print the verdicts and write the page."""
    start = time.perf_counter()
    simulation = three_ships(seed, noise)
    log = simulation.track()
    diagnosis = diagnose(log)
    seconds = time.perf_counter() - start
    output.message(
        f"three ships, {len(log)} updates, {noise} noise, seed {seed}: "
        f"simulated, tracked and diagnosed in {seconds:.2f} s"
    )
    output.write(diagnosis_table(diagnosis), content=diagnosis, after=most_severe(diagnosis))
    if page is None and not _can_write_pages():
        output.message("no page: it needs the extra report (pip install 'trackmetrics[report]')")
    elif page != "":
        write_diagnosis_page(output, page or "demo.html", diagnosis, log, title="Three ships")


def _can_write_pages() -> bool:
    """Whether the libraries of the page are installed."""
    from importlib.util import find_spec

    return all(find_spec(name) for name in ("jinja2", "plotly", "matplotlib"))
