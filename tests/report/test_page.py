"""The page: one file that holds everything, parsed and unpacked as a browser would."""

import base64
import gzip
import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest

from trackmetrics import report
from trackmetrics.diagnostics import Diagnosis, diagnose
from trackmetrics.logs import EstimatorLog
from trackmetrics.report import theme
from trackmetrics.report.diagnosis_page import BLOCK
from trackmetrics.report.packing import FORMS, PackedArrays
from trackmetrics.vessel import HeldOutResult

MEGABYTE = 1e6
VOID = {"meta", "link", "input", "br", "rect"}


class Document(HTMLParser):
    """Checks that elements nest, and collects them with their text."""

    def __init__(self, html):
        super().__init__()
        self.stack, self.elements, self.unclosed = [], [], []
        self.feed(html)
        self.close()

    def handle_starttag(self, tag, attributes):
        element = (tag, dict(attributes), [])
        self.elements.append(element)
        if tag not in VOID:
            self.stack.append(element)

    def handle_endtag(self, tag):
        if tag == "rect":
            return
        if not self.stack or self.stack[-1][0] != tag:
            self.unclosed.append(tag)
        else:
            self.stack.pop()

    def handle_data(self, data):
        for element in self.stack:
            element[2].append(data)

    def find(self, tag, **attributes):
        wanted = {k.replace("_", "-"): v for k, v in attributes.items()}
        return [e for e in self.elements if e[0] == tag and wanted.items() <= e[1].items()]


def payload(document, name):
    """The bytes of one of the page's parts."""
    (element,) = document.find("script", id=name)
    return gzip.decompress(base64.b64decode("".join(element[2])))


def unpacked(document, index):
    """The content of a track: its figures, tables and updates, with numbers for columns."""
    data = payload(document, f"data-{index // BLOCK}")
    length = int.from_bytes(data[:4], "little")
    block = json.loads(data[4 : 4 + length])
    columns = block.pop("columns")
    decoded = decode([column for track in columns for column in track], data[4 + length :])
    first = sum(map(len, columns[: index % BLOCK]))
    track = {part: values[index % BLOCK] for part, values in block.items()}
    return resolved(track, decoded[first:])


def resolved(value, columns):
    """The same with arrays where there were references."""
    if isinstance(value, list):
        return [resolved(item, columns) for item in value]
    if not isinstance(value, dict):
        return value
    if "column" in value:
        found = columns[value["column"]]
        return found[columns[value["rows"]]] if "rows" in value else found
    whole = {key: resolved(item, columns) for key, item in value.items()}
    if "product" in whole:
        return np.multiply(*whole["product"])
    if "names" in whole:
        return [whole["names"][int(code)] for code in whole["codes"]]
    if "around" in whole:
        x, centre, std = whole.pop("around")
        half = whole.pop("factor") * std
        whole |= {"x": np.r_[x, x[::-1]], "y": np.r_[centre + half, (centre - half)[::-1]]}
    return whole


