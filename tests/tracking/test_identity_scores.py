"""CLEAR MOT, identity scores and HOTA against the peers: recordings, cases, random scenes."""

import itertools
import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackmetrics.tracking import TrackFrames, clear_mot, hota, identity_scores
from trackmetrics.tracks import read_mot_challenge

CLEAR = {
    **{"MOTA": "mota", "MOTP": "motp", "MODA": "moda", "CLR_Re": "recall", "CLR_Pr": "precision"},
    **{"MTR": "mtr", "PTR": "ptr", "MLR": "mlr", "sMOTA": "smota", "CLR_F1": "f1"},
    **{"FP_per_frame": "fp_per_frame", "MOTAL": "motal", "MOTP_sum": "motp_sum", "CLR_TP": "tp"},
    **{"CLR_FN": "fn", "CLR_FP": "fp", "IDSW": "idsw", "MT": "mt", "PT": "pt", "ML": "ml"},
    **{"Frag": "frag", "CLR_Frames": "frames"},
}
IDENTITY = {name.upper(): name for name in ("idf1", "idr", "idp", "idtp", "idfn", "idfp")}
HOTA_SERIES = ("HOTA", "DetA", "AssA", "DetRe", "DetPr", "AssRe", "AssPr", "LocA", "OWTA")
HOTA = {
    **{name: f"{name.lower()}_alpha" for name in HOTA_SERIES},
    **{"HOTA_TP": "tp_alpha", "HOTA_FN": "fn_alpha", "HOTA_FP": "fp_alpha"},
    **{"HOTA(0)": "hota_0", "LocA(0)": "loca_0", "HOTALocA(0)": "hotaloca_0"},
}
MOTMETRICS = {
    **{"num_frames": "frames", "num_detections": "tp", "num_switches": "idsw"},
    **{"num_transfer": "transfers", "num_ascend": "ascends", "num_migrate": "migrates"},
    **{"num_false_positives": "fp", "num_misses": "fn", "mostly_tracked": "mt"},
    **{"partially_tracked": "pt", "mostly_lost": "ml", "num_fragmentations": "frag"},
    **{name: name for name in ("motp", "mota", "precision", "recall")},
}
MOTMETRICS_IDENTITY = {name: name for name in IDENTITY.values()}
# TrackEval leaves these 0 where a whole side is empty; ours are the true values.
UNSET_BY_TRACKEVAL = ("CLR_Frames", "FP_per_frame")

PAIRS = {
    **{
        f"mot15__{place}__{tracker}__{variant}": (f"{place}/gt.txt", f"{place}/{tracker}.txt")
        for place, tracker in (("TUD-Campus", "CEM"), ("TUD-Campus", "SORT"), ("KITTI-17", "SORT"))
        for variant in ("all", "conf1")
    },
    "mot17__MOT17-09-FRCNN__MoTT__pp": ("MOT17-09/gt_pp.txt", "MOT17-09/MoTT_pp.txt"),
    **{
        f"kitti__{place}__3DMOT__{variant}": tuple(f"KITTI-{place}/{file}" for file in files)
        for place in ("0012", "0014")
        for variant, files in (
            ("Car", ("gt_label_02.txt", "3DMOT.txt")),
            ("pp", ("gt_pp_xyxy.txt", "3DMOT_pp_xyxy.txt")),
        )
    },
}
MEASURES = {"iou": ("iou", 0.5), "euc": ("euclidean", 50.0), "euc3d": ("euclidean", 2.0)}


def assert_same(ours, theirs, names):
    """Counts exactly, ratios to 1e-12; JSON writes NaN as null and infinities as strings."""
    ours = ours.to_dict()
    for name, expected in theirs.items():
        if name not in names:
            continue
        found = ours[names[name]]
        if expected is None or isinstance(expected, str) or isinstance(found, int):
            assert found == expected, (name, found, expected)
        else:
            np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12, err_msg=name)
    assert names.keys() <= theirs.keys()


def assert_trackeval(frames, values, **measure):
    clear = values["CLEAR"]
    names = dict(CLEAR)
    if not len(frames.truth) or not len(frames.tracks):
        names = {key: name for key, name in CLEAR.items() if key not in UNSET_BY_TRACKEVAL}
    assert_same(clear_mot(frames, **measure), clear, names)
    assert_same(identity_scores(frames, **measure), values["Identity"], IDENTITY)
    found = hota(frames, **measure)
    assert_same(found, values["HOTA"], HOTA)
    if "HOTA_mean" in values:
        means = {name: name.lower() for name in HOTA_SERIES}
        assert_same(found, values["HOTA_mean"], means)


def assert_motmetrics(frames, values, **measure):
    assert_same(clear_mot(frames, **measure, protocol="motmetrics"), values, MOTMETRICS)
    scores = identity_scores(frames, **measure, protocol="motmetrics")
    assert_same(scores, values, MOTMETRICS_IDENTITY)


