"""A sweep as one self-contained page: its figures for light and dark screens, and its table."""

import base64
import html
import io
import os
from pathlib import Path
from typing import Any

from trackmetrics.monte_carlo import Best, SweepResult
from trackmetrics.report.diagnosis_figures import draw
from trackmetrics.report.scene import Scene
from trackmetrics.report.sweep_scenes import heat_scene, label, sweep_scene
from trackmetrics.report.theme import DARK, LIGHT

_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>
:root {{ color-scheme: light dark; {light} }}
@media (prefers-color-scheme: dark) {{ :root {{ {dark} }} }}
body {{ font: 15px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 76rem; padding: 0 1rem;
  background: var(--page); color: var(--ink); }}
img {{ background: var(--surface); }}
h1 {{ font-size: 1.7rem; line-height: 1.2; overflow-wrap: anywhere; }}
.scroll {{ overflow-x: auto; }}
table {{ border-collapse: collapse; font-variant-numeric: tabular-nums; }}
td, th {{ padding: .25rem .8rem; text-align: right; border-bottom: 1px solid var(--grid); }}
td:first-child, th:first-child {{ text-align: left; white-space: nowrap; padding-left: 0; }}
small {{ display: block; color: var(--muted); white-space: nowrap; }}
.best {{ font-weight: bold; }}
</style></head><body>
<h1>{title}</h1><p>{summary}</p>
{verdict}
{figures}
{table}
</body></html>
"""


def write_sweep_page(
    path: str | os.PathLike[str],
    result: SweepResult,
    *,
    title: str = "Monte Carlo sweep",
    best: Best | None = None,
) -> None:
    """Writes the figures and the table of a sweep as one HTML file, readable offline."""
    Path(path).write_text(sweep_page(result, title=title, best=best), encoding="utf-8")


def sweep_page(
    result: SweepResult, *, title: str = "Monte Carlo sweep", best: Best | None = None
) -> str:
    """The figures and the table of a sweep as HTML, and the best setting where one was chosen.

    ANEES and RMSE over time where runs gave truth; the mean NEES over the first two parameters of
    the grid that vary.
    """
    scenes = []
    if "nees" in result.scores:
        scenes.append(sweep_scene(result))
    varying = [name for name in result.grid[0] if len({repr(s[name]) for s in result.grid}) > 1]
    if len(varying) > 1 and result.scores:
        scenes.append(heat_scene(result, varying[0], varying[1], next(iter(result.scores))))
    failed = len(result.failures)
    summary = f"{result.runs} runs of {len(result.grid)} settings, seed {result.seed}"
    summary += f"; {failed} runs failed" if failed else ""
    return _PAGE.format(
        title=html.escape(title),
        summary=html.escape(summary),
        verdict="" if best is None else _verdict(best),
        light=_variables(LIGHT.colours),
        dark=_variables(DARK.colours),
        figures="\n".join(map(_picture, scenes)),
        table=_table(result, None if best is None else best.index),
    )


def _verdict(best: Best) -> str:
    said = "; ".join(best.words())
    return f"<p><strong>{html.escape(label(best.settings))}</strong> is {html.escape(said)}.</p>"


def _variables(colours: Any) -> str:
    return " ".join(
        f"--{name}: {colours[name]};" for name in ("page", "surface", "ink", "muted", "grid")
    )


def _picture(scene: Scene) -> str:
    light, dark = (_address(draw(scene, "matplotlib", dark)) for dark in (False, True))
    return (
        f'<p class="scroll"><picture><source srcset="{dark}" media="(prefers-color-scheme: dark)">'
        f'<img src="{light}" alt="{html.escape(scene.title)}"></picture></p>'
    )


def _address(figure: Any) -> str:
    """The figure as SVG in an address."""
    file = io.BytesIO()
    figure.savefig(file, format="svg", metadata={"Date": None})
    return f"data:image/svg+xml;base64,{base64.b64encode(file.getvalue()).decode()}"


def _table(result: SweepResult, best: int | None) -> str:
    """A row for each setting, scores with their intervals; the best one is marked."""
    columns = result.to_columns("settings")
    names = ["runs", "failed", *result.scores]
    head = "".join(f"<th>{html.escape(name)}</th>" for name in ["setting", *names])
    rows = []
    for k, settings in enumerate(result.grid):
        cells = [html.escape(label(settings)), *(_cell(columns, name, k) for name in names)]
        mark = " class='best'" if k == best else ""
        rows.append(f"<tr{mark}>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>")
    return f"<div class='scroll'><table><tr>{head}</tr>\n" + "\n".join(rows) + "\n</table></div>"


def _cell(columns: dict[str, Any], name: str, k: int) -> str:
    value = f"{columns[name][k]:.4g}"
    if f"{name}_low" not in columns:
        return value
    low, high = columns[f"{name}_low"][k], columns[f"{name}_high"][k]
    return f"{value} <small>{low:.4g} &hellip; {high:.4g}</small>"
