"""CLEAR MOT by list index against its definition, the reference, the peer and recordings."""

import itertools
import json
import math
from collections import defaultdict

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackmetrics import MOTMetrics, _check, _native, _numpy, mot_metrics

SCALES = st.sampled_from([1.0, 1e-12, 1e12, 3.7])


def by_definition(truth, estimates, threshold):
    """Straight from the definition, for points in general position of two or more dimensions: on a
    line, whole families of matchings have the same total distance."""
    switches = fragmentations = misses = false_positives = 0
    distances, remembered, history = [], {}, set()
    for x, y in zip(truth, estimates, strict=True):
        if not len(x):
            false_positives += len(y)
            continue
        pairs = {i: j for i, j in nearest(x, y) if math.dist(x[i], y[j]) <= threshold}
        distances += [math.dist(x[i], y[j]) for i, j in pairs.items()]
        switches += sum(i in remembered and remembered[i] != j for i, j in pairs.items())
        fragmentations += sum(i not in remembered and i in history for i in pairs)
        misses += len(x) - len(pairs)
        false_positives += len(y) - len(pairs)
        remembered, history = pairs, history | set(pairs)
    count = sum(map(len, truth))
    mota = 1 - (misses + false_positives + switches) / count if count else 1.0
    motp = math.fsum(distances) / len(distances) if distances else 0.0
    return mota, motp, switches, fragmentations, false_positives, misses


def nearest(x, y):
    """All pairs of the smaller set, at the least total distance over every assignment."""
    n, m = len(x), len(y)
    if n <= m:
        every = [list(enumerate(js)) for js in itertools.permutations(range(m), n)]
    else:
        every = [[(i, j) for j, i in enumerate(s)] for s in itertools.permutations(range(n), m)]
    return min(every, key=lambda pairs: sum(math.dist(x[i], y[j]) for i, j in pairs))


@given(st.integers(0, 2**32), st.integers(2, 9), SCALES)
def test_kernel_reference_and_definition_agree(seed, d, scale):
    rng = np.random.default_rng(seed)
    sizes = rng.integers(0, 5, (2, rng.integers(0, 8)))
    truth, estimates = ([rng.normal(size=(n, d)) * scale for n in side] for side in sizes)
    threshold = scale * math.sqrt(d) * rng.choice([0.5, 1.0, 2.0, np.inf])
    expected = by_definition(truth, estimates, threshold)
    packed = _check.frames("", truth), _check.frames("", estimates)
    assert _native.mot_metrics(*packed, threshold) == pytest.approx(expected, rel=1e-12)
    assert _numpy.mot_metrics(*packed, threshold) == pytest.approx(expected, rel=1e-12)


@given(st.integers(0, 2**32), st.integers(1, 4))
def test_kernel_and_reference_agree_to_the_bit_on_ties(seed, d):
    rng = np.random.default_rng(seed)
    sizes = rng.integers(0, 7, (2, 6))
    grid = rng.integers(1, 6)
    packed = [
        _check.frames("", [rng.integers(0, grid + 1, (n, d)) / 4 for n in side]) for side in sizes
    ]
    assert _native.mot_metrics(*packed, 0.5) == _numpy.mot_metrics(*packed, 0.5)


FORMS = [
    lambda frames: [[np.array(p) for p in f] for f in frames],
    lambda frames: [[tuple(p) for p in f] for f in frames],
    lambda frames: tuple(tuple(np.array(p, dtype=np.float32) for p in f) for f in frames),
    lambda frames: [np.array(f, dtype=float) for f in frames],
    lambda frames: [np.array(f, dtype=np.int8) for f in frames],
    lambda frames: [np.array(f, dtype=float)[:, None] for f in frames],
    lambda frames: [[np.array(p)[:, None] for p in f] for f in frames],
    lambda frames: np.array(frames, dtype=float),
    lambda frames: np.array(frames),
    lambda frames: np.array(frames, dtype=float, order="F"),
    lambda frames: (np.concatenate(frames).astype(float), np.arange(0, 7, 2)),
    lambda frames: (np.concatenate(frames), np.arange(0, 7, 2, dtype=np.uint8)),
]
TRUTH = [[[0, 0], [5, 5]], [[1, 0], [6, 5]], [[2, 0], [7, 5]]]
FOUND = [[[0, 1], [5, 6]], [[6, 6], [1, 1]], [[9, 9], [7, 6]]]


@pytest.mark.parametrize("truth", FORMS)
@pytest.mark.parametrize("estimates", FORMS)
def test_every_form_of_frames(truth, estimates):
    assert mot_metrics(truth(TRUTH), estimates(FOUND), 2) == by_definition(TRUTH, FOUND, 2)