def read_kitti(path, classes):
    rows = [line.split() for line in path.read_text().splitlines()]
    rows = [row for row in rows if row[2] in classes]
    numbers = np.array([[float(x) for x in row[:2] + row[6:10] + row[13:16]] for row in rows])
    return numbers[:, 0].astype(int), numbers[:, 1].astype(int), numbers[:, 2:6], numbers[:, 6:]


def read_pair(folder, name, measure, times):
    truth_path, track_path = (folder / file for file in PAIRS[name])
    variant = name.rpartition("__")[2]
    if not name.startswith("kitti"):
        truth, tracks = read_mot_challenge(truth_path), read_mot_challenge(track_path)
        truth = truth.counted() if variant == "conf1" else truth
        return TrackFrames.from_boxes(truth, tracks, times=times)
    if variant == "Car":
        truth, tracks = read_kitti(truth_path, ["Car"]), read_kitti(track_path, ["Car"])
    else:
        sides = (np.loadtxt(path, delimiter=",") for path in (truth_path, track_path))
        truth, tracks = ((t[:, 0].astype(int), t[:, 1].astype(int), t[:, 2:], None) for t in sides)
    positions = measure == "euc3d"
    return TrackFrames.from_columns(
        *truth[:2],
        *tracks[:2],
        truth_boxes=truth[2],
        track_boxes=tracks[2],
        truth_positions=truth[3] if positions else None,
        track_positions=tracks[3] if positions else None,
        box_format="ltrb",
        times=times,
    )


@pytest.mark.data
@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("peer", ["trackeval", "motmetrics"])
def test_recordings_have_the_peers_numbers(data, name, peer):
    values = json.loads((data / f"mot/values/{name}.{peer}.json").read_text())
    measures = [measure for measure in MEASURES if measure in values]
    assert len(measures) == (3 if name.endswith("Car") else 2)
    counts = values["counts"]
    times = range(counts["first_frame"], counts["first_frame"] + counts["num_frames"])
    if peer == "motmetrics" and name.startswith("kitti"):
        times = None  # py-motmetrics was given the frames that have a row
    for measure in measures:
        frames = read_pair(data / "mot", name, measure, times)
        assert len(frames.truth) == counts["n_gt_rows"]
        assert len(frames.tracks) == counts["n_result_rows"]
        similarity, threshold = MEASURES[measure]
        check = assert_trackeval if peer == "trackeval" else assert_motmetrics
        check(frames, values[measure], similarity=similarity, threshold=threshold)


@pytest.mark.data
def test_every_recording_is_tested(data):
    for peer in ("trackeval", "motmetrics"):
        files = {
            path.name.split(".")[0] for path in (data / "mot/values").glob(f"*__*.{peer}.json")
        }
        assert files == PAIRS.keys()


def scene(frames):
    """TrackFrames and matrices of a list of (truth ids, track ids, similarities)."""
    columns = [[], [], [], []]
    matrices = []
    for t, (truth, tracks, similarity) in enumerate(frames):
        columns[0] += [t] * len(truth)
        columns[1] += list(truth)
        columns[2] += [t] * len(tracks)
        columns[3] += list(tracks)
        matrices.append(np.array(similarity, dtype=float).reshape(len(truth), len(tracks)))
    return TrackFrames.from_columns(*columns, times=range(len(frames))), matrices


@pytest.mark.data
@pytest.mark.parametrize("peer", ["trackeval", "motmetrics"])
def test_corner_cases_have_the_peers_numbers(data, peer):
    cases = json.loads((data / "mot/values/micro_cases.json").read_text())
    values = json.loads((data / f"mot/values/micro.{peer}.json").read_text())
    assert len(cases) == 29
    for name, case in cases.items():
        frames, matrices = scene([(f["gt"], f["tracker"], f["similarity"]) for f in case])
        check = assert_trackeval if peer == "trackeval" else assert_motmetrics
        check(frames, values[name], similarity=matrices)


LEVELS = (0.0, 0.2, 0.5 - 2**-40, 0.5 - 2**-53, 0.5 - 2**-54, 0.5, 0.5 + 2**-53, 0.75, 1.0)


@st.composite
def scenes(draw):
    """Frames of changing ids with similarities that tie with each other and with the threshold."""
    size = st.integers(0, 4)
    level = st.one_of(st.sampled_from(LEVELS), st.floats(0, 1))
    frames = []
    for _ in range(draw(st.integers(1, 8))):
        truth = draw(st.permutations(range(4)))[: draw(size)]
        tracks = draw(st.permutations(range(10, 15)))[: draw(size)]
        count = len(truth) * len(tracks)
        frames.append((truth, tracks, draw(st.lists(level, min_size=count, max_size=count))))
    return frames