def decode(columns, data):
    """The numbers of all columns of a block, as packing.py describes them."""
    found, at = {}, 0
    for form in FORMS:
        members = [i for i, column in enumerate(columns) if column["form"] == form]
        sizes = [-(-columns[i]["n"] // 8) if form == "b" else columns[i]["n"] for i in members]
        width = 1 if form == "b" else int(form[1])
        planes = np.frombuffer(data, np.uint8, width * sum(sizes), at).reshape(width, sum(sizes))
        at += planes.size
        for i, part in zip(members, np.split(planes, np.cumsum(sizes)[:-1], axis=1), strict=False):
            found[i] = numbers(columns[i], part)
    assert at == len(data)
    return [found[i] for i in range(len(columns))]


def numbers(column, planes):
    """The numbers of a column of these planes."""
    form, width = column["form"], len(planes)
    if form == "b":
        return np.unpackbits(planes[0], count=column["n"]) == 1
    shifts = np.uint64(8) * np.arange(width, dtype=np.uint64)[::-1, None]
    codes = (planes.astype(np.uint64) << shifts).sum(axis=0, dtype=np.uint64)
    if form.endswith("d"):
        codes = np.cumsum(codes, dtype=np.uint64) % np.uint64(256**width)
    values = np.where(codes == 256**width - 1, np.nan, column["low"] + column["step"] * codes)
    if form[0] == "l":
        values = np.where((codes == 0) & (column.get("zero", 0) == 1), 0.0, np.exp(values))
    return values


@pytest.fixture(scope="module")
def html(small):
    return report.render_page(small[1], small[0], title="Four <vessels> & a page")


@pytest.fixture(scope="module")
def document(html):
    return Document(html)


def test_it_is_well_formed_and_alone(html, document):
    assert html.startswith("<!doctype html>")
    assert document.stack == []
    assert document.unclosed == []
    assert not re.search(r"(src|href)=[\"']?(https?:)?//", html)
    assert not re.search(r"@import|url\((?!data:)", html)
    assert "Four &lt;vessels&gt; &amp; a page" in html


def test_it_brings_plotly_with_its_licence(html, document):
    code = payload(document, "plotly").decode()
    assert "Plotly" in code
    assert "Copyright 2012" in html
    assert "MIT license" in html


def test_the_overview_is_sorted_by_severity(small, document):
    rows = [e[1] for e in document.find("tr") if "data-verdict" in e[1]]
    wanted = [(track.track, track.verdict) for track in small[1].by_severity()]
    assert [(row["data-name"], row["data-verdict"]) for row in rows] == wanted
    text = " ".join("".join(document.find("table", id="overview")[0][2]).split())
    assert "late divergence" in text
    assert "turn_rate" in text
    assert "NIS from 124 min" in text
    assert small[1]["vessel 001"].findings in text


def test_there_are_tables_for_those_who_do_not_see_figures(document):
    for table in document.find("table"):
        assert table[0]
    part = unpacked(document, 0)
    assert [t["caption"] for t in part["tables"]][:2] == [
        "Segments: squared errors over their expectation from the covariance",
        "States",
    ]
    columns = part["updates"]
    expected = {"min", "measurement type", "status", "NIS", "NIS dof", "NEES", "NEES dof"}
    assert set(columns) == expected
    assert {len(values) for values in columns.values()} == {60}


def test_every_part_unpacks_to_figures_that_plotly_accepts(small, document):
    import plotly.graph_objects as go

    for index, track in enumerate(small[1].by_severity()):
        part = unpacked(document, index)
        from trackmetrics.report.draw_plotly import coloured

        figure = go.Figure(coloured({"data": part["data"], "layout": part["layout"]}, theme.LIGHT))
        start = "minutes since start, 2023-11-14 22:16:20 UTC"
        assert figure.layout.xaxis3.title.text == start
        assert all(trace["name"] == track.track for trace in part["comparison"])
        points = [t for t in part["comparison"] if t["yaxis"] == "y" and t["mode"] == "markers"]
        drawn = np.sort([v for t in points for v in t["y"]])
        rows = small[0][track.track]
        nis = np.sort((rows.nis / rows.nis_dof)[np.isfinite(rows.nis)])
        np.testing.assert_allclose(drawn, nis, rtol=1e-3)


@pytest.mark.parametrize(
    ("values", "log", "precision"),
    [
        (np.linspace(-3, 5, 50), False, 8 / 4096),
        (np.geomspace(1e-3, 1e4, 50), True, 1e-2),
        (np.r_[0.0, np.geomspace(1e-3, 1e4, 49)], True, 1e-2),
        (np.where(np.arange(50) % 7 == 0, np.nan, np.arange(50.0)), False, 1e-12),
        (np.full(50, 7.25), False, 0),
        (np.full(50, np.nan), False, 0),
        (np.full(50, np.nan), True, 0),
        (np.r_[np.inf, np.arange(49.0)], False, 1e-12),
    ],
)
def test_packed_numbers_come_back(values, log, precision):
    arrays = PackedArrays()
    arrays.begin_track()
    rows = np.arange(50) % 3 > 0
    content = {"y": arrays.values(values, log, rows), "x": arrays.times(np.arange(50) / 7)}
    data = arrays.payload({"tracks": [content]})
    length = int.from_bytes(data[:4], "little")
    header = json.loads(data[4 : 4 + length])
    columns = decode(header["columns"][0], data[4 + length :])
    found = resolved(header["tracks"][0], columns)
    np.testing.assert_allclose(found["x"], np.arange(50) / 7, atol=1e-6)
    wanted = np.where(np.isfinite(values), values, np.nan)[rows]
    tolerance = {"rtol": precision} if log else {"rtol": 1e-9, "atol": precision}
    np.testing.assert_allclose(found["y"], wanted, **tolerance)


def test_both_themes_are_in_it(html):
    for chosen in theme.THEMES:
        for role, colour in chosen.colours.items():
            assert f"--{role}: {colour};" in html
    assert "prefers-color-scheme: dark" in html


def test_a_hundred_tracks_are_below_ten_megabytes(fleet_page):
    assert len(fleet_page.encode()) < 5 * MEGABYTE
    document = Document(fleet_page)
    assert len(document.find("input", type="checkbox")) == 100
    checked = [e for e in document.find("input", type="checkbox") if "checked" in e[1]]
    assert len(checked) == 8


def test_the_same_diagnosis_gives_the_same_file(small, html, tmp_path):
    path = tmp_path / "out.html"
    report.write_page(path, small[1], small[0], title="Four <vessels> & a page")
    assert path.read_text(encoding="utf-8") == html


@pytest.mark.data
def test_states_that_are_published_alone_have_their_panels(published):
    log, diagnosis = published
    document = Document(report.render_page(diagnosis, log))
    for index, track in enumerate(diagnosis.by_severity()):
        figure, rows = unpacked(document, index), log[track.track]
        titles = [a["text"] for a in figure["layout"]["annotations"]]
        assert titles.count("not in the log") == 6
        estimates = [t for t in figure["data"] if t["name"] == "estimate"]
        assert len(estimates) == 2
        np.testing.assert_allclose(
            estimates[0]["y"], rows.x[:, 2], atol=np.ptp(rows.x[:, 2]) / 4096
        )
        measured = sum(len(t["y"]) for t in figure["data"] if t["name"].startswith("measured"))
        assert measured == 2 * (rows.measurement_type == "AISMeasurement").sum()


def test_updates_that_lack_components_are_small_in_the_support_strip():
    rng = np.random.default_rng(0)
    innovation = rng.normal(size=(30, 2))
    innovation[::3, 1] = np.nan
    log = EstimatorLog.from_columns(
        innovation=innovation, S=np.tile(np.eye(2), (30, 1, 1)), measurement_type="radar"
    )
    diagnosis = diagnose(log)
    document = Document(report.render_page(diagnosis, log))
    figure = unpacked(document, 0)
    sizes = {t["name"]: len(t["x"]) for t in figure["data"] if t["yaxis"] == "y2"}
    assert sizes == {"radar": 20, "radar, some components missing": 10}
    assert "10 innovations lack components" in diagnosis["track"].text


def test_without_a_log_and_without_tracks(small):
    assert "late divergence" in report.render_page(small[1])
    empty = report.render_page(Diagnosis((), ("the log looks odd <",)))
    assert "0 tracks" in empty
    assert "the log looks odd &lt;" in empty


@pytest.fixture(scope="module")
def predicted(small):
    """What might have been found on the reports left out of two tracks."""
    results = {}
    for name, scale in (("vessel 001", 0.05), ("vessel 002", 3.25)):
        interval, nothing = (0.8 * scale, 1.3 * scale), np.empty(0)
        results[name] = HeldOutResult(
            name, 120, 20, 400, 210.4, scale, interval, 1.2e-5, nothing, nothing
        )
    return results


def test_reports_left_out_have_a_section(small, predicted):
    document = Document(report.render_page(small[1], small[0], held_out=predicted))
    assert document.stack == []
    (table,) = document.find("table", id="predictions")
    text = " ".join("".join(table[2]).split())
    assert text.index("vessel 002") < text.index("vessel 001")
    assert "▼ pessimistic 0.050.04 to 0.065 1.2e-05 120in 20 gaps 210of 400" in text
    assert "▲ optimistic 3.252.6 to 4.23" in text
    bars = [e[1] for e in document.find("rect") if e[1].get("height") == "6"]
    left, right = (50 + 25 * np.log10(0.05 * factor) for factor in (0.8, 1.3))
    assert float(bars[1]["x"]) == pytest.approx(left, abs=0.01)
    assert float(bars[1]["width"]) == pytest.approx(right - left, abs=0.01)
    assert [bar["class"] for bar in bars] == ["high", "low"]


def test_a_section_of_predictions_only_where_there_are_some(document, small, predicted):
    assert not document.find("table", id="predictions")
    elsewhere = {"vessel 999": predicted["vessel 001"]}
    page = Document(report.render_page(small[1], small[0], held_out=elsewhere))
    assert not page.find("table", id="predictions")
