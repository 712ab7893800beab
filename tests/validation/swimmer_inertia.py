"""Najafi and Golestanian's swimmer from Re = 0.01 to 10: the distance it swims in a cycle beside that of Stokes flow.

    deploy/copepod python tests/validation/swimmer_inertia.py runs/inertia docs/results/swimmers_inertia.png

Re = U R/ν with the largest speed U at which an arm lengthens. The stroke is given, so that nothing but inertia changes.
The distance varies with the place between the cells: it is the mean of the last half of the cycles, of several cells.
"""

import sys
from pathlib import Path

import copepod
import matplotlib.pyplot as plt
import numpy as np

RADIUS, ARM, AMPLITUDE, WIDTH, LENGTH = 4.0, 18.0, 4.0, 64, 128  # cells, of 1 m; the step is 1 s
POINTS = [(0.01, 0.5, 4), (0.03, 0.5, 4), (0.1, 0.5, 4), (0.3, 0.5, 20), (1.0, 0.2, 60), (2.0, 0.1, 60)]
POINTS += [(4.0, 0.05, 60), (10.0, 0.02, 60)]  # Re, ν, cycles


def case_of(reynolds, viscosity, cycles):
    period = round(2 * np.pi * AMPLITUDE * RADIUS / (reynolds * viscosity))
    middle = [0.5 * WIDTH, 0.5 * WIDTH]
    starts = {"rear": -ARM, "middle": 0.0, "front": ARM - AMPLITUDE}

    def rod(ends, lag):
        signal = {"kind": "sinusoid", "amplitude_m": AMPLITUDE, "period_steps": period, "lag_deg": lag}
        return {"name": f"{ends[0]} rod", "kind": "distance", "bodies": ends, "signal": signal}

    sphere = {"radius_m": RADIUS, "density_kg_per_m3": 1.0, "motion": "free"}
    return {
        "case": "swimmer_inertia",
        "fluid": {
            "solver": "lattice_boltzmann",
            "density_kg_per_m3": 1.0,
            "kinematic_viscosity_m2_per_s": viscosity,
            "cell_size_m": 1.0,
            "domain_cells": [WIDTH, WIDTH, LENGTH],
            "boundaries": {"x": "no_slip", "y": "no_slip", "z": "periodic"},
            "symmetry_planes": ["x", "y"],
        },
        "step_s": 1.0,
        "bodies": [{"name": name, "position_m": [*middle, 0.5 * LENGTH + z], **sphere} for name, z in starts.items()],
        "groups": [{"name": "swimmer", "bodies": list(starts), "axis": [0, 0, 1], "period_steps": period}],
        "joints": [rod(["rear", "middle"], 0.0), rod(["middle", "front"], 90.0)],
        "run": {"steps": cycles * period},
        "output": {"trajectory": {"every_steps": period}},
        "services": {"transport": "in_process"},
    }


def main(folder, picture):
    found = []
    print(
        "| Re | τ | cycles | cells per cycle | over that of Re = 0.01 | standard deviation |\n|---|---|---|---|---|---|"
    )
    for point in POINTS:
        case = case_of(*point)
        cycles = copepod.run(case, Path(folder) / f"{point[0]:g}", quiet=True).cycles.loc["swimmer"]
        distances = cycles["u_along_m_per_s"].to_numpy()[-point[2] // 2 :] * case["groups"][0]["period_steps"]
        found.append((distances.mean(), distances.std()))
        ratio, deviation = np.array(found[-1]) / found[0][0]
        words = (
            f"{point[0]:g} | {0.5 + 3 * point[1]:g} | {point[2]} | {found[-1][0]:.4f} | {ratio:.3f} | {deviation:.3f}"
        )
        print(f"| {words} |", flush=True)
    figure, axes = plt.subplots(figsize=(6, 4))
    mean, deviation = np.transpose(found) / found[0][0]
    axes.errorbar([point[0] for point in POINTS], mean, deviation, fmt="o-", capsize=3)
    axes.set(xscale="log", xlabel="Re = U R/ν", ylabel="distance in a cycle, over that at Re = 0.01", ylim=(0, 1.1))
    axes.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(picture, dpi=110)


if __name__ == "__main__":
    main(*sys.argv[1:])