def test_scalars_and_ragged_frames():
    assert mot_metrics([[0, 10], [], [1.5]], [np.array([0.0, 10.0]), [], [1]], 1) == (
        1.0,
        0.5 / 3,
        0,
        0,
        0,
        0,
    )
    assert mot_metrics(np.zeros((3, 2)), np.zeros((3, 2))).mota == 1.0
    assert mot_metrics(np.zeros((3, 0, 2)), [[], np.zeros((0, 2)), ()]).mota == 1.0


def test_results_are_python_numbers():
    results = mot_metrics([[np.zeros(2)]], [[np.ones(2)]])
    assert isinstance(results, MOTMetrics)
    assert [type(result) for result in results] == [float, float, int, int, int, int]


def test_what_pytcl_documents():
    perfect = mot_metrics(TRUTH, TRUTH)
    assert perfect == (1.0, 0.0, 0, 0, 0, 0)
    assert mot_metrics([[[0, 0]], [[1, 1]]], [[], []]) == (0.0, 0.0, 0, 0, 0, 2)
    assert mot_metrics([[], []], [[[0, 0]], [[1, 1]]]) == (1.0, 0.0, 0, 0, 2, 0)


def test_the_threshold_is_inclusive_and_may_be_infinite():
    assert mot_metrics([[0.0]], [[10.0]], 10).num_misses == 0
    assert mot_metrics([[0.0]], [[10.0]], np.nextafter(10, 0)).num_misses == 1
    assert mot_metrics([[0.0]], [[10.0]], math.inf).motp == 10.0
    assert mot_metrics([[0.0]], [[0.0]], 0).num_misses == 0


@pytest.mark.parametrize(
    ("truth", "estimates", "threshold", "error", "text"),
    [
        ([[]], [], 1, ValueError, "estimates has 0 frames, ground_truth has 1"),
        (TRUTH, FOUND, -1, ValueError, "threshold must be at least 0, got -1.0"),
        (TRUTH, FOUND, math.nan, ValueError, "threshold must be at least 0, got nan"),
        ([[], [[0, math.nan]]], [[], []], 1, ValueError, "ground_truth[1][0] is not finite: nan"),
        ([[]], [[[0.0], [-math.inf]]], 1, ValueError, "estimates[0][1] is not finite: -inf"),
        ([[[0, 0], [1]]], [[]], 1, ValueError, "ground_truth[0][1] has 1 coordinates, expected 2"),
        (
            [[np.zeros(2), np.zeros(1)]],
            [[]],
            1,
            ValueError,
            "ground_truth[0][1] has 1 coordinates, expected 2",
        ),
        (
            [np.zeros((1, 2)), np.zeros((2, 3))],
            [[], []],
            1,
            ValueError,
            "ground_truth[1][0] has 3 coordinates, expected 2",
        ),
        ([[[0, 0]]], [[[0]]], 1, ValueError, "estimates[0][0] has 1 coordinates, expected 2"),
        (
            [[], [[0, 0]]],
            [[], [[0]]],
            1,
            ValueError,
            "estimates[1][0] has 1 coordinates, expected 2",
        ),
        (np.zeros(3), [[]], 1, ValueError, "ground_truth has shape (3,), expected (T, n, d)"),
        (
            (np.zeros((2, 2)), np.array([0, 1])),
            [[]],
            1,
            ValueError,
            "ground_truth: starts must rise from 0 to 2, the number of points",
        ),
        (
            [{0: [1, 2]}],
            [[]],
            1,
            TypeError,
            "ground_truth[0] must be a list, tuple or array of points, got dict",
        ),
        (
            [[]],
            [None],
            1,
            TypeError,
            "estimates[0] must be a list, tuple or array of points, got NoneType",
        ),
        (
            None,
            [],
            1,
            TypeError,
            "ground_truth must be a list, tuple or array of sets of points, got NoneType",
        ),
        ([["a"]], [[]], 1, TypeError, "ground_truth[0][0] must hold real numbers, got dtype <U1"),
        (
            [[[]]],
            [[]],
            1,
            ValueError,
            "ground_truth[0][0] has no coordinates",
        ),
        ([[1e300]], [[-1e300]], 1, ValueError, "cost matrix is infeasible"),
    ],
)
def test_bad_arguments_are_named(truth, estimates, threshold, error, text):
    with pytest.raises(error) as raised:
        mot_metrics(truth, estimates, threshold)
    assert str(raised.value) == text


