"""Vessels: many tracks, their lives, and the places where naive trackers break."""

import numpy as np
import pytest

import trackmetrics
from trackmetrics import vessel
from trackmetrics.diagnostics import diagnose
from trackmetrics.vessel import Noise, Reports, Settings, Tracker

KT = 1852 / 3600
TEN_MINUTES = range(0, 600, 60)


@pytest.fixture
def native():
    """For tests of statistics: the reference gives the same numbers, a hundred times later."""
    with trackmetrics.use_backend("native"):
        yield


def straight(name="Tern", lat=50.0, lon=1.0, speed=12.0, course=90.0, times=TEN_MINUTES, **columns):
    """Exact reports of a vessel on a straight course along the local plane."""
    times = np.array(times, float)
    way = speed * KT * times / 111_200
    north, east = way * np.cos(np.radians(course)), way * np.sin(np.radians(course))
    lons = lon + east / np.cos(np.radians(lat))
    return Reports.from_columns(
        **{
            "time": times,
            "lat": lat + north,
            "lon": (lons + 180) % 360 - 180,
            "sog": np.full(len(times), speed),
            "cog": np.full(len(times), course % 360),
            "vessel": [name] * len(times),
            **columns,
        }
    )


def tracked(reports, settings=None):
    tracker = Tracker(settings)
    tracker.add(reports)
    return tracker


def without_nan(log):
    """Every active row is finite in everything."""
    for track in log:
        rows = log[track]
        active = rows.status == "active"
        assert np.isfinite(rows.x).all()
        assert np.isfinite(rows.P).all()
        assert np.isfinite(rows.nis[active]).all()
        assert np.isfinite(rows.A[active]).all()
        assert (np.linalg.eigvalsh(rows.P / _outer(rows.P)) > 0).all()
    return log


def _outer(p):
    d = np.sqrt(np.einsum("nii->ni", p))
    return d[:, :, None] * d[:, None, :]


# ------------------------------------------------------------------ consistency


@pytest.mark.usefixtures("native")
def test_the_consistent_filter_is_expected_decibels():
    """200 vessels: NIS/dof and NEES/5 are 1 within four standard errors of independent ones."""
    log = vessel.fleet(200, duration=5400.0, report_interval=(60.0, 300.0), seed=3).track()
    active = log.columns.status == "active"
    dof = log.columns.nis_dof[active].sum()
    assert log.columns.nis[active].sum() / dof == pytest.approx(1, abs=4 * np.sqrt(2 / dof))
    # NEES of one track is correlated; its last values of 200 vessels are not.
    last = [log[track].nees[-1] for track in log]
    assert np.mean(last) / 5 == pytest.approx(1, abs=4 * np.sqrt(2 / (5 * len(last))))


@pytest.mark.usefixtures("native")
def test_manoeuvres_and_outages_are_found_out():
    calm = diagnose(vessel.fleet(12, duration=7200.0, seed=1).track())
    wild = vessel.fleet(12, duration=7200.0, seed=1, manoeuvres=2.0, turn_rate=0.2, outage_rate=1.0)
    assert sum(t.verdict == "consistent" for t in calm.values()) >= 10
    assert sum(t.verdict == "consistent" for t in diagnose(wild.track()).values()) <= 4


@pytest.mark.usefixtures("native")
@pytest.mark.parametrize(
    ("noise", "falcon", "aurora"),
    [
        ("consistent", "startup_then_consistent", "consistent"),
        ("published", "startup_then_pessimistic", "pessimistic"),
    ],
)
def test_the_three_ships_fail_as_published(noise, falcon, aurora):
    """20 of the 200 seeds of ``benches/rates_vessel.py``, with the sampling error of its rates."""
    found = [diagnose(vessel.three_ships(seed, noise).track()) for seed in range(20)]
    northern = [d["SS Northern Star0"] for d in found]
    assert sum(d.verdict == "late_divergence" for d in northern) >= 19
    assert sum(d.nis.onset_time == 6780.0 for d in northern) >= 18
    assert sum(d["SS Iron Aurora1"].verdict == aurora for d in found) >= 18
    assert sum(d["MV Iron Falcon2"].verdict == falcon for d in found) >= 13


def test_the_support_is_that_of_the_published_run():
    ships = vessel.THREE_SHIPS
    assert [len(ship.times) for ship in ships] == [28, 24, 11]
    assert [ship.kinds.count(0) for ship in ships] == [15, 10, 4]
    assert [ship.kinds.count(3) for ship in ships] == [12, 13, 7]
    assert all(len(ship.times) == len(ship.kinds) for ship in ships)


