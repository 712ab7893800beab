"""Two unequal spheres whose distance oscillates: in Stokes flow they cannot swim, with inertia they do.

    deploy/copepod python tests/validation/two_sphere_swimmer.py runs/two_spheres docs/results/swimmers_two_spheres.png

Re = A ω r/ν with the amplitude A of the distance and the smaller radius r. A positive distance is one towards the
smaller sphere. The spheres are as dense as the fluid.
"""

import sys
from pathlib import Path

import copepod
import matplotlib.pyplot as plt
import numpy as np

SMALL, LARGE, DISTANCE, AMPLITUDE, WIDTH, LENGTH = 4.0, 8.0, 20.0, 6.0, 96, 192  # cells, of 1 m; the step is 1 s
SPEED = 0.05  # A ω
DIFFUSION = 1.0  # of the run: until momentum has passed the swimmer, by DISTANCE²/ν
POINTS = [0.5, 2.0, 5.0, 10.0, 20.0, 25.0, 30.0, 40.0]  # Re


def case_of(reynolds):
    speed = SPEED * min(1.0, reynolds / 2)  # so that ν ≤ 0.1
    viscosity = speed * SMALL / reynolds
    period = round(2 * np.pi * AMPLITUDE / speed)
    cycles = max(12, round(DIFFUSION * DISTANCE**2 / viscosity / period))
    radii = {"large": LARGE, "small": SMALL}
    mass = {name: radius**3 for name, radius in radii.items()}
    places = {"large": -DISTANCE * mass["small"], "small": DISTANCE * mass["large"]}  # of the common centre of mass
    middle = [0.5 * WIDTH, 0.5 * WIDTH]
    return {
        "case": "two_sphere_swimmer",
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
        "bodies": [
            {
                "name": name,
                "radius_m": radius,
                "density_kg_per_m3": 1.0,
                "position_m": [*middle, 0.5 * LENGTH + places[name] / sum(mass.values())],
            }
            for name, radius in radii.items()
        ],
        "groups": [{"name": "swimmer", "bodies": list(radii), "axis": [0, 0, 1], "period_steps": period}],
        "joints": [
            {
                "name": "rod",
                "kind": "distance",
                "bodies": list(radii),
                "signal": {"kind": "sinusoid", "amplitude_m": AMPLITUDE, "period_steps": period},
            }
        ],
        "run": {"steps": cycles * period},
        "output": {"trajectory": {"every_steps": period}},
        "services": {"transport": "in_process"},
    }


def main(folder, picture):
    found = []
    print("| Re | τ | cycles | cells per cycle | standard deviation |\n|---|---|---|---|---|")
    for reynolds in POINTS:
        case = case_of(reynolds)
        period = case["groups"][0]["period_steps"]
        cycles = copepod.run(case, Path(folder) / f"{reynolds:g}", quiet=True).cycles.loc["swimmer"]
        distances = cycles["u_along_m_per_s"].to_numpy()[-len(cycles) // 3 :] * period
        found.append((distances.mean(), distances.std()))
        tau = 0.5 + 3 * case["fluid"]["kinematic_viscosity_m2_per_s"]
        print(f"| {reynolds:g} | {tau:.4f} | {len(cycles)} | {found[-1][0]:+.5f} | {found[-1][1]:.5f} |", flush=True)
    figure, axes = plt.subplots(figsize=(6, 4))
    mean, deviation = np.transpose(found) / AMPLITUDE
    axes.errorbar(POINTS, mean, deviation, fmt="o-", capsize=3)
    axes.axhline(0, color="k", lw=0.8)
    axes.set(xscale="log", xlabel="Re = A ω r/ν", ylabel="distance in a cycle, over A")
    axes.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(picture, dpi=110)


if __name__ == "__main__":
    main(*sys.argv[1:])
