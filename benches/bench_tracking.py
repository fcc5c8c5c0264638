"""Scores over identities, against pytcl, TrackEval, py-motmetrics and motrics.

python benches/bench_tracking.py [--save]
"""

import threading

import motmetrics
import motrics
import numpy as np
import trackeval
from pytcl.performance_evaluation import track_metrics as pytcl

import trackmetrics
from harness import Bench
from trackmetrics.tracking import PROTOCOLS, TrackFrames
from trackmetrics.tracking.clear_mot import clear_mot_of
from trackmetrics.tracking.hota import hota_of
from trackmetrics.tracking.identity_scores import identity_scores_of
from trackmetrics.tracking.similarity import pair_measure

LABELS = ("track_purity", "track_fragmentation", "identity_switches")


def all_labels(module, true, estimated):
    return [getattr(module, name)(true, estimated) for name in LABELS]


def bench_labels(bench: Bench) -> None:
    rng = np.random.default_rng(1)
    for k in (10, 100, 1000):
        true = rng.integers(0, k, 1_000_000)
        estimated = np.where(rng.random(true.size) < 0.9, true, rng.integers(0, k, true.size))
        assert all_labels(trackmetrics, true, estimated) == all_labels(pytcl, true, estimated)
        bench.compare(
            f"three label metrics, 1e6 labels, ids 0..{k - 1}",
            lambda t=true, e=estimated: all_labels(trackmetrics, t, e),
            {"pytcl": lambda t=true, e=estimated: all_labels(pytcl, t, e)},
            target=100 if k == 1000 else None,
            seconds=10,
            rounds=3,
        )
    ids = rng.integers(-(2**63), 2**63 - 1, 1000)
    wide, also = ids[true], ids[estimated]
    assert all_labels(trackmetrics, wide, also) == all_labels(trackmetrics, true, estimated)
    bench.compare(
        "three label metrics, 1e6 labels, 1000 arbitrary int64 ids",
        lambda: all_labels(trackmetrics, wide, also),
        {"pytcl": lambda: all_labels(pytcl, wide, also)},
        seconds=10,
        rounds=3,
    )


def scene(frames, n, rng):
    """Targets in a box of 1000, each found within some metres, and in another order each time."""
    truth = [list(rng.uniform(0, 1000, (n, 2))) for _ in range(frames)]
    found = [[x[i] + rng.normal(0, 5, 2) for i in rng.permutation(n)] for x in truth]
    return truth, found


def bench_mot_metrics(bench: Bench) -> None:
    rng = np.random.default_rng(2)
    for n in (5, 10, 20, 50):
        truth, found = scene(1000, n, rng)
        unrelated, _ = scene(1000, n, rng)
        assert_close(truth, found)
        assert_close(truth, unrelated)
        for what, other in {"tracked": found, "unrelated": unrelated}.items():
            bench.compare(
                f"mot_metrics, lists, 1000 frames x {n}, {what}",
                lambda x=truth, y=other: trackmetrics.mot_metrics(x, y),
                {"pytcl": lambda x=truth, y=other: pytcl.mot_metrics(x, y)},
                target=200 if n == 10 and what == "tracked" else None,
                seconds=4,
                rounds=5,
            )
    packed = np.array(truth), np.array(found)
    bench.compare(
        "mot_metrics, (T, n, d) arrays, 1000 frames x 50",
        lambda: trackmetrics.mot_metrics(*packed),
        {"mot_metrics, lists": lambda: trackmetrics.mot_metrics(truth, found)},
    )


def assert_close(truth, found):
    ours, theirs = trackmetrics.mot_metrics(truth, found), pytcl.mot_metrics(truth, found)
    assert ours[2:] == theirs[2:]
    assert np.allclose(ours, theirs, rtol=1e-12)