@pytest.mark.data
def test_the_support_is_in_the_published_data(data):
    import csv

    kinds = {"AISMeasurement": 0, "TruncatedAISMeasurement": 2, "PositionMeasurement": 3}
    with (data / "published_run" / "updates.csv").open() as file:
        rows = [
            (r["track"], float(r["t_rel_s"]), kinds[r["measurement_type"]])
            for r in csv.DictReader(file)
        ]
    for ship in vessel.THREE_SHIPS:
        seen = [(t, k) for name, t, k in rows if name == ship.name]
        assert seen == list(zip(ship.times, ship.kinds, strict=True))


def test_a_seed_gives_one_run():
    a, b, c = (vessel.fleet(3, seed=s) for s in (5, 5, 6))
    assert np.array_equal(a.truth["ship 2"], b.truth["ship 2"])
    assert not np.array_equal(a.paths["ship 2"], c.paths["ship 2"])
    more = vessel.fleet(5, seed=5)
    assert np.array_equal(a.reports["ship 2"].z, more.reports["ship 2"].z, equal_nan=True)


def test_both_backends_track_alike():
    with trackmetrics.use_backend("numpy"):
        reference = vessel.three_ships(2).track()
    with trackmetrics.use_backend("native"):
        ours = vessel.three_ships(2).track()
    assert np.allclose(ours.columns.nis, reference.columns.nis, rtol=1e-6, equal_nan=True)


# ------------------------------------------------------------------ the life of a track


def test_a_life():
    tracker = tracked(straight(times=[0, 60, 120]))
    statuses = [tracker.tracks(at)[0].status for at in (120, 720.5, 3720.5)]
    assert statuses == ["active", "coasting", "deleted"]
    assert tracked(straight(times=[0, 60])).tracks()[0].status == "tentative"
    log = tracker.log()
    assert log["Tern"].status.tolist() == ["tentative", "tentative", "active"]
    assert np.isnan(log["Tern"].nis[:2]).all()


def test_speed_and_course_come_from_two_positions():
    reports = straight(times=[0, 300], sog=None, cog=None, speed=10.0, course=120.0)
    assert reports.kinds == ("truncated AIS", "truncated AIS")
    track = tracked(reports).tracks()[0]
    assert track.x[2] == pytest.approx(10.0, rel=0.01)
    assert track.x[3] == pytest.approx(120.0, abs=0.5)
    sigma = np.hypot(30, 30) / 300 / KT
    assert np.sqrt(track.P[2, 2]) == pytest.approx(sigma)
    assert np.sqrt(track.P[3, 3]) == pytest.approx(np.degrees(sigma / track.x[2]))


def test_trust_missing_values_are_taken_for_known():
    settings = Settings(trust_missing_values=True)
    track = tracked(straight(times=[0], sog=None, cog=None), settings).tracks()[0]
    assert track.x[2:].tolist() == [0.0, 360.0, 0.0]
    assert np.sqrt(np.diag(track.P))[2:].tolist() == [3.0, 10.0, 0.5]


def test_an_hour_of_silence_ends_a_track():
    log = tracked(straight(times=[0, 60, 120, 3721, 3781])).log()
    assert log.tracks == ("Tern", "Tern#2")
    assert log["Tern#2"].status.tolist() == ["tentative", "tentative"]


@pytest.mark.parametrize(
    ("sog", "cog", "kind"),
    [
        (10.0, 359.9, "AIS"),
        (10.0, 360.0, "truncated AIS"),
        (102.3, 10.0, "truncated AIS"),
        (np.nan, 10.0, "truncated AIS"),
        (0.9, 10.0, "AIS without course"),
    ],
)
def test_what_is_not_available_is_not_used(sog, cog, kind):
    reports = straight(times=[0], sog=[sog], cog=[cog])
    assert reports.kinds == (kind,)


def test_a_track_without_an_update_is_diagnosed_as_too_little():
    log = tracked(Reports.concatenate([straight(), straight(times=[300], vessel=["Gull"])])).log()
    assert diagnose(log)["Gull"].verdict == "insufficient"
    assert diagnose(tracked(straight(times=[0, 60])).log())["Tern"].verdict == "insufficient"


# ------------------------------------------------------------------ hard places


def test_across_the_antimeridian():
    log = without_nan(tracked(straight(lat=-17.0, lon=179.99, speed=20.0)).log())
    rows = log["Tern"]
    assert rows.x[0, 1] > 179 > -179 > rows.x[-1, 1]
    assert np.nanmax(rows.nis) < 0.1


def test_at_85_degrees():
    log = without_nan(tracked(straight(lat=85.0, course=45.0)).log())
    assert np.nanmax(log["Tern"].nis) < 4.0


