"""The structure of the package as DESIGN.md describes it: layers, no circles, short files."""

import ast
from graphlib import CycleError, TopologicalSorter
from importlib import import_module
from pathlib import Path

import pytest

import trackmetrics
from trackmetrics import _deprecated

PACKAGE = Path(trackmetrics.__file__).parent
ROOT = "trackmetrics"
MAX_LINES = 400

LAYERS = (
    ("_version", "_deprecated", "errors", "results"),
    (
        *("_numpy", "_native", "_backend", "_check", "_angles", "_covariances"),
        *("_covariance_rule", "_distributions", "_format", "_progress", "_similarity", "_tables"),
    ),
    ("accuracy", "assignment", "point_sets", "trajectories", "consistency", "logs", "tracks"),
    ("tracking", "diagnostics", "monte_carlo"),
    ("vessel",),
    ("report",),
    ("compat",),
    ("", "estimation_metrics", "io", "mospa", "track_metrics"),  # "" is the package itself
    ("cli",),
    ("__main__",),
)
"""From the lowest: a package imports only from layers below its own."""
LAYER = {name: layer for layer, names in enumerate(LAYERS) for name in names}
SHARED_LAYERS = (0, 1)
"""Single private files that may import each other, as long as there is no circle."""
PUBLIC = ("consistency", "diagnostics", "logs", "monte_carlo", "point_sets", "report", "tracking")
PUBLIC += ("tracks", "trajectories", "vessel")


def module_name(path):
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return ".".join((ROOT, *(part for part in parts if part != "__init__")))


FILES = {module_name(path): path for path in sorted(PACKAGE.rglob("*.py"))}


def imported(path):
    """Every module of the package that a file imports, at its top or within a function."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name.split(".")[0] == ROOT)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: imports are absolute"
            if node.module and node.module.split(".")[0] == ROOT:
                for alias in node.names:
                    member = f"{node.module}.{alias.name}"
                    yield member if member in FILES else node.module


GRAPH = {name: set(imported(path)) - {name} for name, path in FILES.items()}


def layer_name(module):
    return module.removeprefix(ROOT).removeprefix(".").split(".")[0]


def test_the_graph_is_not_empty():
    assert len(GRAPH) > 100
    assert sum(map(len, GRAPH.values())) > 300


def test_no_file_imports_itself_through_others():
    try:
        TopologicalSorter(GRAPH).prepare()
    except CycleError as error:
        pytest.fail(" <- ".join(error.args[1]))


def test_every_package_has_a_layer():
    assert {layer_name(module) for module in FILES} <= LAYER.keys()


@pytest.mark.parametrize("module", FILES)
def test_imports_go_to_lower_layers(module):
    own = layer_name(module)
    for other in GRAPH[module]:
        name = layer_name(other)
        is_shared = LAYER[own] in SHARED_LAYERS and LAYER[name] <= LAYER[own]
        assert name == own or LAYER[name] < LAYER[own] or is_shared, f"{module} imports {other}"


@pytest.mark.parametrize("module", FILES)
def test_only_the_backend_names_the_kernels(module):
    if layer_name(module) not in ("_backend", "_numpy"):
        kernels = {"_native", "_numpy"}
        assert not kernels & {layer_name(other) for other in GRAPH[module]}


@pytest.mark.parametrize("module", FILES)
def test_files_are_read_in_one_sitting(module):
    lines = len(FILES[module].read_text(encoding="utf-8").splitlines())
    assert lines < MAX_LINES, f"{module} has {lines} lines"


def public_names():
    for package in ("", *PUBLIC):
        module = import_module(".".join(filter(None, (ROOT, package))))
        old = f"{module.__name__}."
        for name in module.__all__:
            if old + name not in _deprecated.RENAMED:
                yield name, module


def test_one_public_name_is_one_object():
    found = {}
    for name, module in public_names():
        value = getattr(module, name)
        assert found.setdefault(name, value) is value, f"{module.__name__}.{name}"


DOCS = Path(__file__).resolve().parents[1] / "docs"


def test_every_public_name_is_documented_on_a_page():
    text = "\n".join(page.read_text(encoding="utf-8") for page in DOCS.glob("**/*.md"))
    text += (DOCS.parent / "README.md").read_text(encoding="utf-8")
    missing = {name for name, _ in public_names() if name not in text and name[0] != "_"}
    assert not missing
