"""How often `estimate_noise` is right: coverage of intervals, uniformity of p-values, causes.

    nice python benches/rates_noise.py                   # prints the tables
    nice python benches/rates_noise.py --save            # and writes benches/results/

Causes are measured through the public function on logs of one track; coverage and p-values
through the same estimate without the search for faults, which does not change them.
"""

import argparse
import json
import time
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy import stats

import noise_ekf
import noise_plants as plants
from noise_plants import Case
from trackmetrics import vessel
from trackmetrics.diagnostics import NoiseEstimate, estimate_noise
from trackmetrics.diagnostics._noise_fit import chi_square_tail, maximise
from trackmetrics.diagnostics._noise_model import log_model
from trackmetrics.diagnostics.noise import ALARM, _factors
from trackmetrics.logs import EstimatorLog

RESULTS = Path(__file__).parent / "results" / "rates_noise.json"

SETTINGS = (
    ("drone", 1, 1), ("drone", 10, 1), ("drone", 0.1, 1), ("drone", 1, 4), ("drone", 1, 0.25),
    ("drone", 4, 4), ("ferry", 1, 1), ("ferry", 10, 1), ("ferry", 0.1, 1), ("ferry", 1, 4),
    ("ferry", 1, 0.25), ("ferry", 4, 4),
)  # fmt: skip
"""Plant, true factor of the process noise, true factor of all measurement noises."""

FACTORS = {
    "consistent": Case(), "Q / 10": Case(q=10), "Q x 10": Case(q=0.1), "R / 4": Case(r=4),
    "R x 4": Case(r=0.25),
}  # fmt: skip
"""The claim relative to the truth, as in the other tables of rates."""

FAULTS = {
    "bias": Case(bias=1.5), "outliers": Case(outliers=0.03), "wrong start": Case(initial=5),
    "correlated noise": Case(correlation=0.7), "late manoeuvre": Case(manoeuvre=5.6),
    "short manoeuvre": Case(manoeuvre=7.4, short=True),
}  # fmt: skip


def estimates(plant: str, case: Case, updates: int, runs: int, seed: int) -> list[NoiseEstimate]:
    """The estimates of many logs of one case."""
    made = plants.PLANTS[plant]()
    columns = plants.simulate(made, case, updates, runs, seed)
    return [estimate_noise(plants.one_log(made, columns, run)) for run in range(runs)]


def factors(plant: str, case: Case, updates: int, runs: int, seed: int) -> list[Any]:
    """Names, factors and p-values of many logs of one case, without the search for faults."""
    made = plants.PLANTS[plant]()
    columns = plants.simulate(made, case, updates, runs, seed)
    found = []
    for run in range(runs):
        errors = log_model(plants.one_log(made, columns, run), "all", "by_type", None).errors
        fit = maximise(errors)
        statistic = 2 * (fit.value - errors.likelihood(np.ones(errors.count)))
        names = [f"process {n}" for n in errors.process]
        names += [f"measurement {n}" for n in errors.measurement]
        p_value = chi_square_tail(statistic, errors.count)
        found.append((dict(zip(names, _factors(errors, fit, 0.95), strict=True)), p_value))
    return found


def percent(hits: int, runs: int) -> dict[str, Any]:
    """A share, with Clopper and Pearson's interval."""
    found = stats.binomtest(int(hits), runs).proportion_ci(0.95, "exact")
    return {"percent": 100 * hits / runs, "interval": [100 * found.low, 100 * found.high]}


def coverage(runs: int, seed: int) -> list[dict[str, Any]]:
    """How often the intervals hold the true factors."""
    rows = []
    for updates in (50, 150, 500):
        for plant, q, r in SETTINGS:
            found = [f for f, _ in factors(plant, Case(q=q, r=r), updates, runs, seed)]
            own = {name: q if name.startswith("process") else r for name in found[0]}
            held: Counter[str] = Counter()
            for estimate in found:
                for name, factor in estimate.items():
                    held[name] += factor.interval[0] <= own[name] <= factor.interval[1]
            row = {"plant": plant, "q": q, "r": r, "updates": updates, "runs": runs}
            row["covered"] = {name: percent(held[name], runs) for name in own}
            row["median"] = {
                name: float(np.nanmedian([e[name].factor for e in found])) for name in own
            }
            rows.append(show(row))
    return rows


def uniformity(runs: int, seed: int) -> list[dict[str, Any]]:
    """p-values of consistent logs against the uniform distribution."""
    rows = []
    for plant, updates in (("drone", 50), ("ferry", 50), ("lift", 150)):
        p_values = [p for _, p in factors(plant, Case(), updates, runs, seed)]
        test = stats.kstest(p_values, "uniform")
        rows.append(show({
            "plant": plant, "updates": updates, "runs": runs, "KS statistic": float(test.statistic),
            "KS p-value": float(test.pvalue),
            "below 5 %": percent(int(np.sum(np.array(p_values) < 0.05)), runs),
        }))  # fmt: skip
    return rows


