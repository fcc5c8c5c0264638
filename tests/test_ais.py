"""Recordings of AIS: every trap of a real one, and the ones it does not have."""

import csv
import io

import numpy as np
import pytest

import trackmetrics
from trackmetrics import vessel
from trackmetrics.cli import main
from trackmetrics.vessel import read_ais, screen_rows

HEAD = "Time,MMSI,Latitude_degrees,Longitude_degrees,COG_degrees,SOG_knots\n"


def row(time, lat=50.0, lon=1.0, sog=10.0, cog=90.0, mmsi="235000001", **more):
    return {"time": time, "vessel": mmsi, "lat": lat, "lon": lon, "sog": sog, "cog": cog, **more}


def sailing(n, mmsi="235000001", start=0.0, lat=50.0):
    """Rows of a vessel that goes east at 10 kt, a report every 10 s."""
    return [row(start + 10.0 * k, lat, 1.0 + 0.00072 * k, mmsi=mmsi) for k in range(n)]


def reasons(recording):
    return [(rejected.row, rejected.reason) for rejected in recording.rejected]


# ------------------------------------------------------------------ the traps of the Solent


@pytest.fixture
def solent(data):
    return data / "ais" / "solent_ais_20160112.csv"


@pytest.mark.data
def test_every_trap_of_the_recording_is_met(solent):
    recording = read_ais(solent)
    # Of the 298 repeated positions 3 stand in the rows that are wholly the same.
    assert recording.counts == {
        "duplicate": 3,
        "jump": 4,
        "bit fault": 1,
        "repeated position": 298 - 3,
    }
    assert recording.rows == 18_623 == len(recording.reports) + len(recording.rejected)
    assert recording.without_course == 1_027
    assert recording.out_of_order == 0
    assert recording.duplicate_mmsi == ()
    assert len(recording.reports.vessels) == 91
    fault = next(rejected for rejected in recording.rejected if rejected.reason == "bit fault")
    assert fault.vessel == "245188000"
    assert fault.detail.endswith("one bit makes it longitude -1.09233")
    assert np.abs(recording.reports.z[:, 1] + 1.2).max() < 1


@pytest.fixture
def native():
    """The reference takes forty times as long over a recording, and gives the same numbers."""
    with trackmetrics.use_backend("native"):
        yield


@pytest.mark.data
@pytest.mark.usefixtures("native")
def test_all_vessels_under_way_run_through(solent, tmp_path, capsys):
    page, log = tmp_path / "out.html", tmp_path / "log.jsonl"
    words = ["vessel", str(solent), "--thin", "60", "--html", str(page), "--log", str(log)]
    assert main([*words, "--format", "csv"]) == 0
    assert '<table id="predictions">' in page.read_text(encoding="utf-8")
    rows = list(csv.DictReader(io.StringIO(capsys.readouterr().out)))
    assert len(rows) == 17
    assert all(row["held_out_verdict"] and int(row["held_out_reports"]) > 0 for row in rows)
    # Inconsistent from some time on: a transient is one that ends.
    late = [row for row in rows if row["verdict"] in ("late_divergence", "transient")]
    assert "232002939" in {row["track"] for row in late}  # the ferry, after a long silence
    assert all(float(row["onset_time"]) > 0 for row in late)
    assert page.stat().st_size < 10e6
    from trackmetrics.logs import read_log

    again = read_log(log)
    assert len(again.tracks) == 17
    assert again.columns.nees is None  # a recording has no truth


# ------------------------------------------------------------------ other traps


def test_a_duplicate_is_the_same_in_every_column():
    rows = sailing(5)
    recording = screen_rows([*rows, dict(rows[2])])
    assert reasons(recording) == [(5, "duplicate")]
    assert recording.rejected[0].detail == "the same as row 2"


def test_a_jump_is_rejected_and_the_vessel_goes_on():
    rows = sailing(20)
    rows[7]["lat"] += 0.3
    recording = screen_rows(rows)
    assert reasons(recording) == [(7, "jump")]
    assert len(recording.reports) == 19


