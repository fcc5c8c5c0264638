"""The vessel estimator: one update, a fleet, a recording's worth of reports, and gating.

The peer is the same filter written with NumPy, one update at a time, as one writes it first: fresh
arrays, `np.linalg.solve`, a dictionary for each row. Both give the same NIS.
"""

import time

import numpy as np

from harness import Bench, interleave
from trackmetrics import _native, _numpy
from trackmetrics.vessel import Reports, Settings, Tracker, fleet

RADIAN, KNOT = np.pi / 180, 1852 / 3600
SETTINGS = Settings()


def metres(latitude):
    p = latitude * RADIAN
    north = 111132.954 - 559.822 * np.cos(2 * p) + 1.175 * np.cos(4 * p)
    return north, 111412.84 * np.cos(p) - 93.5 * np.cos(3 * p) + 0.118 * np.cos(5 * p)


def predict(x, p, dt):
    """Constant turn rate, Jacobian and Q, in plain NumPy."""
    lat, lon, sog, cog, rate = x
    h = 0.5 * rate * RADIAN * dt
    a, way, s = cog * RADIAN + h, sog * KNOT * dt, np.sinc(h / np.pi)
    ca, sa = np.cos(a), np.sin(a)
    lat2 = lat + way * s * ca / metres(lat)[0]
    east = metres(0.5 * (lat + lat2))[1]
    f = jacobian((h, s, way, ca, sa), lat, lat2, dt)
    x = np.array([lat2, lon + way * s * sa / east, sog, (cog + rate * dt) % 360, rate])
    p = f @ p @ f.T + process_noise(lat, sog * KNOT, ca, sa, dt)
    return x, 0.5 * (p + p.T), f


def jacobian(arc, lat, lat2, dt):
    h, s, way, ca, sa = arc
    slope = -h / 3 if abs(h) < 1e-4 else (h * np.cos(h) - np.sin(h)) / h**2
    chord, half = KNOT * dt * s, 0.5 * dt * RADIAN
    d_n = [0, 0, chord * ca, -way * s * sa * RADIAN, (-way * s * sa + way * slope * ca) * half]
    d_e = [0, 0, chord * sa, way * s * ca * RADIAN, (way * s * ca + way * slope * sa) * half]
    d_n, d_e = np.array(d_n), np.array(d_e)
    middle = 0.5 * (lat + lat2)
    north, east = metres(lat)[0], metres(middle)[1]
    f = np.eye(5)
    f[0] += d_n / north
    turn = way * s * sa / east * np.tan(middle * RADIAN) * RADIAN
    f[1] += d_e / east + turn * 0.5 * d_n / north
    f[1, 0] += turn
    f[3, 4] = dt
    return f


def process_noise(lat, v, ca, sa, dt):
    qa, qw = SETTINGS.acceleration_density, SETTINGS.turn_density * RADIAN**2
    block = np.array(
        [
            [qa * dt**3 / 3, 0, qa * dt**2 / 2, 0, 0],
            [0, v * v * qw * dt**5 / 20, 0, v * qw * dt**4 / 8, v * qw * dt**3 / 6],
            [qa * dt**2 / 2, 0, qa * dt, 0, 0],
            [0, v * qw * dt**4 / 8, 0, qw * dt**3 / 3, qw * dt**2 / 2],
            [0, v * qw * dt**3 / 6, 0, qw * dt**2 / 2, qw * dt],
        ]
    )
    north, east = metres(lat)
    g = np.diag([ca / north, ca / east, 1 / KNOT, 1 / RADIAN, 1 / RADIAN])
    g[0, 1], g[1, 0] = -sa / north, sa / east
    return g @ block @ g.T


def update(x, p, f, z, sigma):
    """Innovation, gain, Joseph, NIS: a row of a log."""
    m = len(z)
    h = np.eye(m, 5)
    north, east = metres(z[0])
    r = np.diag((np.array([sigma[0] / north, sigma[0] / east, *sigma[1:]]) ** 2)[:m])
    y = z - h @ x
    if m == 4:
        y[3] = (y[3] + 180) % 360 - 180
    s = h @ p @ h.T + r
    k = np.linalg.solve(s, h @ p).T
    j = np.eye(5) - k @ h
    x = x + k @ y
    x[3] %= 360
    p = j @ p @ j.T + k @ r @ k.T
    nis = float(y @ np.linalg.solve(s, y))
    return {"x": x, "P": 0.5 * (p + p.T), "A": j @ f, "innovation": y, "S": s, "nis": nis}


def numpy_tracks(reports):
    """Every vessel of a fleet, report by report."""
    rows, sigmas = [], SETTINGS.sigmas
    for ship in reports.values():
        x = p = None
        for i in range(len(ship)):
            z, sigma = ship.z[i][np.isfinite(ship.z[i])], sigmas[ship.kind[i]]
            if i < 2:
                # The fleet's first two reports are full: the second one is the start.
                north, east = metres(z[0])
                deviations = [sigma[0] / north, sigma[0] / east, sigma[1], sigma[2], 0.02]
                x, p = np.array([*z, 0.0]), np.diag(deviations) ** 2
                continue
            at = predict(x, p, ship.time[i] - ship.time[i - 1])
            rows.append(update(*at, z, sigma))
            x, p = rows[-1]["x"], rows[-1]["P"]
    return rows


