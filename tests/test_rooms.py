"""Files of one room import downwards only."""

import ast
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import trackmetrics

ROOT = Path(trackmetrics.__file__).parent
ROOMS = ("consistency", "diagnostics", "monte_carlo", "report", "vessel")


def imports(path, known):
    """The files of the room that a file imports, at its top or within a function."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            found |= {node.module, *(f"{node.module}.{name.name}" for name in node.names)}
    return found & known


@pytest.mark.parametrize("room", ROOMS)
def test_files_of_a_room_import_in_no_circle(room):
    files = {f"trackmetrics.{room}.{p.stem}": p for p in (ROOT / room).glob("[!_]*.py")}
    assert len(files) > 5
    graph = {name: imports(path, files.keys()) for name, path in files.items()}
    assert any(graph.values())
    TopologicalSorter(graph).prepare()
