"""What the published run says of its noises: the speed channel alone, rebuilt as a scalar filter.

    python benches/published_noise.py FOLDER             # the folder of updates.csv

The run was published without innovations. Where a full AIS report follows another, the speed and
its claimed variance after the update give the innovation of the speed, if the speed is taken to be
independent of the other states: 1 / P_pred = 1 / P - 1 / R with R = (2 kt)^2, S = P_pred + R,
innovation = (z - x) S / R. The true noise of the reported speed is known from the truth.
"""

import argparse
import csv
from pathlib import Path

import numpy as np

from trackmetrics.diagnostics import LinearModel, estimate_noise
from trackmetrics.logs import EstimatorLog

R = 4.0


def speed_log(path: Path) -> tuple[EstimatorLog, float]:
    """The log of the speed channel, and the true factor of its measurement noise."""
    with path.open() as file:
        rows = list(csv.DictReader(file))
    columns: dict[str, list] = {
        name: []
        for name in ("track", "time", "innovation", "S", "P_pred", "P", "x", "x_pred", "R", "H")
    }
    errors = []
    for before, row in zip([None, *rows], rows, strict=False):
        P = float(row["std_sog_kts"]) ** 2
        if row["measurement_type"] != "AISMeasurement" or P >= R:
            continue
        z, x = float(row["sog_meas_kts"]), float(row["sog_est_kts"])
        errors.append(z - float(row["sog_true_kts"]))
        P_pred = 1 / (1 / P - 1 / R)
        S = P_pred + R
        innovation = (z - x) * S / R
        follows = (
            before is not None
            and before["track"] == row["track"]
            and columns["time"][-1:] == [float(before["time"])]
        )
        piece = f"{row['track']} {row['update']}" if not follows else columns["track"][-1]
        values = (
            piece, float(row["time"]), [innovation], [[S]], [[P_pred]], [[P]], [x],
            [x - P_pred / S * innovation], [[R]], [[1.0]],
        )  # fmt: skip
        for name, value in zip(columns, values, strict=True):
            columns[name].append(value)
    log = EstimatorLog.from_columns(
        states=["sog"], measurement_type=["AIS"] * len(columns["x"]), **columns
    )
    return log, float(np.mean(np.square(errors)) / R)


def main() -> None:
    """Prints the estimate and the true factor."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    log, true = speed_log(parser.parse_args().folder / "updates.csv")
    print(log)
    print(estimate_noise(log, model=LinearModel(F=[[1.0]])))
    print(f"true factor of the speed's measurement noise, from the truth: {true:.2f}")


if __name__ == "__main__":
    main()
