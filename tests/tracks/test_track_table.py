"""Track tables: made from everything, refused with a message, written and read back."""

import datetime
from types import SimpleNamespace

import numpy as np
import pandas
import polars
import pytest

from trackmetrics.tracks import TrackTable, read_mot_challenge, read_tracks

BOXES = [[0.0, 0, 4, 2], [9, 9, 2, 2], [1.1, 0, 4, 2.7]]


def table(**more):
    columns = {"time": [2, 1, 1], "id": [7, 7, 8], "box": BOXES}
    return TrackTable.from_columns(**columns | more)


def assert_equal(a, b):
    first, second = a.columns(), b.columns()
    assert first.keys() == second.keys()
    assert first["other"].keys() == second["other"].keys()
    for name in first.keys() - {"other"}:
        np.testing.assert_array_equal(first[name], second[name], err_msg=name)
    for name, column in first["other"].items():
        np.testing.assert_array_equal(column, second["other"][name], err_msg=name)


def test_a_repeated_row_names_both():
    with pytest.raises(ValueError, match="rows 1 and 2 both have time 1 and id 7"):
        table(id=[7, 7, 7])


def test_ids_of_any_kind_stay_what_they_are():
    made = table(id=[("a", 1), "1", 1])
    assert made.names == (("a", 1), "1", 1)
    assert made.with_ids([1]).box.tolist() == [BOXES[2]]


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"time": [1, np.nan, 3]}, r"time\[1\] is nan"),
        ({"id": [1, 2]}, "id has 2 rows, time has 3"),
        ({"id": [1, [2], 3]}, r"id\[1\] must be a label that can be hashed, got list"),
        ({"box": [[1, 2, 3]] * 3}, r"box has shape \(3, 3\), expected \(3, 4\)"),
        ({"box": [[1, 2, 3, np.inf]] * 3}, r"box\[0\]\[3\] is not finite: inf"),
        ({"box_format": "xyxy"}, "box_format must be 'ltwh' or 'ltrb'"),
        ({"mask": ["abc"] * 3}, "mask_size must be"),
    ],
)
def test_wrong_columns_are_named(wrong, message):
    with pytest.raises((ValueError, TypeError), match=message):
        table(**wrong)


def test_selection_by_time_id_and_class():
    made = table(cls=["car", "van", "car"], score=[1, 0.5, 0.25])
    assert made.between(2).id.tolist() == [7]
    assert made.between(last=1).score.tolist() == [0.5, 0.25]
    assert made.with_classes(["car"]).time.tolist() == [2, 1]
    assert made.rows(slice(1, 3)).names == (7, 8)
    assert made.without("score").score is None


def test_corners_and_three_dimensions():
    made = table(box=[[1, 2, 5, 8]] * 3, box_format="ltrb")
    assert made.box[0].tolist() == [1, 2, 4, 6]
    made = table(box=np.arange(21.0).reshape(3, 7))
    assert made.box is None
    assert made.box_3d.shape == (3, 7)


@pytest.mark.parametrize("library", [pandas.DataFrame, polars.DataFrame, None])
def test_data_frames_and_dicts(library):
    columns = table(score=[1.0, 0.5, 0.25]).to_dict()
    if library is None:
        made = TrackTable.from_dict({name: c.tolist() for name, c in columns.items()})
    else:
        made = TrackTable.from_frame(library(columns))
    assert_equal(made, table(score=[1.0, 0.5, 0.25]))


def test_columns_under_other_names():
    frame = polars.DataFrame({"t": [1], "mmsi": ["007"], "lon": [2.0], "lat": [3.0], "note": ["a"]})
    names = {"time": "t", "id": "mmsi", "position": ["lon", "lat"]}
    made = TrackTable.from_frame(frame, columns=names)
    assert made.names == ("007",)
    assert made.position.tolist() == [[2.0, 3.0]]
    assert made.other["note"].tolist() == ["a"]
    with pytest.raises(ValueError, match="no column 'longitude' for position"):
        TrackTable.from_frame(frame, columns=names | {"position": ["longitude", "lat"]})


def test_frames_and_detections():
    frames = [{"id": [1, 2], "box": BOXES[:2]}, {}, {"id": [1], "box": BOXES[2:]}]
    made = TrackTable.from_frames(frames)
    assert made.time.tolist() == [0, 0, 2]
    found = [
        SimpleNamespace(
            xyxy=np.array([[0.0, 0, 4, 2]]),
            tracker_id=np.array([3]),
            confidence=np.array([0.5]),
            class_id=None,
            mask=None,
        )
    ]
    assert TrackTable.from_detections(found).box.tolist() == [[0, 0, 4, 2]]
    found[0].tracker_id = None
    with pytest.raises(ValueError, match=r"detections\[0\] has no tracker_id"):
        TrackTable.from_detections(found)


