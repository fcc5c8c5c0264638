"""Files and columns as people have them: each kind through every reader that can meet it."""

import bz2
import datetime
import gzip
import io
import lzma
import zipfile

import numpy as np
import pytest

from trackmetrics._tables import delimited, opening, polars_columns, times
from trackmetrics.logs import EstimatorLog, read_log

TEXT = "track,time,nis,nis_dof\na,1000,2.5,2\na,1010,1.5,2\nb,1000,0.5,2\n"
START = 1_720_562_400.0  # 2024-07-09 22:00:00 UTC


@pytest.fixture(params=["polars", "small"])
def reader(request, monkeypatch):
    """Both readers: Polars, and the small one that does without it."""
    if request.param == "small":
        monkeypatch.setattr(delimited, "polars", lambda: None)
        monkeypatch.setattr(times, "polars", lambda: None)
        monkeypatch.setattr(polars_columns, "polars", lambda: None)
    return request.param


def zipped(data):
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        archive.writestr("inside.csv", data)
    return out.getvalue()


PACKED = {
    "plain": lambda text: text.encode(),
    "byte order mark": lambda text: text.encode("utf-8-sig"),
    "utf-16": lambda text: text.encode("utf-16"),
    "gzip": lambda text: gzip.compress(text.encode()),
    "xz": lambda text: lzma.compress(text.encode()),
    "zip": lambda text: zipped(text),
    "line ends of Windows": lambda text: text.replace("\n", "\r\n").encode(),
}


@pytest.mark.parametrize("packing", PACKED)
def test_packings_and_encodings(tmp_path, packing, reader):
    path = tmp_path / "log.csv"
    path.write_bytes(PACKED[packing](TEXT))
    log = read_log(path)
    assert log.tracks == ("a", "b")
    assert log.columns.time.tolist() == [1000.0, 1010.0, 1000.0]
    assert log.columns.nis.tolist() == [2.5, 1.5, 0.5]


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"\x89PNG\r\n\x1a\n", "is a PNG picture"),
        (bz2.compress(TEXT.encode()), "log.csv"),
        (TEXT.encode("utf-16-le"), "is not text"),
        (TEXT.replace("a,", "\xe9,").encode("latin-1"), r"log\.csv, line 2: not UTF-8"),
        (gzip.compress(TEXT.encode(), mtime=0)[:30], "cannot be unpacked"),
        (b"", "empty"),
    ],
)
def test_what_is_no_log_is_named(tmp_path, data, message):
    path = tmp_path / "log.csv"
    path.write_bytes(data)
    with pytest.raises(ValueError, match=message) as caught:
        read_log(path)
    assert 0 < len(str(caught.value)) <= 300


HEADINGS = {
    "savetxt": "# track,time,nis,nis_dof",
    "blanks": " track , time, nis,nis_dof ",
    "quotes": '"track","time","nis","nis_dof"',
    "capitals": "Track,Time,NIS,NIS_dof",
}


@pytest.mark.parametrize("heading", HEADINGS)
def test_headings(tmp_path, heading, reader):
    path = tmp_path / "log.csv"
    path.write_text(HEADINGS[heading] + TEXT[TEXT.index("\n") :])
    assert read_log(path).columns.time.tolist() == [1000.0, 1010.0, 1000.0]


@pytest.mark.parametrize(
    ("heading", "message"),
    [
        ("track,tme,nis,nis_dof", "no column time .*did you mean 'tme'"),
        ("track,stamp,nis,nis_dof", "the headings are track, stamp, nis, nis_dof"),
        ("track,time,nis,nis", "heading 'nis' appears twice"),
        ("track,time,,nis", "heading 3 of 4 is empty"),
    ],
)
def test_wrong_headings_are_shown(tmp_path, heading, message):
    path = tmp_path / "log.csv"
    path.write_text(heading + TEXT[TEXT.index("\n") :])
    with pytest.raises(ValueError, match=message):
        read_log(path)


