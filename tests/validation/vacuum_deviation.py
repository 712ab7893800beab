#!/usr/bin/python3
"""Deviation of a run of configs/paper/vacuum.yaml from the exact solution, at every step that the reference lists.

    tests/validation/vacuum_deviation.py RUN_DIR
"""

import csv
import sys
from pathlib import Path

REFERENCE = Path(__file__).resolve().parent.parent / "reference" / "vacuum_trajectory.csv"
CELL_M = 1e-6
STEP_S = 7.548309999899218e-10
BEADS = ("B2", "B1", "B3")


def deviation(trajectory):
    """(rows compared, worst relative deviation of a position, worst of a velocity over the largest velocity)."""
    exact = {int(row["step"]): row for row in csv.DictReader(REFERENCE.read_text().splitlines())}
    fastest = max(abs(float(row[f"v_{bead}_cells_per_step"])) for row in exact.values() for bead in BEADS)
    compared, position, velocity = 0, 0.0, 0.0
    for row in csv.DictReader(Path(trajectory).read_text().splitlines()):
        reference = exact.get(int(row["step"]))
        if reference is None:
            continue
        bead = row["body"].rpartition(".")[2]
        z_cells = float(row["z_m"]) / CELL_M
        v_cells_per_step = float(row["vz_m_per_s"]) * STEP_S / CELL_M
        position = max(position, abs(z_cells / float(reference[f"z_{bead}_cells"]) - 1.0))
        velocity = max(velocity, abs(v_cells_per_step - float(reference[f"v_{bead}_cells_per_step"])) / fastest)
        compared += 1
    return compared, position, velocity


if __name__ == "__main__":
    rows, worst_position, worst_velocity = deviation(Path(sys.argv[1]) / "trajectory.csv")
    print(
        f"{rows} rows compared; worst relative deviation of a position {worst_position:.2g}, "
        f"of a velocity {worst_velocity:.2g} of the largest"
    )
    sys.exit(0 if rows == 3 * 197 and worst_position < 1e-10 and worst_velocity < 1e-10 else 1)
