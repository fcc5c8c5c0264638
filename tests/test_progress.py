"""The bar: on a terminal only, after a while, and what is counted passes through unchanged."""

import io
import sys

import pytest

from trackmetrics import _progress
from trackmetrics.cli import main


class Terminal(io.StringIO):
    """Standard error on a terminal."""

    def isatty(self):
        return True


@pytest.fixture
def recording(tmp_path):
    path = tmp_path / "run.csv"
    rows = [f"{10 * k},1,50.0,{1 + 0.0007 * k},10,90\n" for k in range(500)]
    path.write_text("time,mmsi,lat,lon,sog,cog\n" + "".join(rows), encoding="utf-8")
    return path


def test_a_bar_on_a_terminal(monkeypatch):
    monkeypatch.setattr(_progress, "DELAY", 0.0)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(sys, "stderr", terminal := Terminal())
    assert list(_progress.with_progress(range(3), "counting", 3, "items")) == [0, 1, 2]
    assert "counting" in terminal.getvalue()


def test_no_bar_for_what_is_soon_done(monkeypatch):
    monkeypatch.setattr(sys, "stderr", terminal := Terminal())
    assert list(_progress.with_progress(range(3), "counting", 3, "items")) == [0, 1, 2]
    assert terminal.getvalue() == ""


def test_no_bar_without_a_terminal(recording, monkeypatch, capsys):
    monkeypatch.setattr(_progress, "DELAY", 0.0)
    assert main(["vessel", "--quiet", str(recording)]) == 0
    assert capsys.readouterr().err == ""


def test_without_rich_there_is_none(monkeypatch):
    monkeypatch.setitem(sys.modules, "rich.progress", None)
    monkeypatch.setattr(sys, "stderr", Terminal())
    assert _progress.bar(3, "items") is None
    assert list(_progress.with_progress(range(3), "counting", 3, "items")) == [0, 1, 2]