def test_at_the_pole_nothing_is_infinite():
    without_nan(tracked(straight(lat=89.97, course=0.0, times=range(0, 300, 60))).log())


def test_a_stationary_vessel():
    """It has no course, and no turn of the state makes it move away."""
    rng = np.random.default_rng(0)
    n = 400
    reports = straight(
        speed=0.0,
        times=np.arange(n) * 10.0,
        lat=50 + rng.normal(size=n) * 10 / 111_000,
        lon=1 + rng.normal(size=n) * 10 / 71_000,
        cog=rng.uniform(0, 360, n),
        sog=np.abs(rng.normal(0, 0.1, n)),
    )
    rows = without_nan(tracked(reports).log())["Tern"]
    assert set(rows.measurement_type) == {"AIS without course"}
    assert np.abs(rows.x[:, 0] - 50).max() < 0.001
    assert np.nanmean(rows.nis / rows.nis_dof) < 1.2


def test_half_an_hour_of_silence():
    rows = without_nan(tracked(straight(times=[0, 60, 120, 180, 1980, 2040])).log())["Tern"]
    assert rows.status.tolist() == ["tentative"] * 2 + ["active"] * 4
    assert rows.P_pred[4, 3, 3] > 50 * rows.P_pred[3, 3, 3]
    assert rows.nis[4] < 4.0


def test_reports_out_of_order_in_one_call_are_sorted():
    reports = straight()
    order = np.random.default_rng(1).permutation(len(reports))
    shuffled = tracked(reports.take(order))
    assert np.array_equal(shuffled.log()["Tern"].x, tracked(reports).log()["Tern"].x)
    assert len(shuffled.late) == 0


def test_a_late_report_is_counted_and_not_used():
    reports = straight()
    tracker = tracked(reports.take(np.array([0, 1, 2, 3, 5])))
    before = tracker.tracks()[0].x
    tracker.add(reports.take(np.array([4])))
    assert tracker.late.tolist() == [5]
    assert np.array_equal(tracker.tracks()[0].x, before)
    assert len(tracker.log()) == 5


def test_two_vessels_with_one_mmsi():
    """Their tracks are those that they would have under two names."""
    a, b = straight(times=range(0, 600, 60)), straight(lat=51.0, times=range(30, 630, 60))
    tracker = tracked(Reports.concatenate([a, b]))
    log = without_nan(tracker.log())
    assert log.tracks == ("Tern", "Tern#2")
    assert tracker.duplicate_mmsi == ("Tern",)
    assert np.array_equal(log["Tern#2"].x, tracked(b).log()["Tern"].x)
    assert np.array_equal(log["Tern"].x, tracked(a).log()["Tern"].x)


def test_one_jump_is_a_tentative_track_of_its_own():
    reports = straight()
    reports.z[5, 1] += 55.9
    tracker = tracked(reports)
    assert tracker.duplicate_mmsi == ()
    assert [(t.name, t.status) for t in tracker.tracks()] == [
        ("Tern", "active"),
        ("Tern#2", "tentative"),
    ]


def test_two_updates_at_one_time_stand_apart():
    a = straight(times=[0, 60, 120])
    log = tracked(Reports.concatenate([a, a.take(np.array([2]))])).log()
    assert (np.diff(log["Tern"].time) > 0).all()
    assert log["Tern"].time[-1] == pytest.approx(120.0)


def test_a_bad_call_changes_nothing():
    tracker = tracked(straight())
    bad = straight(times=[700.0, 760.0])
    bad.z[1, 0] = np.nan
    with pytest.raises(ValueError, match=r"^lat of the report at time 760\.0 is not finite: nan$"):
        tracker.add(bad)
    assert len(tracker.log()) == 10
    with pytest.raises(ValueError, match=r"truth has shape \(2, 4\), expected \(10, 5\)"):
        tracker.add(straight(), truth=np.zeros((2, 4)))
    with pytest.raises(ValueError, match="the log is empty"):
        Tracker().log()


# ------------------------------------------------------------------ positions without identity


def anonymous(ships, times, rng, sigma=20.0):
    """Positions of straight ships, all of them at each time, in random order."""
    tables = [straight(times=times, **ship) for ship in ships]
    stacked = np.stack([t.z[:, :2] for t in tables])
    z = stacked + rng.normal(size=stacked.shape) * sigma / [111_000, 71_000]
    order = np.stack([rng.permutation(len(ships)) for _ in times], axis=1)
    z = np.take_along_axis(z, order[..., None], axis=0)
    flat = z.swapaxes(0, 1).reshape(-1, 2)
    time = np.repeat(np.array(times, float), len(ships))
    return Reports.from_columns(time=time, lat=flat[:, 0], lon=flat[:, 1]), order