def our_tracks(reports):
    tracker = Tracker(SETTINGS)
    tracker.add(reports)
    return tracker


def bench_filter(bench):
    run = fleet(20, duration=7200.0, report_interval=60.0, seed=1)
    reports = Reports.concatenate(list(run.reports.values()))
    ours, theirs = our_tracks(reports).log(), numpy_tracks(run.reports)
    found = np.concatenate([ours[ship].nis[2:] for ship in run.ships])
    expected = np.array([row["nis"] for row in theirs])
    assert np.allclose(found, expected, rtol=5e-3, atol=5e-3), np.abs(found - expected).max()
    count = len(reports)
    bench.compare(
        f"tracker: {count} reports of 20 vessels",
        lambda: our_tracks(reports),
        {"NumPy, update by update": lambda: numpy_tracks(run.reports)},
        target=10.0,
    )
    bench.compare(
        f"tracker and log: {count} reports of 20 vessels",
        lambda: our_tracks(reports).log(),
        {"NumPy, update by update": lambda: numpy_tracks(run.reports)},
    )


def bench_update(bench):
    """One predict and update from Python, the smallest call there is."""
    life = np.array([[5.0, 1, 0, 0, 50, 1, 10]])
    x, p = np.array([[50.0, 1, 12, 30, 0.001]]), np.diag([1e-8, 2e-8, 0.1, 2, 1e-4])[None]
    z, sigma = np.array([[50.0001, 1.0, 12.1, 31.0]]), np.array([[10, 0.3, 1.5]])
    starts, times, observed = np.array([0, 1]), np.array([10.0]), np.array([4])
    motion, rules = SETTINGS.motion, SETTINGS.rules
    arguments = (life, x, p, starts, times, z, observed, sigma, motion, rules)
    found = _native.vessel_filter(*arguments)[1][7][0]
    assert np.isclose(found, update(*predict(x[0], p[0], 10.0), z[0], sigma[0])["nis"], rtol=1e-3)
    bench.compare(
        "one update, called from Python",
        lambda: _native.vessel_filter(*arguments),
        {"NumPy, one update": lambda: update(*predict(x[0], p[0], 10.0), z[0], sigma[0])},
        target=10.0,
    )


def bench_gate(bench):
    """300 positions against 1000 live tracks over 200 km."""
    rng = np.random.default_rng(0)
    n = 1000
    x = np.stack(
        [
            rng.uniform(50, 52, n),
            rng.uniform(0, 3, n),
            rng.uniform(0, 20, n),
            rng.uniform(0, 360, n),
            np.zeros(n),
        ],
        axis=1,
    )
    p = np.tile(np.diag([1e-8, 2e-8, 0.1, 2, 4e-4]), (n, 1, 1))
    times, sigmas = np.full(n, 60.0), np.full(300, 60.0)
    z = _native.vessel_advance(x, times, SETTINGS.motion)[:300, :2].copy()
    arguments = (x, p, times, z, sigmas, 13.8, SETTINGS.motion)
    ours, reference = _native.vessel_gate(*arguments), _numpy.vessel_gate(*arguments)
    assert np.array_equal(ours[0], reference[0])
    assert np.array_equal(ours[1], reference[1])
    scan = min(timed(lambda: _native.vessel_gate(*arguments)) for _ in range(20))
    bench.report("gate: 300 positions, 1000 live tracks", 1e3 * scan, "ms a scan")
    more = np.ascontiguousarray(np.tile(z, (10, 1)) + rng.normal(size=(3000, 2)))
    larger = (x, p, times, more, np.full(3000, 60.0), 13.8, SETTINGS.motion)
    ten = min(timed(lambda: _native.vessel_gate(*larger)) for _ in range(20))
    bench.report("gate: 3000 positions, 1000 live tracks", 1e3 * ten, "ms a scan")


def bench_linear(bench):
    """Time a report of fleets of 2 000 to 128 000 reports."""
    for ships in (10, 40, 160, 640):
        run = fleet(ships, duration=7200.0, report_interval=36.0, seed=1)
        reports = Reports.concatenate(list(run.reports.values()))
        seconds = interleave({"a": lambda r=reports: our_tracks(r)}, 1.0, 5)["a"]
        bench.report(
            f"tracker: {len(reports)} reports", 1e6 * seconds / len(reports), "us a report"
        )


def timed(call):
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


if __name__ == "__main__":
    bench = Bench("vessel")
    bench_update(bench)
    bench_filter(bench)
    bench_gate(bench)
    bench_linear(bench)
    bench.finish()