def box_scene(frames, n, seed=3):
    """Boxes in an image of 1000 x 1000, and tracks that jitter, miss, change ids and see things."""
    rng = np.random.default_rng(seed)
    steps = rng.normal(0, 2, (frames, n, 2)).cumsum(axis=0)
    corners = rng.uniform(0, 1000, (n, 2)) + steps
    sizes = np.broadcast_to(rng.uniform(40, 120, (n, 2)), corners.shape)
    boxes = np.concatenate([corners, sizes], axis=2)
    names = (rng.random((frames, n)) < 0.12).cumsum(axis=0) * n + np.arange(n)
    t, i = np.nonzero(rng.random((frames, n)) < 0.93)
    found = boxes[t, i] + rng.normal(0, 4, (len(t), 4))
    noise = np.unique(rng.integers(0, frames * 50, max(1, frames * n // 15)))
    false = np.concatenate(
        [rng.uniform(0, 1000, (len(noise), 2)), rng.uniform(40, 120, (len(noise), 2))], axis=1
    )
    return TrackFrames.from_columns(
        np.repeat(np.arange(frames), n),
        np.tile(np.arange(n), frames),
        np.concatenate([t, noise // 50]),
        np.concatenate([names[t, i], 10**7 + noise % 50]),
        truth_boxes=boxes.reshape(-1, 4),
        track_boxes=np.concatenate([found, false]),
    )


def all_families(frames, protocol="trackeval"):
    measure = pair_measure(frames, "iou", 0.5)
    rules = PROTOCOLS[protocol]
    return clear_mot_of(measure, rules), identity_scores_of(measure, rules), hota_of(measure)


def by_frame(side):
    return np.split(side.ids, side.starts[1:-1]), np.split(side.boxes, side.starts[1:-1])


def with_trackeval(frames):
    (ids, boxes), (others, found) = by_frame(frames.truth), by_frame(frames.tracks)
    iou = trackeval.datasets._base_dataset._BaseDataset._calculate_box_ious
    metrics = trackeval.metrics
    data = {
        "num_timesteps": len(frames),
        "num_gt_ids": len(frames.truth.names),
        "num_tracker_ids": len(frames.tracks.names),
        "num_gt_dets": len(frames.truth),
        "num_tracker_dets": len(frames.tracks),
        "gt_ids": ids,
        "tracker_ids": others,
    }
    families = (metrics.CLEAR, metrics.Identity)
    families = [family({"PRINT_CONFIG": False}) for family in families] + [metrics.HOTA()]

    def evaluate():
        pairs = zip(boxes, found, strict=True)
        similarity = [iou(x, y, box_format="xywh") for x, y in pairs]
        scores = {**data, "similarity_scores": similarity}
        return [family.eval_sequence(dict(scores)) for family in families]

    return evaluate


def with_motmetrics(frames):
    # py-motmetrics 1.4.0 uses a name that NumPy 2 no longer has.
    np.asfarray = getattr(np, "asfarray", lambda values: np.asarray(values, dtype=float))  # noqa: NPY201
    (ids, boxes), (others, found) = by_frame(frames.truth), by_frame(frames.tracks)
    names = [*motmetrics.metrics.motchallenge_metrics]

    def evaluate():
        accumulator = motmetrics.MOTAccumulator(auto_id=True)
        for i, x, j, y in zip(ids, boxes, others, found, strict=True):
            accumulator.update(i, j, motmetrics.distances.iou_matrix(x, y, max_iou=0.5))
        host = motmetrics.metrics.create()
        return host.compute(accumulator, metrics=names, return_dataframe=False)

    return evaluate


def with_motrics(frames):
    (ids, boxes), (others, found) = by_frame(frames.truth), by_frame(frames.tracks)
    lists = [[part.tolist() for part in side] for side in (ids, others)]
    sides = [
        motrics.Frames(ids=codes, boxes=list(rows))
        for codes, rows in zip(lists, (boxes, found), strict=True)
    ]
    return lambda: motrics.evaluate(*sides, box_format="xywh")


def bench_identities(bench: Bench) -> None:
    frames = box_scene(1000, 30)
    peers = {"TrackEval": with_trackeval(frames), "motrics": with_motrics(frames)}
    clear, identity, hota = all_families(frames)
    theirs, fast = peers["TrackEval"](), peers["motrics"]()
    counts = clear.tp, clear.idsw, identity.idtp
    assert counts == (theirs[0]["CLR_TP"], theirs[0]["IDSW"], theirs[1]["IDTP"])
    assert np.isclose(hota.hota, theirs[2]["HOTA"].mean(), rtol=1e-12)
    assert np.isclose(fast.hota.hota, hota.hota, rtol=1e-9)
    name = f"CLEAR + Identity + HOTA, 1000 x 30, {len(frames.tracks.names)} track ids, boxes"
    bench.compare(name, lambda: all_families(frames), peers, {"TrackEval": 90, "motrics": 40})
    slow = with_motmetrics(frames)
    ours = clear_and_identity(frames)
    values = slow()
    assert (ours[0].idsw, ours[0].fn) == (values["num_switches"], values["num_misses"])
    assert np.isclose(ours[1].idf1, values["idf1"], rtol=1e-12)
    bench.compare(
        name.replace(" + HOTA", ""),
        lambda: clear_and_identity(frames),
        {"py-motmetrics": slow},
        target=150,
        seconds=20,
        rounds=3,
    )


def clear_and_identity(frames):
    measure, rules = pair_measure(frames, "iou", 0.5), PROTOCOLS["motmetrics"]
    return clear_mot_of(measure, rules), identity_scores_of(measure, rules)


def bench_two_threads(bench: Bench) -> None:
    sequences = [box_scene(1000, 30, seed) for seed in range(8)]

    def threaded():
        halves = sequences[::2], sequences[1::2]
        threads = [threading.Thread(target=lambda s=s: list(map(all_families, s))) for s in halves]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()

    bench.compare(
        "CLEAR + Identity + HOTA, 8 sequences, two threads",
        threaded,
        {"one thread": lambda: list(map(all_families, sequences))},
        target=1.8,
    )


def bench_million_boxes(bench: Bench) -> None:
    frames = box_scene(2000, 500)
    bench.compare(
        f"CLEAR + Identity + HOTA, {len(frames.truth):,} + {len(frames.tracks):,} boxes",
        lambda: all_families(frames),
        {"the pairs alone": lambda: pair_measure(frames, "iou", 0.5).pairs},
        rounds=3,
    )


if __name__ == "__main__":
    bench = Bench("tracking")
    bench_mot_metrics(bench)
    bench_labels(bench)
    bench_identities(bench)
    bench_two_threads(bench)
    bench_million_boxes(bench)
    bench.finish()