def test_positions_without_identity_find_their_tracks():
    """Twelve ships in parallel, 1 km apart: one track each, from the first scan to the last."""
    ships = [{"lat": 50 + 0.009 * k, "speed": 12.0 + k % 3} for k in range(12)]
    reports, _ = anonymous(ships, range(0, 1200, 60), np.random.default_rng(2))
    assert set(reports.kinds) == {"position"}
    log = without_nan(tracked(reports, Settings(position=Noise(20.0))).log())
    assert len(log.tracks) == 12
    assert log.tracks[0] == "unknown 1"
    assert {len(log[track]) for track in log} == {20}


def test_positions_help_the_tracks_of_ais():
    """A position goes to the ship that reports by AIS, and not to a new track."""
    ais = straight(times=[0, 60, 120, 600])
    seen = straight(times=[240, 360, 480], vessel=None, sog=None, cog=None)
    log = tracked(Reports.concatenate([ais, seen])).log()
    assert log.tracks == ("Tern",)
    assert log["Tern"].measurement_type.tolist()[3:6] == ["position"] * 3


def test_association_is_the_best_of_all():
    """Against every assignment by brute force, in clusters of up to four by four."""
    import itertools

    from trackmetrics.vessel.association import associate

    rng = np.random.default_rng(4)
    for _ in range(200):
        n, m = map(int, rng.integers(1, 5, 2))
        allowed = rng.random((n, m)) < 0.7
        costs = rng.normal(size=(n, m)) * 5 - 20
        i, j = np.nonzero(allowed)
        if not len(i):
            continue
        chosen = associate(i, j + 10, costs[i, j], np.zeros(len(i)), 13.8)
        best = max(
            (
                sum(allowed[a, b] for a, b in enumerate(p) if b < m),
                -sum(costs[a, b] for a, b in enumerate(p) if b < m and allowed[a, b]),
            )
            for p in itertools.permutations(range(m + n), n)
        )
        assert len(chosen) == best[0]
        assert sum(costs[a, b - 10] for a, b in chosen) == pytest.approx(-best[1])


def test_a_late_scan_is_counted():
    tracker = tracked(straight())
    tracker.add(straight(times=[30], vessel=None))
    assert tracker.late.tolist() == [10]


# ------------------------------------------------------------------ predictions of held-out reports


def held_out(run, seconds, settings):
    """The log of a fleet decimated, and the test of its predictions to the other reports."""
    reports = Reports.concatenate(list(run.reports.values()))
    used = vessel.thin(reports, seconds)
    log = tracked(reports.take(used), settings).log()
    return log, reports.take(~used), vessel.predictive_nis(log, reports.take(~used), settings)


@pytest.mark.usefixtures("native")
def test_consistent_filters_fail_the_test_of_their_predictions_as_often_as_it_says():
    """1000 ships with full AIS: 5 %, half of them on either side; 500 with mixed kinds: 6.5 %."""
    found = []
    for interval, seconds in ((30.0, 120), (10.0, 300)):
        for seed in range(10):
            run = vessel.fleet(
                50, duration=1800.0, report_interval=interval, type_shares=(1, 0, 0), seed=seed
            )
            found += held_out(run, seconds, Settings())[2].values()
    p, scale = (np.array([getattr(h, name) for h in found]) for name in ("p_value", "scale"))
    assert len(p) == 1000
    assert (p < 0.05).mean() == pytest.approx(0.05, abs=0.02)
    assert ((p < 0.05) & (scale > 1)).mean() == pytest.approx(0.025, abs=0.015)
    assert ((p < 0.05) & (scale < 1)).mean() == pytest.approx(0.025, abs=0.015)
    mixed = []
    for seed in range(10):
        run = vessel.fleet(
            50, duration=1800.0, report_interval=10.0, type_shares=(0.6, 0.2, 0.2), seed=seed
        )
        mixed += held_out(run, 60, Settings())[2].values()
    assert np.mean([h.p_value < 0.05 for h in mixed]) == pytest.approx(0.065, abs=0.035)
    missed = [not h.interval[0] <= 1 <= h.interval[1] for h in found]
    assert missed == (p < 0.05).tolist()