def test_row_numbers_are_times_only_when_asked_for(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("nis,nis_dof\n2,2\n3,2\n")
    with pytest.raises(ValueError, match="time='row'"):
        read_log(path)
    assert read_log(path, time="row").columns.time.tolist() == [0.0, 1.0]


DELIMITED = {
    "semicolon": "time;nis;nis_dof\n1.5;2.25;2\n2.5;3;2\n",
    "semicolon and decimal comma": "time;nis;nis_dof\n1,5;2,25;2\n2,5;3;2\n",
    "tab": "time\tnis\tnis_dof\n1.5\t2.25\t2\n2.5\t3\t2\n",
    "blanks of savetxt": "# time nis nis_dof\n1.5e+00 2.25e+00 2\n2.5e+00  3.0e+00 2\n",
    "quoted decimal comma": 'time,nis,nis_dof\n"1,5","2,25",2\n"2,5",3,2\n',
    "row names of R": '"","time","nis","nis_dof"\n"1",1.5,2.25,2\n"2",2.5,3,2\n',
}


@pytest.mark.parametrize("form", DELIMITED)
def test_delimiters_and_decimals(tmp_path, form, reader):
    path = tmp_path / "log.csv"
    path.write_text(DELIMITED[form])
    log = read_log(path)
    assert log.columns.time.tolist() == [1.5, 2.5]
    assert log.columns.nis.tolist() == [2.25, 3.0]


@pytest.mark.parametrize("cell", ['"1,234.5"', '"1,234"'])
def test_thousands_separators_are_refused(tmp_path, cell, reader):
    path = tmp_path / "log.csv"
    path.write_text(f"time,nis,nis_dof\n0,{cell},2\n1,{cell},2\n")
    with pytest.raises(ValueError, match="thousands separator"):
        read_log(path)


@pytest.mark.parametrize("cell", ["", "NA", "NaN", "null", "None"])
def test_missing_cells(tmp_path, cell, reader):
    path = tmp_path / "log.csv"
    path.write_text(f"time,nis,nis_dof,nees,nees_dof\n0,2,2,{cell},3\n1,3,2,1,3\n")
    assert np.isnan(read_log(path).columns.nees).tolist() == [True, False]


SECONDS = np.array([START, START + 10, START + 70])
TIMES = {
    "Unix seconds": SECONDS.tolist(),
    "milliseconds": (SECONDS * 1e3).astype(np.int64).tolist(),
    "microseconds": (SECONDS * 1e6).astype(np.int64).tolist(),
    "nanoseconds": (SECONDS * 1e9).astype(np.int64).tolist(),
    "compact": [20240709220000, 20240709220010, 20240709220110],
    "ISO": ["2024-07-09T22:00:00", "2024-07-09T22:00:10", "2024-07-09T22:01:10"],
    "ISO, Z": ["2024-07-09 22:00:00Z", "2024-07-09 22:00:10Z", "2024-07-09 22:01:10Z"],
    "ISO, zone": [f"2024-07-10T00:{m}+02:00" for m in ("00:00", "00:10", "01:10")],
    "ISO, fraction": [f"2024-07-09T22:{m}.000Z" for m in ("00:00", "00:10", "01:10")],
    "Go": [f"2024-07-09 22:{m} +0000 UTC" for m in ("00:00", "00:10", "01:10")],
}
COLUMNS_ONLY = {
    "datetime64[ns]": (SECONDS * 1e9).astype("M8[ns]"),
    "datetime64[s]": SECONDS.astype("M8[s]"),
    "datetime": [datetime.datetime.fromtimestamp(s, datetime.UTC) for s in SECONDS],
    "datetime without zone": [
        datetime.datetime.fromtimestamp(s, datetime.UTC).replace(tzinfo=None) for s in SECONDS
    ],
}


@pytest.mark.parametrize("form", [*TIMES, *COLUMNS_ONLY])
def test_times_in_columns(form, reader):
    given = (TIMES | COLUMNS_ONLY)[form]
    log = EstimatorLog.from_columns(time=given, nis=[1.0, 2.0, 3.0], nis_dof=2)
    np.testing.assert_allclose(log.columns.time, SECONDS, rtol=0, atol=1e-6)
    assert form == "Unix seconds" or log.epoch == "1970-01-01T00:00:00Z"


@pytest.mark.parametrize("form", TIMES)
def test_times_in_files(tmp_path, form, reader):
    path = tmp_path / "log.csv"
    rows = [f"{t},{k + 1.0},2" for k, t in enumerate(TIMES[form])]
    path.write_text("\n".join(["time,nis,nis_dof", *rows]) + "\n")
    np.testing.assert_allclose(read_log(path).columns.time, SECONDS, rtol=0, atol=1e-6)


@pytest.mark.parametrize("library", ["pandas", "polars"])
def test_times_in_frames(library):
    module = pytest.importorskip(library)
    moments = [
        datetime.datetime.fromtimestamp(s, datetime.UTC).replace(tzinfo=None) for s in SECONDS
    ]
    frame = module.DataFrame({"time": moments, "nis": [1.0, 2.0, 3.0], "nis_dof": [2, 2, 2]})
    log = EstimatorLog.from_frame(frame)
    np.testing.assert_allclose(log.columns.time, SECONDS, rtol=0, atol=1e-6)


def test_the_whole_column_decides_which_number_is_the_day():
    european = ["31/12/2023 23:59:59", "01/01/2024 00:00:09"]
    american = ["12/31/2023 23:59:59", "01/01/2024 00:00:09"]
    for column in (european, american):
        assert np.diff(times.to_seconds(column).seconds).tolist() == [10.0]
    with pytest.raises(ValueError, match="date_order='dmy' or date_order='mdy'"):
        times.to_seconds(["01/02/2024 00:00:00"])
    found = [
        times.to_seconds(["01/02/2024 00:00"], date_order=o).seconds[0] for o in ("dmy", "mdy")
    ]
    assert (found[0] - found[1]) / 86400 == 30.0


def test_a_unit_that_is_given_is_kept():
    log = EstimatorLog.from_columns(time=[1e12, 2e12], nis=[1.0, 2.0], nis_dof=2, time_unit="ms")
    assert log.columns.time.tolist() == [1e12, 2e12]


@pytest.mark.parametrize("form", ["diagonal", "upper", "full"])
def test_covariances_are_read_by_the_width_of_the_innovation(form):
    rng = np.random.default_rng(0)
    for m in (1, 2, 3, 4, 6, 8):
        innovation = rng.normal(size=(5, m))
        matrix = np.diag(np.arange(1.0, m + 1))
        if form == "diagonal":
            given = np.tile(matrix.diagonal(), (5, 1))
        elif form == "upper":
            given = np.tile(matrix[np.triu_indices(m)], (5, 1))
        else:
            given = np.tile(matrix.ravel(), (5, 1))
        log = EstimatorLog.from_columns(innovation=innovation, S=given)
        np.testing.assert_array_equal(log.columns.S, np.tile(matrix, (5, 1, 1)))
        assert (log.columns.nis_dof == m).all()


def test_a_covariance_of_no_known_form_is_an_error():
    with pytest.raises(ValueError, match=r"S\[0\] has shape \(5,\), expected a square matrix of"):
        EstimatorLog.from_columns(innovation=np.ones((2, 3)), S=np.ones((2, 5)))
    with pytest.raises(ValueError, match=r"covariance_forms=\{'S': 'diagonal'\}"):
        EstimatorLog.from_columns(nis=[1.0, 2.0], nis_dof=3, S=np.ones((2, 3)))
    log = EstimatorLog.from_columns(
        nis=[1.0, 2.0], nis_dof=3, S=np.ones((2, 3)), covariance_forms={"S": "diagonal"}
    )
    np.testing.assert_array_equal(log.columns.S[0], np.eye(3))


def test_rows_that_are_no_updates_are_counted():
    nis = np.tile([1.0, 0.0, 0.0, 0.0], 10) * np.arange(1, 41)
    log = EstimatorLog.from_columns(nis=nis, nis_dof=2)
    assert len(log) == 10
    assert "30 of 40 rows have a NIS of exactly 0" in log.notes[0]
    assert len(EstimatorLog.from_columns(nis=nis, nis_dof=2, on_repeats="keep")) == 40
    with pytest.raises(ValueError, match=r"nis\[1\] is exactly 0"):
        EstimatorLog.from_columns(nis=nis, nis_dof=2, on_repeats="raise")


def test_test_ratios_are_scaled_or_hinted_at():
    ratios = np.random.default_rng(0).chisquare(1, 200) / 25.0
    assert "nis_scale=" in EstimatorLog.from_columns(nis=ratios, nis_dof=1).notes[0]
    scaled = EstimatorLog.from_columns(nis=ratios, nis_dof=1, nis_scale=25.0)
    np.testing.assert_allclose(scaled.columns.nis, ratios * 25)
    assert not scaled.notes


@pytest.mark.parametrize("scale", [0, -1.0, np.nan, np.inf, True, "9"])
def test_a_scale_that_is_none_is_refused(scale):
    with pytest.raises(ValueError, match="nis_scale must be positive and finite"):
        EstimatorLog.from_columns(nis=[1.0], nis_dof=1, nis_scale=scale)


MISSING = {
    "None": [1.0, None, 3.0],
    "NaN": [1.0, np.nan, 3.0],
    "masked": np.ma.masked_array([1.0, 1e9, 3.0], [0, 1, 0]),
}


@pytest.mark.parametrize("form", MISSING)
def test_missing_values_in_columns(form):
    log = EstimatorLog.from_columns(nees=MISSING[form], nees_dof=2, nis=[1.0, 2.0, 3.0], nis_dof=1)
    assert np.isnan(log.columns.nees).tolist() == [False, True, False]


def test_missing_values_of_pandas():
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame({"time": [0, 1, 2], "nis": [1.0, 2.0, 3.0], "nis_dof": 1})
    frame["nees"] = pandas.array([1.0, None, 3.0], dtype="Float64")
    log = EstimatorLog.from_frame(frame, state_dim=2)
    assert np.isnan(log.columns.nees).tolist() == [False, True, False]


@pytest.mark.parametrize("given", [["x"] * 100_000, [object()] * 10_000, "text", [[1.0, 2.0]] * 5])
def test_messages_are_short(given):
    with pytest.raises((ValueError, TypeError)) as caught:
        EstimatorLog.from_columns(nis=given, nis_dof=2)
    assert 0 < len(str(caught.value)) <= 300


@pytest.mark.data
@pytest.mark.parametrize(
    ("name", "times_found"),
    [
        ("log_byte_order_mark.csv", [1000.0, 1010.0]),
        ("log_savetxt_heading.csv", None),
        ("log_blank_in_heading.csv", None),
    ],
)
def test_reports_of_users(data, name, times_found):
    log = read_log(data / "reports" / name)
    assert (np.diff(np.unique(log.columns.time)) == 10.0).all()
    if times_found:
        assert len(log.tracks) == 2
        assert np.unique(log.columns.time)[:2].tolist() == times_found


def test_standard_input(monkeypatch):
    class Standard:
        buffer = io.BytesIO(TEXT.encode())

    monkeypatch.setattr(opening.sys, "stdin", Standard)
    assert read_log("-").tracks == ("a", "b")
