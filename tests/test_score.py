"""``trackmetrics score`` and its reader, on recordings and on broken files."""

import itertools
import json
import pathlib

import numpy as np
import pytest

from trackmetrics.cli import main
from trackmetrics.tracking import paired_labels
from trackmetrics.tracks import Boxes, read_mot_challenge

TRUTH = "1,1,0,0,2,2,1\n1,2,10,0,2,2,1\n2,1,1,0,2,2,1\n2,2,10,0,2,2,1\n3,3,0,0,2,2,0\n"
TRACKS = "1,7,0,3,2,2,-1,-1,-1,-1\n1,8,10,4,2,2,-1,-1,-1,-1\n2,8,1,0,2,2,-1,-1,-1,-1\n"


@pytest.fixture
def files(tmp_path):
    """Writes two files and returns their names."""

    def write(truth=TRUTH, tracks=TRACKS):
        paths = tmp_path / "gt.txt", tmp_path / "tracks.txt"
        for path, text in zip(paths, (truth, tracks), strict=True):
            path.write_bytes(text.encode() if isinstance(text, str) else text)
        return [str(path) for path in paths]

    return write


def scores(capsys, *arguments):
    assert main(["score", *arguments, "--format", "json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_a_scene_by_hand(files, capsys):
    found = scores(capsys, *files(), "--threshold", "5", "--cutoff", "20", "--order", "1")
    assert found == {
        "threshold": 5.0,
        "cutoff": 20.0,
        "order": 1.0,
        "frames": 2,
        "true_boxes": 4,
        "true_ids": 2,
        "track_boxes": 3,
        "track_ids": 2,
        "ospa_mean": (3.5 + 10) / 2,
        "ospa_worst": 10.0,
        "ospa_worst_frame": 2,
        "misses": 1,
        "false_alarms": 0,
        "motp": pytest.approx(7 / 3),
        "track_purity": pytest.approx(2 / 3),
        "track_fragmentation": 1,
        "identity_switches": 1,
    }


def test_the_table_has_every_number_and_no_meaningless_one(files, capsys):
    assert main(["score", *files()]) == 0
    told = capsys.readouterr()
    table = told.out
    assert "2 frames" in told.err
    for text in ["70.71 px", "in frame 2", "of 4 boxes", "0.6667", "MOTP"]:
        assert text in table
    assert "MOTA" not in table


def test_the_help_says_why_there_is_no_accuracy(capsys):
    assert main(["score", "--help"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "fragmentations and MOTA are not printed" in text


@pytest.mark.parametrize(
    ("truth", "text"),
    [
        ("1,1,0,0,2\n", ":1: expected frame,id,left,top,width,height and more, got 5 columns"),
        ("1,1,0,0,2,2\n\n1,2,x,0,2,2\n", ":3: left must be a number, got 'x'"),
        ("1,1,0,0,2,2\n1,2,0,nan,2,2\n", ":2: top must be finite, got nan"),
        ("1.5,1,0,0,2,2\n", ":1: frame must be a whole number, got 1.5"),
        ("1,1e300,0,0,2,2\n", ":1: id must be a whole number, got 1e+300"),
        (TRUTH + "2,1,0,0,2,2\n", ":6: frame 2 has id 1 twice, first on line 3"),
        (b"\xff\xfe\x00", " is not utf-16 text: truncated data"),
    ],
)
def test_a_malformed_file_is_one_line_and_status_2(files, capsys, truth, text):
    paths = files(truth)
    assert main(["score", *paths]) == 2
    output = capsys.readouterr()
    assert output.out == ""
    name = paths[0] if text.startswith(":") else pathlib.Path(paths[0]).name
    assert output.err == f"trackmetrics score: {name}{text}\n"


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (["--threshold", "-1"], "threshold must be at least 0, got -1.0"),
        (["--cutoff", "0"], "c must be positive, got 0.0"),
        (["--order", "nan"], "p must be positive, got nan"),
    ],
)
def test_a_bad_option_is_one_line_and_status_2(files, capsys, options, text):
    assert main(["score", *files(), *options]) == 2
    assert capsys.readouterr().err == f"trackmetrics score: {text}\n"


def test_a_file_that_is_not_there_is_one_line(capsys):
    assert main(["score", "nowhere.txt", "nowhere.txt"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_files_without_boxes(files, capsys):
    assert main(["score", *files("", "")]) == 2
    assert "neither file has a box that counts" in capsys.readouterr().err
    found = scores(capsys, *files("", TRACKS))
    assert (found["ospa_mean"], found["false_alarms"], found["track_purity"]) == (100.0, 3, None)
    found = scores(capsys, *files(TRUTH, "\n"))
    assert (found["ospa_mean"], found["misses"], found["track_purity"]) == (100.0, 4, None)


def test_reader(files):
    path = files("\ufeff1, 5 ,1.5,2,3,4\r\n\r\n2,-1,0,0,1,1,0.3,9,9,9\r\n")[0]
    boxes = read_mot_challenge(path)
    assert boxes.frames.tolist() == [1, 2]
    assert boxes.ids.tolist() == [5, -1]
    np.testing.assert_array_equal(boxes.centres, [[3.0, 4.0], [0.5, 0.5]])
    np.testing.assert_array_equal(boxes.confidence, [np.nan, 0.3])
    assert len(boxes.counted()) == 1


def boxes_at(points):
    n = len(points)
    corners = np.column_stack([points, np.zeros_like(points)])
    return Boxes(np.ones(n, dtype=np.int64), np.arange(n), corners, np.ones(n))


def test_pairs_are_as_many_and_then_as_near_as_can_be():
    rng = np.random.default_rng(1)
    for _ in range(200):
        n, m = (int(size) for size in rng.integers(1, 5, 2))
        x, y = rng.uniform(0, 10, (n, 2)), rng.uniform(0, 10, (m, 2))
        distances = np.linalg.norm(x[:, None] - y[None], axis=-1)
        every = (
            [(i, j) for i, j in zip(rows, columns, strict=True) if distances[i, j] <= 4]
            for rows in itertools.permutations(range(n), min(n, m))
            for columns in itertools.permutations(range(m), min(n, m))
        )
        best = min(every, key=lambda pairs: (-len(pairs), sum(distances[p] for p in pairs)))
        places = [(np.arange(n), np.arange(m))]
        true, estimated, _ = paired_labels(boxes_at(x), boxes_at(y), places, 4.0)
        assert list(zip(true, estimated, strict=True)) == sorted(best)


@pytest.mark.data
@pytest.mark.parametrize(
    ("sequence", "tracker"), [("TUD-Campus", "SORT"), ("TUD-Campus", "CEM"), ("KITTI-17", "SORT")]
)
def test_recordings(data, capsys, sequence, tracker):
    folder = data / "mot" / sequence
    record = json.loads(
        (data / f"mot/values/mot15__{sequence}__{tracker}__conf1.pytcl.json").read_text()
    )
    found = scores(capsys, str(folder / "gt.txt"), str(folder / f"{tracker}.txt"))
    counts, frames = record["counts"], record["px c=100 p=2"]["ospa"]
    assert found["frames"] == counts["num_frames"]
    assert (found["true_boxes"], found["track_boxes"]) == (
        counts["n_gt_rows"],
        counts["n_result_rows"],
    )
    assert found["ospa_mean"] == pytest.approx(record["px c=100 p=2"]["mean_ospa"], rel=1e-12)
    assert found["ospa_worst"] == pytest.approx(max(frames), rel=1e-12)
    assert found["ospa_worst_frame"] == record["frames"][int(np.argmax(frames))]
    by_index = record["mot_metrics px threshold=50 (file order within frame)"]
    assert found["misses"] == by_index["num_misses"]
    assert found["false_alarms"] == by_index["num_false_positives"]
    assert found["motp"] == pytest.approx(by_index["motp"], rel=1e-12)
    assert found["track_purity"] == record["track_purity"]
    for name in ["track_fragmentation", "identity_switches"]:
        assert found[name] == record[name] == record[f"{name}_with_time"]