@pytest.mark.parametrize("bit", [13, 20, 24])
@pytest.mark.parametrize("name", ["lat", "lon"])
def test_a_flipped_bit_is_known_as_one(bit, name):
    rows = sailing(20)
    rows[7][name] += 2.0**bit / 600_000
    recording = screen_rows(rows)
    assert reasons(recording) == [(7, "bit fault")]


def test_a_bad_first_report_does_not_take_the_vessel_with_it():
    rows = sailing(20)
    rows[0]["lat"] += 0.3
    assert reasons(screen_rows(rows)) == [(0, "jump")]


def test_two_vessels_with_one_mmsi_are_kept_apart():
    rows = [
        r for pair in zip(sailing(20), sailing(20, start=5.0, lat=51.0), strict=True) for r in pair
    ]
    recording = screen_rows(rows)
    assert recording.duplicate_mmsi == ("235000001",)
    assert recording.rejected == ()
    assert recording.reports.vessels == ("235000001", "235000001#2")
    assert len(set(np.round(recording.reports.z[::2, 0], 2))) == 1


def test_a_stale_position_is_rejected_only_under_way():
    rows = sailing(10)
    rows[4] |= {"lat": rows[3]["lat"], "lon": rows[3]["lon"]}
    assert reasons(screen_rows(rows)) == [(4, "repeated position")]
    still = [row(10.0 * k, sog=0.1) for k in range(5)]
    assert screen_rows(still).rejected == ()


@pytest.mark.parametrize(
    ("change", "reason", "detail"),
    [
        ({"time": "tomorrow"}, "unreadable", "time is 'tomorrow'"),
        ({"lat": "north"}, "unreadable", "lat is 'north'"),
        ({"lon": ""}, "no position", "lon is missing"),
        ({"sog": "fast"}, "unreadable", "sog is 'fast'"),
        ({"cog": "inf"}, "unreadable", "cog is 'inf'"),
        ({"vessel": " "}, "no identity", "it has no MMSI"),
        ({"lat": 91.0}, "no position", "latitude 91, longitude 1.0144"),
        ({"lon": 181.0}, "no position", "latitude 50, longitude 181"),
    ],
)
def test_rows_that_cannot_be_used(change, reason, detail):
    rows = sailing(30)
    rows[20] |= change
    recording = screen_rows(rows)
    assert reasons(recording) == [(20, reason)]
    assert recording.rejected[0].detail == detail


def test_speed_and_course_may_be_missing():
    rows = sailing(4)
    rows[1]["sog"], rows[2]["cog"], rows[3]["sog"] = "", None, 102.3
    recording = screen_rows(rows)
    assert recording.rejected == ()
    assert recording.reports.kinds == ("AIS", *["truncated AIS"] * 3)


def test_rows_out_of_order_are_sorted_and_counted():
    rows = sailing(10)
    rows[3], rows[6] = rows[6], rows[3]
    recording = screen_rows(rows)
    assert recording.out_of_order == 3
    assert (np.diff(recording.reports.time) > 0).all()


# ------------------------------------------------------------------ files


def test_columns_of_any_name(tmp_path):
    file = tmp_path / "a.csv"
    file.write_text("when,ship,phi,lambda\n2016-01-12T13:00:00Z,7,50,1\n1452603610.5,7,50,1\n")
    with pytest.raises(ValueError, match="no column for 'time': expected time or timestamp"):
        read_ais(file)
    columns = {"time": "when", "vessel": "ship", "lat": "phi", "lon": "Lambda"}
    recording = read_ais(file, columns)
    assert np.diff(recording.reports.time).tolist() == [10.5]
    with pytest.raises(ValueError, match="columns: no column 'speed'; a report has time, vessel"):
        read_ais(file, {"speed": "v"})


