"""What is wrong in files and columns: each kind is an error that names it, in both readers."""

import datetime

import numpy as np
import pytest

from trackmetrics._tables import delimited, json_lines, polars_columns, times
from trackmetrics.logs import EstimatorLog, State, read_log

HEADING = "time,nis,nis_dof\n"


@pytest.fixture(params=["polars", "small"])
def read(request, monkeypatch, tmp_path):
    """Reads text as a file, by Polars or by the small readers."""
    if request.param == "small":
        for module in (delimited, json_lines, polars_columns, times):
            monkeypatch.setattr(module, "polars", lambda: None)

    def read(text, suffix=".csv", **header):
        path = tmp_path / f"log{suffix}"
        path.write_text(text, newline="")
        return read_log(path, **header)

    return read


MANY = "".join(f"{k},2,2\n" for k in range(3000))
WRONG_TEXT = {
    "only a heading": (HEADING, "the log is empty"),
    "a short row": (HEADING + "1,2,2\n2,3\n3,4,2\n", "row 1: 2 cells, the header has 3"),
    "a short row with quotes": (HEADING + '1,"2",2\n2,3\n', "row 1: 2 cells"),
    "a long row": (HEADING + "1,2,2\n2,3,2,9\n", "row 1: 4 cells, the header has 3"),
    "text for a number": (HEADING + "1,2,2\n2,abc,2\n", r"nis\[1\] must be a number, got 'abc'"),
    "text far down": (HEADING + MANY + "3000,abc,2\n", r"nis\[3000\] must be a number"),
    "text for a time": (HEADING + "1,2,2\nlater,3,2\n", r"time\[1\] is no time: 'later'"),
    "no time in a row": (HEADING + "1,2,2\n,3,2\n", r"time\[1\] is not finite"),
    "no value in a row": (HEADING + MANY + "3000,NA,2\n", "row 3000 holds no value"),
    "infinity": (HEADING + "1,inf,2\n", r"nis\[0\] is not finite"),
    "no headings": ("1,2,2\n2,3,2\n", "no headings .its first row is 1, 2, 2"),
    "no headings of savetxt": ("1.0e0 2.0e0 2e0\n2.0e0 2.5e0 2e0\n", "no headings"),
    "one column twice": ("time,nis,NIS,nis_dof\n1,2,3,2\n", "'nis' and 'NIS' name one column"),
    "a unit in the heading": ("Time (s),nis,nis_dof\n1,2,2\n", r"did you mean 'Time \(s\)'"),
    "another delimiter": ("time|nis|nis_dof\n1|2|2\n", r"headings are time\|nis\|nis_dof"),
    "an element is missing": ("time,x[0],x[2]\n1,2,2\n", r"no column x\[1\], although .*x\[2\]"),
    "thousands": ("time;nis;nis_dof\n1.000,5;2;2\n", r"time\[0\] is no time: '1.000,5'"),
    "ambiguous dates": (HEADING + "01/02/2024 10:00,2,2\n", "date_order='dmy'"),
    "no date": (HEADING + "31/02/2024 10:00,2,2\n", r"time\[0\] is no time"),
    "13 o'clock PM": (HEADING + "12/31/2023 13:00 PM,2,2\n", r"time\[0\] is no time"),
    "a clock alone": (HEADING + "10:00:00,2,2\n", r"time\[0\] is no time: '10:00:00'"),
    "falling times": (HEADING + "2,2,2\n1,3,2\n", "row 1 is at 1.0, row 0 at 2.0"),
    "every NIS is 0": (HEADING + "1,0,2\n2,0,2\n", "all 2 NIS are exactly 0"),
    "two readings": ("time,nis,nis_dof,S[0],S[1],S[2]\n1,1,2,3,4,5\n", "upper or diagonal"),
}


@pytest.mark.parametrize("kind", WRONG_TEXT)
def test_wrong_text(read, kind):
    text, message = WRONG_TEXT[kind]
    with pytest.raises(ValueError, match=message) as caught:
        read(text)
    assert str(caught.value).startswith("log.csv")
    assert len(str(caught.value)) <= 300


