"""What the commands that diagnose vessels print, and the page they write."""

from collections.abc import Mapping
from pathlib import Path

from trackmetrics.diagnostics import Diagnosis, TrackDiagnosis
from trackmetrics.logs import EstimatorLog
from trackmetrics.vessel import HeldOut


def print_verdicts(diagnosis: Diagnosis) -> None:
    """A line for each track, the most severe first, and what to look at first."""
    width = max([5, *(len(track) for track in diagnosis)])
    heading = f"{'track':{width}}  {'verdict':24}  {'NIS scale':>21}  {'since':>8}"
    print(f"{heading}  {'weakest state':13}  updates")
    worst = diagnosis.by_severity()
    for track in worst:
        weakest = track.weakest_state or "-"
        print(
            f"{track.track:{width}}  {track.verdict:24}  {_scale(track):>21}  {_since(track):>8}"
            f"  {weakest:13}  {track.updates:7}"
        )
    failing = [track for track in worst if track.verdict not in ("consistent", "insufficient")]
    if failing:
        print(f"\nLook at this first: {failing[0].text}")
    else:
        print("\nEvery filter is as honest as its updates can tell.")


def _scale(track: TrackDiagnosis) -> str:
    low, high = track.nis.interval
    return f"{track.nis.scale:.3g} [{low:.3g}, {high:.3g}]"


def _since(track: TrackDiagnosis) -> str:
    """When the fault began, or ended, since the start of the log."""
    quantity = track.nis if track.nis.onset_time is not None else track.nees or track.nis
    if quantity.onset_time is not None:
        return track.timeline.at(quantity.onset_time)
    settled = track.nis.settling_time
    return "-" if settled is None else f"to {track.timeline.at(settled)}"


def write_html(
    path: str,
    diagnosis: Diagnosis,
    log: EstimatorLog,
    title: str,
    held_out: Mapping[str, HeldOut] | None = None,
) -> None:
    """The page of a diagnosis."""
    from trackmetrics.report import write_page

    write_page(path, diagnosis, log, title=title, held_out=held_out)
    print(f"\nwrote {path} ({Path(path).stat().st_size / 1e6:.1f} MB)")
