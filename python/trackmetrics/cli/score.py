"""``trackmetrics score TRUTH TRACKS``: a tracker's boxes against the truth."""

from dataclasses import fields
from typing import Any

import click

from trackmetrics.cli._output import Command, Output, output_options
from trackmetrics.cli._table import Column, Table


@click.command(
    cls=Command,
    examples="""
    trackmetrics score gt.txt tracks.txt
    trackmetrics score gt.txt tracks.txt --threshold 50 --cutoff 100 --order 2 --format json
    """,
)
@click.argument("truth", metavar="TRUTH")
@click.argument("tracks", metavar="TRACKS")
@click.option(
    "--threshold", default=50.0, show_default=True, help="Largest distance of a pair, in pixels."
)
@click.option("--cutoff", default=100.0, show_default=True, help="Cutoff c of OSPA, in pixels.")
@click.option("--order", default=2.0, show_default=True, help="Order p of OSPA.")
@output_options
def command(
    truth: str, tracks: str, threshold: float, cutoff: float, order: float, output: Output
) -> None:
    """Score the boxes of a tracker against the truth.

    Reads two MOTChallenge files (frame,id,left,top,width,height[,confidence,...]) and compares
    the centres of the boxes, in pixels, in every frame from the first to the last of either file.
    A truth line whose confidence is below 1 does not count.

    Misses, false alarms and MOTP are those of mot_metrics: in each frame truth and tracks are
    matched at the least total distance, then pairs farther apart than the threshold are dropped.
    Its switches, fragmentations and MOTA are not printed: they take the position in a frame's list
    for an identity, and in a file that position means nothing.

    Purity, fragmentation and switches count over the ids of pairs that are matched with the gate
    first: in each frame as many pairs within the threshold as possible, at the least total
    distance.
    """
    from trackmetrics.tracking import score_boxes
    from trackmetrics.tracks import read_mot_challenge

    scores = score_boxes(
        read_mot_challenge(truth, progress=True).counted(),
        read_mot_challenge(tracks, progress=True),
        threshold=threshold,
        cutoff=cutoff,
        order=order,
    )
    output.message(f"{tracks} against {truth}: {scores.frames} frames, centres of boxes")
    output.write(score_table(scores), content=scores)


def score_table(scores: Any) -> Table:
    """One row per score, from the metadata of the fields."""
    rows = [(field, getattr(scores, field.name)) for field in fields(scores) if field.metadata]
    values = {field.name: getattr(scores, field.name) for field in fields(scores)}
    columns = (
        Column("score", lambda r: r[0].name, text=lambda r: r[0].metadata["label"]),
        Column("value", lambda r: r[1], text=_text, right=True),
        Column("meaning", lambda r: r[0].metadata["note"].format(**values), rank=1),
    )
    return Table(columns, rows)


def _text(row: Any) -> str:
    field, value = row
    return "-" if value != value else str(field.metadata["text"].format(value))
