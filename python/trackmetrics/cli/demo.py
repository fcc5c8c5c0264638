"""``trackmetrics demo``: three ships and their filter, or a multi-target scene and its scores."""

import click

from trackmetrics.cli._output import Command, Output, output_options


@click.command(
    cls=Command,
    examples="""
    trackmetrics demo
    trackmetrics demo --noise published --html published.html
    trackmetrics demo --scene targets --runs 50 --format csv
    """,
)
@click.option(
    "--scene",
    type=click.Choice(["ships", "targets"]),
    default="ships",
    show_default=True,
    help="Three ships and their filter, or targets in clutter.",
)
@click.option(
    "--noise",
    type=click.Choice(["consistent", "published"]),
    default="consistent",
    show_default=True,
    help="Ships: sensor noise that the filter assumes, the true one or that of the published run.",
)
@click.option("--html", metavar="FILE", help="Ships: the page (demo.html); '' writes none.")
@click.option("--runs", default=20, show_default=True, help="Targets: Monte Carlo runs.")
@click.option("--targets", default=10, show_default=True, help="Targets: targets in each run.")
@click.option("--scans", default=100, show_default=True, help="Targets: scans of 1 s in each run.")
@click.option("--seed", default=1, show_default=True, help="Seed of the random numbers.")
@output_options
def command(
    scene: str,
    noise: str,
    html: str | None,
    runs: int,
    targets: int,
    scans: int,
    seed: int,
    output: Output,
) -> None:
    """Simulate, track and diagnose, with known truth.

    `ships`: three ships, tracked by the vessel estimator, diagnosed, on one page. `targets`:
    seeded Monte Carlo runs of a multi-target scene, scored with the documented functions.
    """
    if scene == "ships":
        from trackmetrics.cli._demo_ships import run_ships

        run_ships(output, noise, html, seed)
    else:
        from trackmetrics.cli._demo_targets import run_targets

        run_targets(output, runs, targets, scans, seed)