@pytest.mark.peers
def test_stone_soup_tracks_and_paths():
    from stonesoup.types.groundtruth import GroundTruthPath, GroundTruthState
    from stonesoup.types.state import GaussianState
    from stonesoup.types.track import Track

    start = datetime.datetime(2024, 1, 1)
    states = [GroundTruthState([[i], [1], [2], [3]], timestamp=start) for i in (1, 2)]
    made = TrackTable.from_stone_soup([GroundTruthPath(states)], position=(0, 2), velocity=(1, 3))
    assert made.position.tolist() == [[2.0, 2.0]]
    assert made.velocity.tolist() == [[1.0, 3.0]]
    track = Track([GaussianState([[1], [2]], np.diag([3, 4]), timestamp=start)], id="a")
    made = TrackTable.from_stone_soup([track], position=(0,))
    assert made.covariance.tolist() == [[[3.0]]]
    assert made.names == ("a",)


def full():
    return table(
        **{"cls": ["Car", "Van", "Car"], "score": [0.5, 0.25, 1]},
        **{"position": [[1.5, 2.25, 3]] * 3, "box_3d": [[3, -1.5, 0.75, 4, 2, 1.5, 0.5]] * 3},
    )


@pytest.mark.parametrize("backend", ["polars", "small"])
@pytest.mark.parametrize(
    ("made", "file", "form"),
    [
        (table(), "a.txt", "motchallenge"),
        (table(score=[1, 0.5, 0]), "a.txt", "motchallenge"),
        (table(score=[1, 1, 0], position=[[1, 2, 3.5]] * 3), "a.txt", "motchallenge"),
        (
            table(score=[1, 1, 0], cls=[1, 7, 1], other={"visibility": np.array([1, 0.5, 0])}),
            "a.txt",
            "motchallenge",
        ),
        (full(), "a.csv", None),
        (full(), "a.parquet", None),
        (
            table(time=np.array(["2024-01-01T00:00:01", "2024-01-02", "2024-01-02"], "M8[us]")),
            "a.csv",
            None,
        ),
        (table(id=["a", "b", "c"]), "a.csv", None),
    ],
)
def test_written_files_read_the_same(tmp_path, monkeypatch, made, file, form, backend):
    if backend == "small":
        if file.endswith("parquet"):
            return
        for module in ("_tables.delimited", "tracks.cells"):
            monkeypatch.setattr(f"trackmetrics.{module}.polars", lambda: None)
    made.write(tmp_path / file, format=form)
    assert_equal(read_tracks(tmp_path / file), made)


def test_kitti_labels_of_regions_and_cars(tmp_path):
    text = (
        "0 -1 DontCare -1 -1 -10 1 2 3.5 4 -1000 -1000 -1000 -10 -1 -1 -1\n"
        "0 -1 DontCare -1 -1 -10 1 2 3.5 4 -1000 -1000 -1000 -10 -1 -1 -1\n"
        "0 2 Car 1 0 0.25 1.1 2.3 3.5 4.7 1.5 1.75 4.25 -4.125 1.875 30.5 0.023919\n"
    )
    (tmp_path / "a.txt").write_text(text)
    made = read_tracks(tmp_path / "a.txt")
    assert made.id.tolist() == [-1, -2, 2]
    assert made.box_3d[2, :6].tolist() == [30.5, 4.125, -1.125, 4.25, 1.75, 1.5]
    made.write(tmp_path / "b.txt", format="kitti")
    again = read_tracks(tmp_path / "b.txt")
    assert_equal(again, made)
    numbers = np.array((tmp_path / "b.txt").read_text().split()[37:], float)
    np.testing.assert_allclose(numbers, np.array(text.split()[37:], float), rtol=1e-14)


def test_kitti_mots_masks(tmp_path):
    pixels = np.zeros((2, 5, 6), bool)
    pixels[0, 1:3, 2:4] = pixels[1, 4, :] = True
    made = TrackTable.from_columns(time=[0, 1], id=[1001, 1001], cls=[1, 1], mask=pixels)
    made.write(tmp_path / "a.txt", format="kitti_mots")
    again = read_tracks(tmp_path / "a.txt")
    assert_equal(again, made)
    np.testing.assert_array_equal(again.pixels(), pixels)


