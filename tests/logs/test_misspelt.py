"""Columns with a typing error, and arguments of another kind, are named."""

import numpy as np
import pytest

from trackmetrics.diagnostics import diagnose
from trackmetrics.logs import EstimatorLog, read_log

ROWS = "time,nis,nis_dof,{}\n0,1.5,2,0\n1,2.5,2,0\n"


@pytest.mark.parametrize(
    ("heading", "meant"),
    [("truht[0]", "truth"), ("inovation[0]", "innovation"), ("statsu", "status")],
)
def test_a_misspelt_heading_of_a_file_is_noted(tmp_path, heading, meant):
    path = tmp_path / "run.csv"
    path.write_text(ROWS.format(heading))
    note = f"column {heading!r} is not used; did you mean {meant}?"
    assert note in read_log(path).notes
    assert note in diagnose(read_log(path)).warnings


@pytest.mark.parametrize("heading", ["comment", "sensor_temperature", "id", "a", "nis_scaled_by"])
def test_another_column_is_left_alone(tmp_path, heading):
    path = tmp_path / "run.csv"
    path.write_text(ROWS.format(heading))
    assert not any("did you mean" in note for note in read_log(path).notes)


def test_a_misspelt_column_of_a_frame_is_noted():
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame(
        {"time": [0, 1], "nis": [1.0, 2.0], "nis_dof": 2, "measurment_type": "a"}
    )
    log = EstimatorLog.from_frame(frame)
    assert log.notes == ("column 'measurment_type' is not used; did you mean measurement_type?",)


def test_a_misspelt_column_among_arguments_is_an_error():
    with pytest.raises(ValueError, match="unknown column 'truht'; did you mean truth"):
        EstimatorLog.from_columns(nis=[1.0], nis_dof=2, truht=[1.0])


@pytest.mark.parametrize("given", [{"nis": [1.0]}, "run.csv", None, np.ones(3)])
def test_a_diagnosis_of_what_is_no_log(given):
    with pytest.raises(TypeError, match=r"log must be an EstimatorLog, got .*read_log"):
        diagnose(given)


def test_dates_are_in_seconds_whatever_the_unit():
    dates = np.array(["2024-01-01T00:00:00", "2024-01-01T00:01:00"], "M8[s]")
    log = EstimatorLog.from_columns(time=dates, nis=[1.0, 2.0], nis_dof=2, time_unit="min")
    assert log.time_unit == "s"
    assert np.diff(log["track"].time) == 60.0
    counted = EstimatorLog.from_columns(time=[0, 1], nis=[1.0, 2.0], nis_dof=2, time_unit="min")
    assert counted.time_unit == "min"
    assert np.diff(counted["track"].time) == 1.0