def test_a_short_line_is_unreadable(tmp_path):
    file = tmp_path / "a.csv"
    file.write_text(HEAD + "2016-01-12 13:00:00,1,50,1,90,10\n2016-01-12 13:00:10,1,50\n\n")
    assert reasons(read_ais(file)) == [(1, "no position")]


def test_a_file_without_a_usable_row(tmp_path, capsys):
    file = tmp_path / "a.csv"
    file.write_text(HEAD)
    with pytest.raises(ValueError, match="no usable report among 0 rows"):
        read_ais(file)
    assert main(["vessel", str(file)]) == 2
    assert capsys.readouterr().err == "trackmetrics vessel: no usable report among 0 rows\n"
    file.write_text(HEAD + "2016-01-12 13:00:00,1,50,1,90,10\n")
    assert main(["vessel", str(file)]) == 2
    assert "no vessel has 50 reports" in capsys.readouterr().err


def test_nmea(tmp_path):
    """Sentences that pyais itself wrote: class A and B, a static report, a broken one."""
    from pyais.encode import encode_dict

    def sentences(**fields):
        return encode_dict(fields, talker_id="AI")

    a = sentences(type=1, mmsi=235000001, lat=50.5, lon=-1.25, speed=12.3, course=87.5)
    b = sentences(type=18, mmsi=235000002, lat=50.6, lon=-1.35, speed=102.3, course=360.0)
    names = sentences(type=5, mmsi=235000001, shipname="TERN", callsign="X", destination="SEA")
    lines = [
        "# a comment",
        f"1452603600 {a[0]}",
        f"\\s:x,c:1452603610*00\\{b[0]}",
        *(f"1452603611,{part}" for part in names),
        f"1452603620 {a[0][:-1]}{'0' if a[0][-1] != '0' else '1'}",
        a[0],
        "1452603640 noise",
    ]
    file = tmp_path / "a.nmea"
    file.write_text("\n".join(lines) + "\n")
    recording = read_ais(file)
    assert recording.reports.vessels == ("235000001", "235000002")
    assert recording.reports.kinds == ("AIS", "truncated AIS")
    assert recording.reports.z[0] == pytest.approx([50.5, -1.25, 12.3, 87.5], abs=1e-5)
    assert recording.reports.time.tolist() == [1452603600.0, 1452603610.0]
    assert recording.counts == {"unreadable": 3}


# ------------------------------------------------------------------ the demo


def test_the_demo_of_the_ships(tmp_path, capsys):
    page = tmp_path / "demo.html"
    assert main(["demo", "--html", str(page)]) == 0
    told = capsys.readouterr()
    text = told.out
    assert told.err.startswith("three ships, 63 updates, consistent noise, seed 1: simulated,")
    assert "SS Northern Star0  late_divergence" in text
    assert "Most severe track: SS Northern Star0" in text
    assert page.stat().st_size < 10e6
    assert "MV Iron Falcon2" in page.read_text()
    assert main(["demo", "--html", "", "--noise", "published"]) == 0
    assert "pessimistic" in capsys.readouterr().out


def test_no_inconsistency_is_reported_where_there_is_none():
    from trackmetrics.cli._verdicts import most_severe
    from trackmetrics.diagnostics import diagnose

    run = vessel.fleet(1, duration=3600.0, report_interval=60.0, seed=4)
    found = most_severe(diagnose(run.track()))
    assert found == "No inconsistency was detected in any track."


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["vessel", "no.csv"], "trackmetrics vessel: no.csv: No such file or directory"),
        (["diagnose", "no.csv"], "trackmetrics diagnose: no.csv: No such file or directory"),
        (
            ["vessel", "no.csv", "--thin", "-5"],
            "trackmetrics vessel: --thin must be positive, got -5",
        ),
    ],
)
def test_what_cannot_be_done_is_said_in_a_line(words, said, capsys):
    assert main(words) == 2
    assert capsys.readouterr().err == f"{said}\n"