@pytest.mark.usefixtures("native")
def test_the_correlation_of_predictions_is_that_of_the_dense_matrix():
    from trackmetrics.vessel import holdout

    run = vessel.fleet(1, duration=900.0, report_interval=10.0, type_shares=(0.6, 0.2, 0.2), seed=3)
    log, rows, found = held_out(run, 60, Settings())
    fused = log["ship 1"]
    before = np.searchsorted(fused.time, rows.time, side="right") - 1
    kept = (before >= 2) & (before < len(fused.time) - 1)
    made = holdout._Predictions(fused, rows.take(np.flatnonzero(kept)), before[kept], Settings())
    nis = made.nis()
    assert found["ship 1"].nis.tolist() == nis.tolist()
    dense = dense_correlation(made, fused)
    assert np.linalg.eigvalsh(dense).min() > -1e-9
    wanted = [np.trace(np.linalg.matrix_power(dense, k)) for k in (1, 2, 3)]
    assert [made.observed.sum(), *made.traces()] == pytest.approx(wanted)


def dense_correlation(made, fused):
    """Block by block, each pair of predictions by itself."""
    n = len(made.rows)
    blocks = np.zeros((n, 4, n, 4))
    for i in range(n):
        blocks[i, :, i, :] = np.diag(np.arange(4) < made.observed[i])
        carried = np.linalg.solve(made.f[i], made.p[i])
        for j in range(i + 1, n):
            for row in range(made.before[j - 1] + 1, made.before[j] + 1):
                carried = fused.A[row] @ carried
            block = made.white[j] @ (made.f[j] @ carried)[:4, :4] @ made.white[i].T
            blocks[j, :, i, :], blocks[i, :, j, :] = block, block.T
    return blocks.reshape(4 * n, 4 * n)


@pytest.mark.usefixtures("native")
def test_predictions_that_tell_almost_nothing_are_tested_all_the_same():
    """Ships faster than any vessel: identities split, gaps of all lengths, errors of all sizes."""
    settings = Settings.harbour()
    run = vessel.fleet(
        20,
        duration=1800.0,
        report_interval=10.0,
        type_shares=(1, 0, 0),
        settings=settings,
        speed=(60, 70),
    )
    for held in held_out(run, 60, settings)[2].values():
        assert 1 <= held.effective_dof <= held.dof
        assert 0 <= held.p_value <= 1
        assert held.interval[0] <= held.scale <= held.interval[1]


@pytest.mark.usefixtures("native")
def test_a_filter_that_claims_too_much_is_found_by_its_predictions():
    run = vessel.fleet(5, duration=3600.0, report_interval=10.0, type_shares=(1, 0, 0), seed=1)
    reports = Reports.concatenate(list(run.reports.values()))
    used = vessel.thin(reports, 60)
    timid = Settings(ais=Noise(20.0, 0.6, 3.0), acceleration_density=4e-4, turn_density=8e-9)
    bold = Settings(ais=Noise(5.0, 0.15, 0.75), acceleration_density=2e-5, turn_density=5e-10)
    for settings, verdict in ((timid, "pessimistic"), (bold, "optimistic")):
        log = tracked(reports.take(used), settings).log()
        held = vessel.predictive_nis(log, reports.take(~used), settings)
        assert {h.verdict for h in held.values()} == {verdict}


# ------------------------------------------------------------------ arguments


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (
            {"acceleration_density": -1},
            "acceleration_density must be at least 0 and finite, got -1.0",
        ),
        ({"turn_rate_decay": 0}, "turn_rate_decay must be positive, got 0.0"),
        ({"num_tentative": 0}, "num_tentative must be a whole number, at least 1, got 0"),
        ({"max_speed": np.inf}, "max_speed must be positive and finite, got inf"),
        ({"gate_probability": 1.0}, "gate_probability must be between 0 and 1, got 1.0"),
    ],
)
def test_settings_that_cannot_be(change, text):
    with pytest.raises(ValueError, match=r"\w") as caught:
        Settings(**change)
    assert str(caught.value) == text


def test_other_arguments_that_cannot_be():
    with pytest.raises(ValueError, match="position must be positive and finite, got nan"):
        Noise(np.nan)
    with pytest.raises(ValueError, match="lat has 2 reports, time has 1"):
        Reports.from_columns(time=[0], lat=[1, 2], lon=[1])
    with pytest.raises(ValueError, match="noise must be 'consistent' or 'published', got 'loud'"):
        vessel.three_ships(0, "loud")
    with pytest.raises(ValueError, match="ships must be at least 1, got 0"):
        vessel.fleet(0)
    with pytest.raises(ValueError, match="shares must be at least 0 and add up to 1"):
        vessel.fleet(1, type_shares=(1, 1, 1))
    with pytest.raises(ValueError, match="seconds must be positive, got 0"):
        vessel.thin(straight(), 0)