WRONG_JSON = {
    "cut off": ('{"time":1,"nis":2,"nis_dof":2}\n{"time":2,"nis":3,"nis_d', "line 2: .*cut off"),
    "a name twice": ('{"time":1,"nis":2,"nis":5,"nis_dof":2}\n', "line 1: 'nis' appears twice"),
    "no object": ('{"time":1,"nis":2,"nis_dof":2}\n[1, 2]\n', "line 2: expected a JSON object"),
    "no times": ('{"nis":2,"nis_dof":2}\n', "no column time"),
    "a list for a text": ('{"track":["a"],"time":1,"nis":2,"nis_dof":2}\n', r"track\[0\]"),
    "text": ('{"time":1,"nis":"abc","nis_dof":2}\n', r"nis\[0\] must be a number, got 'abc'"),
}


@pytest.mark.parametrize("kind", WRONG_JSON)
def test_wrong_json(read, kind):
    text, message = WRONG_JSON[kind]
    with pytest.raises(ValueError, match=message) as caught:
        read(text, ".jsonl")
    assert len(str(caught.value)) <= 300


RIGHT_TEXT = {
    "blank lines": "\n\n" + HEADING + "1,2,2\n\n2,3,2\n\n",
    "line ends of old Macs": (HEADING + "1,2,2\n2,3,2\n").replace("\n", "\r"),
    "no line end": HEADING + "1,2,2\n2,3,2",
    "more columns": 'time,nis,nis_dof,remark\n1,2,2,"a, b"\n2,3,2,NA\n',
    "quoted numbers": '"time","nis","nis_dof"\n"1","2","2"\n"2","3","2"\n',
    "padded": "time , nis , nis_dof\n 1 , 2 , 2\n 2 , 3 , 2\n",
    "separator line": "sep=;\ntime;nis;nis_dof\n1;2;2\n2;3;2\n",
}


@pytest.mark.parametrize("kind", RIGHT_TEXT)
def test_right_text(read, kind):
    log = read(RIGHT_TEXT[kind])
    assert log.columns.time.tolist() == [1.0, 2.0]
    assert log.columns.nis.tolist() == [2.0, 3.0]


def test_what_comes_late_in_a_file_is_read(read):
    decimals = HEADING + MANY + "3000.5,2.5,2\n"
    assert read(decimals).columns.nis[-1] == 2.5
    missing = "time,nis,nis_dof,nees,nees_dof\n" + MANY.replace("\n", ",3,3\n") + "3000,2,2,NA,3\n"
    assert np.isnan(read(missing).columns.nees).sum() == 1
    records = "".join(f'{{"time":{k},"nis":2,"nis_dof":2}}\n' for k in range(20000))
    late = '{"time":20000,"nis":3,"nis_dof":2,"nees":4,"nees_dof":2}\n'
    assert read(records + late, ".jsonl").columns.nees[-1] == 4.0


LATER = {
    "MATLAB": ["31-Dec-2023 23:59:59", "01-Jan-2024 00:00:09"],
    "12-hour clock": ["12/31/2023 11:59:59 PM", "01/01/2024 12:00:09 AM"],
    "compact ISO": ["20231231T235959Z", "20240101T000009Z"],
    "hours of a zone": ["2024-01-01T01:59:59+02", "2024-01-01T02:00:09+02"],
    "dots": ["31.12.2023 23:59:59", "01.01.2024 00:00:09"],
}


@pytest.mark.parametrize("form", LATER)
def test_more_forms_of_dates(read, form):
    rows = [f"{moment},{k + 1},2" for k, moment in enumerate(LATER[form])]
    log = read(HEADING + "\n".join(rows) + "\n")
    assert log.columns.time.tolist() == [1704067199.0, 1704067209.0]


DURATIONS = {
    "timedelta64": np.array([0, 10], "m8[s]"),
    "timedelta": [datetime.timedelta(0), datetime.timedelta(seconds=10)],
}


@pytest.mark.parametrize("form", DURATIONS)
def test_durations_are_seconds_without_an_epoch(form):
    log = EstimatorLog.from_columns(time=DURATIONS[form], nis=[1.0, 2.0], nis_dof=2)
    assert log.columns.time.tolist() == [0.0, 10.0]
    assert log.epoch is None