def causes(plant: str, updates: int, runs: int, seed: int) -> list[dict[str, Any]]:
    """Causes named for wrong factors, and what is said of faults that no factor explains."""
    rows = []
    for name, case in (FACTORS | FAULTS).items():
        start = time.perf_counter()
        found = estimates(plant, case, updates, runs, seed)
        spent = (time.perf_counter() - start) / runs
        own = {n for n in found[0]._named() if n.startswith(_side(case))} if _side(case) else set()
        above = [e for e in found if e.p_value < ALARM]
        right = sum(bool(e.causes) and set(e.causes) <= own for e in found)
        wrong = sum(bool(set(e.causes) - own) for e in found)
        named_above = sum(bool(e.causes) and set(e.causes) <= own for e in above)
        rows.append(show({
            "plant": plant, "updates": updates, "case": name, "runs": runs,
            "ratio above its threshold": percent(len(above), runs),
            "cause right": percent(right, runs),
            "cause right where above": percent(named_above, len(above)) if above else None,
            "cause wrong": percent(wrong, runs),
            "no noise explains it": percent(sum(not e.explained for e in found), runs),
            "consistent": percent(sum(e.explained and not e.causes for e in found), runs),
            "reasons": dict(Counter(str(e.reason) for e in found).most_common()),
            "seconds a log": spent,
        }))  # fmt: skip
    return rows


def nonlinear(runs: int, seed: int) -> list[dict[str, Any]]:
    """Factors found for an extended Kalman filter of range and bearing, and for the vessel
    estimator."""
    rows = []
    for q, r in ((1, 1), (10, 1), (0.1, 1), (1, 4), (1, 0.25)):
        for name, updates, make in (
            ("range and bearing", 300, noise_ekf.simulate),
            ("vessel", 300, _vessel),
        ):
            found = [estimate_noise(make(q, r, updates, seed + run)) for run in range(runs)]
            named = [e._named() for e in found]
            true = {n: q if n.startswith("process") else r for n in named[0]}
            rows.append(show({
                "plant": name, "q": q, "r": r, "updates": updates, "runs": runs,
                "median": {n: float(np.nanmedian([e[n].factor for e in named])) for n in true},
                "within 1.5": {
                    n: percent(sum(2 / 3 < e[n].factor / true[n] < 1.5 for e in named), runs)
                    for n in true
                },
                "covered": {
                    n: percent(
                        sum(e[n].interval[0] <= true[n] <= e[n].interval[1] for e in named), runs
                    )
                    for n in true
                },
                "reasons": dict(Counter(str(e.reason) for e in found).most_common()),
            }))  # fmt: skip
    return rows


def _vessel(q: float, r: float, updates: int, seed: int) -> EstimatorLog:
    """A fleet whose filter claims noises that are too small by these factors."""
    true, root = vessel.Settings(), r**0.5
    claimed = replace(
        true,
        acceleration_density=true.acceleration_density / q,
        turn_density=true.turn_density / q,
        ais=vessel.Noise(10 / root, 0.3 / root, 1.5 / root),
        truncated_ais=vessel.Noise(30 / root),
        position=vessel.Noise(60 / root),
    )
    made = vessel.fleet(2, duration=20.0 * updates, report_interval=40.0, settings=true, seed=seed)
    return replace(made, settings=dict.fromkeys(made.ships, claimed)).track()


def _side(case: Case) -> str:
    if case.q != 1:
        return "process"
    return "measurement" if case.r != 1 else ""


def show(row: dict[str, Any]) -> dict[str, Any]:
    """Prints a row, and hands it on."""

    def short(value: Any) -> str:
        if isinstance(value, dict) and "percent" in value:
            return f"{value['percent']:.1f} %"
        if isinstance(value, dict):
            return "{" + ", ".join(f"{k}: {short(v)}" for k, v in value.items()) + "}"
        return f"{value:.3g}" if isinstance(value, float) else str(value)

    print("  ".join(f"{k} {short(v)}" for k, v in row.items()), flush=True)
    return row


def main() -> None:
    """Measures, prints, saves."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--parts", default="coverage,uniformity,causes,nonlinear")
    parser.add_argument("--plants", default=",".join(plants.PLANTS))
    parser.add_argument("--updates", default="50,100,300")
    parser.add_argument("--seed", type=int, default=2026)
    parser.add_argument("--save", action="store_true")
    options = parser.parse_args()
    results = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    parts = options.parts.split(",")
    if "coverage" in parts:
        results["coverage"] = coverage(options.runs, options.seed)
    if "uniformity" in parts:
        results["uniformity"] = uniformity(2 * options.runs, options.seed)
    if "causes" in parts:
        results["causes"] = [
            row
            for plant in options.plants.split(",")
            for updates in map(int, options.updates.split(","))
            for row in causes(plant, updates, options.runs, options.seed)
        ]
    if "nonlinear" in parts:
        results["nonlinear"] = nonlinear(max(options.runs // 5, 2), options.seed)
    if options.save:
        RESULTS.write_text(json.dumps(results, indent=1) + "\n")


if __name__ == "__main__":
    main()