def test_a_format_refuses_what_it_cannot_hold(tmp_path):
    with pytest.raises(
        ValueError, match=r"MOTChallenge files have no column velocity: leave it out"
    ):
        table(velocity=[[1.0]] * 3).write(tmp_path / "a.txt", format="motchallenge")
    with pytest.raises(ValueError, match=r"id\[0\] must be a whole number in this format, got 'a'"):
        table(id=["a", "b", "c"]).write(tmp_path / "a.txt", format="motchallenge")
    with pytest.raises(ValueError, match=r"format must be given for 'a\.txt'"):
        table().write(tmp_path / "a.txt")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1,1,0,0,2,2\n\n1,2,x,0,2,2\n", "a.txt:3: left must be a number, got 'x'"),
        (
            "1,1,0,0,2,2\n1,2,0,0,2\n",
            "a.txt:2: expected frame,id,left,top,width,height and more, got 5",
        ),
        ("1,1,0,0,2,2\n1,2,0,0,2,2,1\n", "a.txt:2: expected 6 columns as in line 1, got 7"),
        ("1,1,0,0,2,2\n\n1,1,0,0,2,2\n", "a.txt:3: frame 1 has id 1 twice, first on line 1"),
        ("0 1 Car 0 0 0 1 2 3 4\n", "a.txt:1: expected frame,id,type"),
    ],
)
def test_wrong_lines_are_named(tmp_path, text, message):
    (tmp_path / "a.txt").write_text(text)
    with pytest.raises(ValueError, match=message):
        read_tracks(tmp_path / "a.txt")


@pytest.mark.data
@pytest.mark.parametrize(
    "file", ["TUD-Campus/gt.txt", "TUD-Campus/SORT.txt", "MOT17-09/MoTT_pp.txt", "KITTI-17/gt.txt"]
)
def test_recordings_in_the_form_of_motchallenge(data, tmp_path, file):
    made, boxes = read_tracks(data / "mot" / file), read_mot_challenge(data / "mot" / file)
    np.testing.assert_array_equal(made.box, boxes.boxes)
    made.write(tmp_path / "a.txt", format="motchallenge")
    assert_equal(read_tracks(tmp_path / "a.txt"), made)


@pytest.mark.data
@pytest.mark.parametrize("file", ["gt_label_02.txt", "3DMOT.txt"])
def test_recordings_in_the_form_of_kitti(data, tmp_path, file):
    made = read_tracks(data / "mot/KITTI-0012" / file)
    made.write(tmp_path / "a.txt", format="kitti")
    again = read_tracks(tmp_path / "a.txt")
    np.testing.assert_allclose(again.box_3d, made.box_3d, rtol=1e-13)
    np.testing.assert_array_equal(again.box, made.box)
    np.testing.assert_array_equal(again.id, made.id)


MASKED = np.ma.masked_array([1, 2], [False, True])


@pytest.mark.parametrize(
    ("changed", "error", "message"),
    [
        ({"time": MASKED}, ValueError, r"time\[1\] is masked"),
        ({"id": MASKED}, ValueError, r"id\[1\] is masked"),
        ({"time": [object(), 1]}, TypeError, "time must hold numbers or dates"),
        ({"covariance": np.ones((2, 3))}, ValueError, r"\(2, 3\), expected \(2, 2, 2\)"),
        ({"covariance": np.ones((2, 4))}, ValueError, r"\(2, 4\), expected \(2, 2, 2\)"),
        ({"covariance": np.ones((2, 3, 3))}, ValueError, r"\(2, 3, 3\), expected \(2, 2, 2\)"),
        ({"box": [[0, 0, 1, 1], [5, 5, -1, 1]]}, ValueError, r"box\[1\] is -1 wide and 1 high"),
        (
            {"box": [[5, 5, 1, 1], [0, 0, 1, 1]], "box_format": "ltrb"},
            ValueError,
            r"box\[0\] is -4 wide",
        ),
        ({"box_format": "xywh"}, ValueError, "box_format must be 'ltwh' or 'ltrb', got 'xywh'"),
    ],
)
def test_what_is_no_track_is_named(changed, error, message):
    columns = {"time": [1, 2], "id": [1, 1], "position": [[0, 0], [1, 0]]}
    with pytest.raises(error, match=message):
        TrackTable.from_columns(**{**columns, **changed})


def test_covariances_come_back_from_a_file_as_matrices(tmp_path):
    covariance = [[[2.0, 0.5], [0.5, 1.0]], [[3.0, 0.0], [0.0, 4.0]]]
    table = TrackTable.from_columns(
        time=[1, 2], id=[1, 1], position=[[0, 0], [1, 0]], covariance=covariance
    )
    table.write(tmp_path / "tracks.csv")
    np.testing.assert_array_equal(read_tracks(tmp_path / "tracks.csv").covariance, covariance)