def test_dates_are_midnights():
    dates = [datetime.date(1970, 1, 1), datetime.date(1970, 1, 2)]
    log = EstimatorLog.from_columns(time=dates, nis=[1.0, 2.0], nis_dof=2)
    assert log.columns.time.tolist() == [0.0, 86400.0]


THREE = {"innovation": np.ones((2, 3)), "x": np.ones((2, 2)), "truth": np.zeros((2, 2))}
WRONG_HEADERS = {
    "state_dim": [0, -1, True, 2.5, "2", np.nan],
    "time_unit": [3, True],
    "states": ["xy", [""], [3], [State("")], [State("a", period=-1.0)], [State("a", period=True)]],
    "angles": [[360], {"x[0]": 0}, {"x[0]": np.nan}, {"x[0]": "360"}, {"x[0]": True}, {"y": 360.0}],
    "measurement_angles": [[1], {"m": [1]}, {"m": {0: np.nan}}, {"m": {0: -1}}, {"m": {0.5: 1}}],
    "covariance_forms": ["diagonal", {"Q": "full"}, {"S": "diag"}],
    "on_repeats": ["x", None],
    "nis_scale": [0, np.nan, "2", True],
}


@pytest.mark.parametrize(
    ("argument", "given"), [(a, g) for a, values in WRONG_HEADERS.items() for g in values]
)
def test_headers_refuse_what_cannot_be_meant(argument, given):
    with pytest.raises((ValueError, TypeError), match=argument) as caught:
        EstimatorLog.from_columns(**THREE, S=np.tile(np.eye(3), (2, 1, 1)), **{argument: given})
    assert len(str(caught.value)) <= 300


@pytest.mark.parametrize("given", [np.tile(np.eye(2), (2, 1, 1)), [np.eye(2)] * 2])
def test_a_covariance_never_drops_a_component(given):
    with pytest.raises(ValueError, match=r"S\[0\] is 2 x 2, .* 3 components"):
        EstimatorLog.from_columns(innovation=np.ones((2, 3)), S=given)


@pytest.mark.parametrize("given", [3.0, np.array(1.0), (v for v in [1.0])])
def test_a_log_needs_rows(given):
    with pytest.raises(ValueError, match="no column has rows"):
        EstimatorLog.from_columns(nis=given, nis_dof=2)


def test_standard_deviations_are_not_negative():
    with pytest.raises(ValueError, match=r"std\[1\]\[0\] must be at least 0, got -1.0"):
        EstimatorLog.from_columns(x=[[1.0], [2.0]], std=[[1.0], [-1.0]])


def test_a_frame_that_is_none_is_named():
    with pytest.raises(TypeError, match=r"frame must be a data frame .* got builtins.dict"):
        EstimatorLog.from_frame({"time": [0.0], "nis": [1.0]})


def test_names_of_tracks_as_bytes():
    log = EstimatorLog.from_columns(track=np.array([b"a", b"b"]), nis=[1.0, 2.0], nis_dof=2)
    assert log.tracks == ("a", "b")


def test_a_covariance_alone_tells_the_number_of_states(read):
    record = '{"time":0,"nis":1,"nis_dof":1,"P":[[1,0],[0,1]]}\n'
    assert read(record, ".jsonl").columns.P.shape == (1, 2, 2)
    mixed = record + '{"time":1,"nis":1,"nis_dof":1,"P":null}\n'
    assert np.isnan(read(mixed, ".jsonl").columns.P[1]).all()
    assert read('{"time":0,"nis":1,"nis_dof":1,"P":null}\n', ".jsonl").columns.nis.tolist() == [1.0]


def test_lists_and_something_else_in_one_column(read):
    text = '{"time":0,"x":[1.0,2.0],"std":[1,1]}\n{"time":1,"x":"","std":[1,1]}\n'
    with pytest.raises(ValueError, match=r"x\[1\] must hold numbers, got ''"):
        read(text, ".jsonl")
