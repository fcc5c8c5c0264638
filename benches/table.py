"""Writes docs/performance.md from the figures in benches/results/."""

import json
from pathlib import Path

ROOT = Path(__file__).parents[1]
INTRODUCTION = """\
# How fast

Measured by the scripts in `benches/` on the release wheel: our function and its peer in turn, in
one process, the ratio of the medians. `make bench` measures again and writes this page.
"""


def main() -> None:
    """One section for each file of results."""
    sections = [section(path) for path in sorted((ROOT / "benches/results").glob("*.json"))]
    page = "\n".join([INTRODUCTION, *(s for s in sections if s)])
    (ROOT / "docs/performance.md").write_text(page)


def section(path: Path) -> str:
    """The rows of one file as a table; nothing for files of another kind."""
    content = json.loads(path.read_text())
    if "rows" not in content or "machine" not in content:
        return ""
    machine = content["machine"]
    where = ", ".join(f"{key} {value}" for key, value in machine.items())
    rows = "\n".join(line(row) for row in content["rows"])
    head = "| what | ours | peer | ratio | wanted |\n| --- | ---: | --- | ---: | ---: |"
    return f"## {path.stem}\n\n{where}\n\n{head}\n{rows}\n"


def line(row: dict[str, object]) -> str:
    """One comparison, or one figure that is not a comparison."""
    wanted = "" if row["target"] is None else f"{row['target']:.3g}"
    if row["ours"] == row["theirs"] == row["ratio"]:
        return f"| {row['what']} | {row['ours']:.4g} | {row['peer']} | | {wanted} |"
    return (
        f"| {row['what']} | {seconds(row['ours'])} | {row['peer']} | {row['ratio']:.1f}x "
        f"| {wanted}{'x' if wanted else ''} |"
    )


def seconds(value: object) -> str:
    """A time in the unit that reads best."""
    value = float(str(value))
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)):
        if value >= size or unit == "ns":
            return f"{value / size:.3g} {unit}"
    return ""


if __name__ == "__main__":
    main()