def long_scene(seed):
    """Targets that are born, die, pause and swap their tracks, as boxes that jitter."""
    rng = np.random.default_rng(seed)
    names, frames = np.arange(12), []
    for _ in range(60):
        truth = rng.permutation(12)[: rng.integers(0, 13)]
        if rng.random() < 0.15:
            names[rng.permutation(12)[:2]] = names[rng.permutation(12)[:2]]
        present = truth[rng.random(len(truth)) < 0.85]
        tracks = np.unique(np.concatenate([names[present] + 100, rng.integers(112, 120, 2)]))
        tracks = rng.permutation(tracks)
        near = names[truth][:, None] + 100 == tracks
        noise = rng.random(near.shape)
        similarity = np.where(near, 0.3 + 0.7 * noise, np.where(noise < 0.7, 0, noise))
        frames.append((truth.tolist(), tracks.tolist(), np.round(similarity, seed % 3 + 1)))
    return frames


def trackeval_values(frames, matrices):
    from trackeval.metrics import CLEAR, HOTA, Identity

    truth, tracks = frames.truth, frames.tracks
    data = {
        "num_timesteps": len(frames),
        "num_gt_ids": len(truth.names),
        "num_tracker_ids": len(tracks.names),
        "num_gt_dets": len(truth),
        "num_tracker_dets": len(tracks),
        "gt_ids": np.split(truth.ids, truth.starts[1:-1]),
        "tracker_ids": np.split(tracks.ids, tracks.starts[1:-1]),
        "similarity_scores": matrices,
    }
    config = {"PRINT_CONFIG": False}
    metrics = {"CLEAR": CLEAR(config), "Identity": Identity(config), "HOTA": HOTA()}
    return {name: metric.eval_sequence(data) for name, metric in metrics.items()}


def motmetrics_values(frames, matrices):
    import motmetrics

    accumulator = motmetrics.MOTAccumulator(auto_id=True)
    sides = (np.split(side.ids, side.starts[1:-1]) for side in (frames.truth, frames.tracks))
    for truth, tracks, matrix in zip(*sides, matrices, strict=True):
        distances = 1 - matrix
        distances[distances > 0.5] = np.nan
        with motmetrics.lap.set_default_solver("scipy"):  # others break ties in other ways
            accumulator.update(truth, tracks, distances)
    host = motmetrics.metrics.create()
    names = [*MOTMETRICS, *MOTMETRICS_IDENTITY]
    values = host.compute(accumulator, metrics=names, return_dataframe=False)
    return {name: as_json(float(value)) for name, value in values.items()}


def as_json(value):
    if math.isnan(value):
        return None
    return value if math.isfinite(value) else str(value)


@pytest.mark.peers
@given(scenes())
def test_random_scenes_have_trackevals_numbers(listed):
    frames, matrices = scene(listed)
    assert_trackeval(frames, trackeval_values(frames, matrices), similarity=matrices)


@pytest.mark.peers
@given(scenes())
def test_random_scenes_have_motmetrics_numbers(listed):
    frames, matrices = scene(listed)
    assert_motmetrics(frames, motmetrics_values(frames, matrices), similarity=matrices)


@pytest.mark.peers
@pytest.mark.parametrize("seed", range(9))
def test_long_scenes_have_the_peers_numbers(seed):
    frames, matrices = scene(long_scene(seed))
    assert_trackeval(frames, trackeval_values(frames, matrices), similarity=matrices)
    assert_motmetrics(frames, motmetrics_values(frames, matrices), similarity=matrices)


@pytest.mark.peers
def test_trackeval_reports_no_frames_without_tracks():
    frames, matrices = scene([([], [1, 2], []), ([], [], [])])
    theirs = trackeval_values(frames, matrices)["CLEAR"]
    ours = clear_mot(frames, similarity=matrices)
    assert (theirs["CLR_Frames"], theirs["FP_per_frame"]) == (0, 0)
    assert (ours.frames, ours.fp_per_frame) == (2, 1.0)


@given(scenes())
def test_identity_scores_are_the_best_of_all_assignments(listed):
    frames, matrices = scene(listed)
    names = frames.truth.names, frames.tracks.names
    together = dict.fromkeys(itertools.product(*names), 0)
    for (truth, tracks, _), matrix in zip(listed, matrices, strict=True):
        for i, j in np.argwhere(matrix >= 0.5):
            together[truth[i], tracks[j]] += 1
    few, many = sorted(names, key=len)
    swapped = few is not names[0]
    best = max(
        sum(together[(b, a) if swapped else (a, b)] for a, b in zip(few, chosen, strict=True))
        for chosen in itertools.permutations(many, len(few))
    )
    assert identity_scores(frames, similarity=matrices).idtp == best
