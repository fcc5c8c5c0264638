"""How often each verdict comes over 200 seeds of the three ships, and what is wanted at least.

python benches/rates_vessel.py            # prints the table
python benches/rates_vessel.py --save     # and writes benches/results/rates_vessel.md
"""

import argparse
from collections import Counter
from pathlib import Path

from trackmetrics.diagnostics import diagnose
from trackmetrics.vessel import three_ships

WANTED = {
    ("honest", "SS Northern Star0", "late_divergence"): 195,
    ("honest", "SS Northern Star0", "onset 6780 s"): 195,
    ("honest", "SS Iron Aurora1", "consistent"): 190,
    ("honest", "MV Iron Falcon2", "startup_then_consistent"): 165,
    ("article", "SS Northern Star0", "late_divergence"): 195,
    ("article", "SS Iron Aurora1", "pessimistic"): 190,
    ("article", "MV Iron Falcon2", "startup_then_pessimistic"): 184,
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


def main() -> None:
    """Count, hold against what is wanted, print, save."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--save", action="store_true")
    options = parser.parse_args()
    found = counts("honest", options.seeds) + counts("article", options.seeds)
    lines = [
        f"# Verdicts of the three ships over {options.seeds} seeds\n",
        "Written by `benches/rates_vessel.py`; wanted of 200.\n",
        "| noise | ship | what | runs | wanted |",
        "| --- | --- | --- | ---: | ---: |",
    ]
    for key, count in sorted(found.items(), key=lambda item: (item[0][:2], -item[1])):
        wanted = WANTED.get(key, "")
        lines.append(f"| {' | '.join(key)} | {count} | {wanted} |")
    print("\n".join(lines))
    if options.seeds == 200:
        short = {key: found[key] for key, least in WANTED.items() if found[key] < least}
        assert not short, short
    if options.save:
        path = Path(__file__).parent / "results" / "rates_vessel.md"
        path.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
