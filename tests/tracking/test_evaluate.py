"""One pass over the pairs against the single functions; events against counts; combinations."""

import json

import numpy as np
import pytest

from trackmetrics.tracking import (
    TrackFrames,
    associate,
    average_classes,
    clear_mot,
    combine,
    evaluate,
    evaluate_sequences,
    hota,
    identity_scores,
    vace,
)
from trackmetrics.tracks import TrackTable, read_tracks


def scene(seed, n=60):
    rng = np.random.default_rng(seed)
    times, ids = np.divmod(np.arange(n * 4), 4)
    place = np.stack([times + 20.0 * ids, ids * 5.0], axis=1)
    truth = TrackTable.from_columns(time=times, id=ids, position=place)
    keep = rng.random(len(times)) < 0.8
    names = np.where(times > n // 2, ids[::-1] + 10, ids)
    noise = rng.normal(size=place.shape) * 0.5
    tracks = TrackTable.from_columns(
        time=times[keep], id=names[keep], position=(place + noise)[keep]
    )
    return truth, tracks


MEASURE = {"similarity": "euclidean", "threshold": 1.5}


@pytest.mark.parametrize("protocol", ["trackeval", "motmetrics"])
@pytest.mark.parametrize("seed", range(5))
def test_the_numbers_are_those_of_the_single_functions(seed, protocol):
    truth, tracks = scene(seed)
    found = evaluate(truth, tracks, protocol=protocol, **MEASURE)
    options = {**MEASURE, "protocol": protocol}
    assert found.clear.to_dict() == clear_mot(truth, tracks, **options).to_dict()
    assert found.identity.to_dict() == identity_scores(truth, tracks, **options).to_dict()
    assert found.hota.to_dict() == hota(truth, tracks, **MEASURE).to_dict()
    event = found.events["event"]
    counts = {"match": "tp", "miss": "fn", "false alarm": "fp", "switch": "idsw"}
    counts["fragmentation"] = "frag"
    for name, field in counts.items():
        assert (event == name).sum() == getattr(found.clear, field)
    if protocol == "motmetrics":
        assert (event == "transfer").sum() == found.clear.transfers
    assert found.objects["switches"].sum() == found.clear.idsw
    assert found.objects["matched"].sum() == found.tracks["matched"].sum() == found.clear.tp
    assert (found.events["distance"][event == "match"] <= 1.5 + 1e-12).all()
    json.dumps(found.to_dict(), allow_nan=False)
    assert len(found.to_pandas()) == len(found.to_polars()) == len(event)


def test_combined_sequences_are_one_long_sequence():
    pairs = [scene(seed) for seed in range(3)]
    together = combine([evaluate(*pair, **MEASURE) for pair in pairs])
    sides = []
    for side in (0, 1):
        tables = [pair[side] for pair in pairs]
        sides.append(
            TrackTable.from_columns(
                time=np.concatenate([t.time + 1000 * k for k, t in enumerate(tables)]),
                id=np.concatenate([t.id + 1000 * k for k, t in enumerate(tables)]),
                position=np.concatenate([t.position for t in tables]),
            )
        )
    whole = evaluate(*sides, **MEASURE)
    for name, value in whole.scores.items():
        np.testing.assert_allclose(together.scores[name], value, rtol=1e-12, err_msg=name)


def test_processes_and_threads_give_the_same_numbers():
    pairs = {f"s{seed}": scene(seed) for seed in range(3)}
    here = evaluate_sequences(pairs, **MEASURE)
    for executor in ("threads", "processes"):
        other = evaluate_sequences(pairs, executor=executor, workers=2, **MEASURE)
        assert [e.to_dict() for e in other.values()] == [e.to_dict() for e in here.values()]
    mean = average_classes(here)
    np.testing.assert_allclose(mean["mota"], np.mean([e.clear.mota for e in here.values()]))


def test_wrong_arguments_are_named():
    truth, tracks = scene(0)
    with pytest.raises(
        ValueError, match="metrics must be a list of clear, identity, hota, got 'idf1'"
    ):
        evaluate(truth, tracks, metrics=("idf1",))
    with pytest.raises(ValueError, match="truth has no boxes"):
        evaluate(truth, tracks)
    with pytest.raises(TypeError, match="tracks must be a TrackTable, got NoneType"):
        evaluate(truth)
    with pytest.raises(ValueError, match="results is empty"):
        combine([])
    with pytest.raises(TypeError, match=r"results\[0\] must be an Evaluation, got int"):
        combine([1])
    with pytest.raises(TypeError, match="metrics must be a list of clear, identity, hota"):
        evaluate(truth, tracks, metrics="clear")
    with pytest.raises(ValueError, match=r"sequences\['a'\] must be a pair"):
        evaluate_sequences({"a": (truth,)})
    dates = np.datetime64("2026-01-01", "s") + tracks.time.astype("m8[s]")
    dated = TrackTable.from_columns(time=dates, id=tracks.id, position=tracks.position)
    with pytest.raises(TypeError, match="truth has times of int64, tracks of datetime64"):
        evaluate(truth, dated, **MEASURE)


def test_every_score_takes_two_tables():
    truth, tracks = scene(0)
    frames = TrackFrames.from_tables(truth, tracks)
    assert vace(truth, tracks, **MEASURE) == vace(frames, **MEASURE)
    assert associate(truth, tracks, threshold=1.5) == associate(frames, threshold=1.5)


@pytest.mark.data
def test_a_recording_has_trackevals_numbers(data):
    folder = data / "mot/TUD-Campus"
    found = evaluate(read_tracks(folder / "gt.txt"), read_tracks(folder / "SORT.txt"))
    name = "mot15__TUD-Campus__SORT__all.trackeval.json"
    values = json.loads((data / "mot/values" / name).read_text())["iou"]
    assert found.clear.idsw == values["CLEAR"]["IDSW"]
    assert found.clear.frames == values["CLEAR"]["CLR_Frames"]
    np.testing.assert_allclose(found.clear.mota, values["CLEAR"]["MOTA"], rtol=1e-12)
    np.testing.assert_allclose(found.hota.hota_alpha, values["HOTA"]["HOTA"], rtol=1e-12)
