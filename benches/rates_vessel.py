"""How often each verdict comes over 200 seeds of the three ships, and what is wanted at least.

And how often the predictions of consistent filters are rejected at 5 %.

python benches/rates_vessel.py            # prints the table
python benches/rates_vessel.py --save     # and writes benches/results/rates_vessel.md
"""

import argparse
from collections import Counter
from pathlib import Path

import numpy as np

from trackmetrics.diagnostics import diagnose
from trackmetrics.vessel import (
    Reports,
    Settings,
    Tracker,
    fleet,
    predictive_nis,
    thin,
    three_ships,
)

WANTED = {
    ("consistent", "SS Northern Star0", "late_divergence"): 195,
    ("consistent", "SS Northern Star0", "onset 6780 s"): 195,
    ("consistent", "SS Iron Aurora1", "consistent"): 190,
    ("consistent", "MV Iron Falcon2", "startup_then_consistent"): 165,
    ("published", "SS Northern Star0", "late_divergence"): 195,
    ("published", "SS Iron Aurora1", "pessimistic"): 190,
    ("published", "MV Iron Falcon2", "startup_then_pessimistic"): 184,
}


def counts(noise: str, seeds: int) -> Counter[tuple[str, str, str]]:
    """Verdicts, and the onset and the weakest state of Northern Star0."""
    found: Counter[tuple[str, str, str]] = Counter()
    for seed in range(seeds):
        for name, track in diagnose(three_ships(seed, noise).track()).items():
            found[noise, name, track.verdict] += 1
            if name == "SS Northern Star0":
                found[noise, name, f"onset {track.nis.onset_time:.0f} s"] += 1
                found[noise, name, f"weakest {track.weakest_state}"] += 1
    return found


# Seconds between reports, seconds between those that are used, and the shares of full AIS,
# truncated AIS and positions.
PATTERNS = (
    (10.0, 60, (1, 0, 0)),
    (10.0, 300, (1, 0, 0)),
    (30.0, 120, (1, 0, 0)),
    (10.0, 60, (0.6, 0.2, 0.2)),
    (30.0, 300, (0.6, 0.2, 0.2)),
)


def rejections(interval: float, seconds: float, shares: tuple[float, ...], seeds: int) -> list[str]:
    """Of consistent filters, 50 ships a seed: how many, and the share rejected on either side."""
    found = []
    for seed in range(seeds):
        run = fleet(50, duration=1800.0, report_interval=interval, type_shares=shares, seed=seed)
        reports = Reports.concatenate(list(run.reports.values()))
        used = thin(reports, seconds)
        tracker = Tracker()
        tracker.add(reports.take(used))
        found += predictive_nis(tracker.log(), reports.take(~used), Settings()).values()
    rejected = np.array([h.p_value < 0.05 for h in found])
    above = rejected & np.array([h.scale > 1 for h in found])
    shares_of = (rejected.mean(), above.mean(), (rejected & ~above).mean())
    return [str(len(found)), *(f"{100 * share:.1f} %" for share in shares_of)]


def main() -> None:
    """Count, hold against what is wanted, print, save."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--save", action="store_true")
    options = parser.parse_args()
    found = counts("consistent", options.seeds) + counts("published", options.seeds)
    lines = [
        f"# Verdicts of the three ships over {options.seeds} seeds\n",
        "Written by `benches/rates_vessel.py`; wanted of 200.\n",
        "| noise | ship | what | runs | wanted |",
        "| --- | --- | --- | ---: | ---: |",
    ]
    for key, count in sorted(found.items(), key=lambda item: (item[0][:2], -item[1])):
        wanted = WANTED.get(key, "")
        lines.append(f"| {' | '.join(key)} | {count} | {wanted} |")
    lines += [
        "\n# Predictions of consistent filters rejected at 5 %\n",
        "| every | used | full, truncated, positions | ships | rejected | above 1 | below 1 |",
        "| ---: | ---: | --- | ---: | ---: | ---: | ---: |",
    ]
    for interval, seconds, shares in PATTERNS:
        cells = [f"{interval:g} s", f"{seconds} s", ", ".join(f"{100 * x:g} %" for x in shares)]
        cells += rejections(interval, seconds, shares, options.seeds // 5)
        lines.append(f"| {' | '.join(cells)} |")
    print("\n".join(lines))
    if options.seeds == 200:
        short = {key: found[key] for key, least in WANTED.items() if found[key] < least}
        assert not short, short
    if options.save:
        path = Path(__file__).parent / "results" / "rates_vessel.md"
        path.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