@pytest.mark.parametrize("kernels", [_native, _numpy])
def test_kernels_name_what_is_wrong_alike(kernels):
    def packed(points, starts):
        return np.array(points, dtype=float).reshape(-1, 1), np.array(starts, dtype=np.int64)

    fine = packed([1, 2], [0, 1, 1, 2])
    cases = [
        (packed([1, 2], [0, 2, 1]), "starts must rise from 0 to 2, the number of points"),
        (packed([1, 2], []), "starts must rise from 0 to 2, the number of points"),
        (packed([1, math.nan], [0, 1, 1, 2]), r"X\[2\]\[0\] is not finite: nan"),
        (packed([1], [0, 1]), "has [13] frames, ground_truth has [13]"),
        ((np.zeros((2, 2)), fine[1]), r"estimates\[0\]\[0\] has [12] coordinates, expected [12]"),
    ]
    for bad, text in cases:
        for arguments in [(bad, fine), (fine, bad)]:
            pattern = text.replace("X", "ground_truth" if arguments[0] is bad else "estimates")
            with pytest.raises(ValueError, match=pattern):
                kernels.mot_metrics(*arguments, 1.0)


def close(ours, theirs):
    assert ours[2:] == theirs[2:]
    assert ours[0] == theirs[0]
    assert ours[1] == pytest.approx(float(theirs[1]), rel=1e-12)


@pytest.mark.peers
@pytest.mark.parametrize("grid", [1, 4, 0])
def test_the_peer_agrees(grid):
    """On integer and dyadic grids, full of ties, and on points in general position."""
    from pytcl.performance_evaluation import mot_metrics as peer

    rng = np.random.default_rng(grid)
    for _ in range(700):
        d, size = rng.integers(1, 4), rng.integers(1, 9)
        sides = []
        for _ in range(2):
            sizes = rng.integers(0, size + 1, 5)
            rows = [rng.integers(0, 4, (n, d)) / (grid or 1) for n in sizes]
            sides.append(
                [[p + (rng.normal(size=d) if grid == 0 else 0) for p in frame] for frame in rows]
            )
        threshold = float(rng.choice([0.0, 0.5, 1.0, 1.5, np.inf]))
        close(mot_metrics(*sides, threshold), peer(*sides, threshold))


def frames_of(file, truth):
    """Box centres by frame, as the records were made: truth rows that count, every result row."""
    rows = defaultdict(list)
    for line in file.read_text().splitlines():
        frame, label, left, top, width, height, confidence, *_ = map(float, line.split(","))
        if not truth or confidence >= 1:
            rows[int(frame)].append((label, (left + width / 2, top + height / 2)))
    return rows


@pytest.mark.data
@pytest.mark.parametrize("name", ["KITTI-17__SORT", "TUD-Campus__SORT", "TUD-Campus__CEM"])
def test_recordings_of_boxes(data, name):
    sequence, tracker = name.split("__")
    record = json.loads((data / f"mot/values/mot15__{name}__conf1.pytcl.json").read_text())
    truth = frames_of(data / f"mot/{sequence}/gt.txt", truth=True)
    found = frames_of(data / f"mot/{sequence}/{tracker}.txt", truth=False)
    assert_record(record, "px", truth, found)


def kitti_frames(file, where):
    rows = defaultdict(list)
    for line in file.read_text().splitlines():
        words = line.split()
        if words[2] == "Car":
            numbers = list(map(float, words[6:16]))
            rows[int(words[0])].append((int(words[1]), where(numbers)))
    return rows


def box_centre(numbers):
    left, top, right, bottom = numbers[:4]
    return left + (right - left) / 2, top + (bottom - top) / 2


@pytest.mark.data
@pytest.mark.parametrize("sequence", ["0012", "0014"])
@pytest.mark.parametrize(
    ("unit", "where"), [("px", box_centre), ("m3", lambda numbers: numbers[7:10])]
)
def test_recordings_of_cars(data, sequence, unit, where):
    record = json.loads((data / f"mot/values/kitti__{sequence}__3DMOT__Car.pytcl.json").read_text())
    truth = kitti_frames(data / f"mot/KITTI-{sequence}/gt_label_02.txt", where)
    found = kitti_frames(data / f"mot/KITTI-{sequence}/3DMOT.txt", where)
    assert_record(record, unit, truth, found)


def assert_record(record, unit, truth, found):
    entries = [name for name in record if name.startswith(f"mot_metrics {unit} ")]
    assert len(entries) >= 2
    for entry in entries:
        threshold = float(entry.split("threshold=")[1].split()[0])
        key = (lambda row: row[0]) if "sorted by id" in entry else (lambda row: 0)
        sides = [
            [[point for _, point in sorted(side[t], key=key)] for t in record["frames"]]
            for side in (truth, found)
        ]
        expected = MOTMetrics(**record[entry])
        close(mot_metrics(*sides, threshold), expected)
