#!/usr/bin/python3
"""Spheres of any density, driven by a constant force through a lattice fluid that is at rest at first.

    tests/validation/light_bodies.py     runs the whole table and writes docs/results/light_bodies.md
"""

import csv
import math
import os
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
CASE = ROOT / "configs/validation/light_sphere.yaml"
BODIES = {
    "own": (),
    "Bullet": ("--set", "body.solver=bullet"),
    "Python": ("--body", f"/usr/bin/python3 {ROOT}/proto/python/examples/point_masses.py"),
}
CELL_M, VISCOSITY_M2_PER_S, DENSITY_KG_PER_M3 = 1e-6, 1e-6, 1000.0  # of the case


def settings(ratio, radius, tau, cells, speed, periodic=False):
    """What makes the case one of a sphere of `radius` cells, whose terminal speed without walls is `speed` cells per
    step. In a periodic box the fluid feels the opposite force."""
    step_s = (tau - 0.5) * CELL_M**2 / (3 * VISCOSITY_M2_PER_S)
    radius_m = radius * CELL_M
    force_N = 6 * math.pi * DENSITY_KG_PER_M3 * VISCOSITY_M2_PER_S * radius_m * speed * CELL_M / step_s
    place_m = [(0.5 * cells + shift) * CELL_M for shift in (0.3, 0.2, -0.9)]
    values = {
        "fluid.relaxation_time": tau,
        "fluid.domain_cells": [cells] * 3,
        "bodies.0.radius_m": radius_m,
        "bodies.0.mass_kg": ratio * DENSITY_KG_PER_M3 * 4 / 3 * math.pi * radius_m**3,
        "bodies.0.position_m": place_m,
        "actuators.0.signal.amplitude_N": force_N,
    }
    if periodic:
        values["fluid.boundaries"] = "{x: periodic, y: periodic, z: periodic}"
        values["fluid.body_force_N_per_m3"] = [0, 0, -force_N / (cells * CELL_M) ** 3]
    return values


def velocities(values, steps, every=10, body="own", more=()):
    """Velocity along the force at every so many steps [cells per step], or None if the run did not finish."""
    tau = values["fluid.relaxation_time"]
    lattice_per_SI = (tau - 0.5) * CELL_M / (3 * VISCOSITY_M2_PER_S)
    values = {**values, "run.steps": steps, "output.trajectory.every_steps": every}
    words = [word for key, value in values.items() for word in ("--set", f"{key}={value}")]
    with tempfile.TemporaryDirectory() as folder:
        command = [ROOT / "deploy/copepod", "run", CASE, "--out", f"{folder}/run", *words, *BODIES[body], *more]
        ended = subprocess.run(command, capture_output=True, text=True, check=False)
        if ended.returncode == 70:
            return None
        if ended.returncode != 0:
            raise RuntimeError(ended.stderr)
        with open(f"{folder}/run/trajectory.csv", encoding="utf-8") as file:
            return [float(row["vz_m_per_s"]) * lattice_per_SI for row in csv.DictReader(file)]


def exact_start(ratio, radius, tau, steps):
    """Velocity, in units of the terminal one, of a sphere that a constant force sets into motion from rest:
        (ρ_b/ρ + 1/2) V' = D (1 − V) − 9/(2 r) √(ν/π) ∫ V'(s)/√(t − s) ds,   D = 9 ν/(2 r²)
    in steps [Basset 1888; Maxey and Riley 1983], V' constant within a step."""
    viscosity = (tau - 0.5) / 3
    drag, history = 4.5 * viscosity / radius**2, 4.5 / radius * math.sqrt(viscosity / math.pi)
    gained, speed, result = [], 0.0, [0.0]
    weights = [2 * (math.sqrt(n + 0.5) - math.sqrt(max(n - 0.5, 0))) for n in range(steps)]
    for n in range(steps):
        past = sum(weights[n - j] * gained[j] for j in range(n))
        gained.append((drag * (1 - speed) - history * past) / (ratio + 0.5 + 0.5 * drag + history * weights[0]))
        speed += gained[-1]
        result.append(speed)
    return result


def deviation_of_start(ratio, radius, tau, steps, **options):
    """Largest relative deviation from `exact_start` from a third of the steps on; None if the run did not finish."""
    cells, speed = 64, 1e-5
    values = settings(ratio, radius, tau, cells, speed, periodic=True)
    found = velocities(values, steps, every=1, **options)
    if found is None:
        return None
    exact = exact_start(ratio, radius, tau, steps)
    # The force on the fluid accelerates it as a whole.
    drift = 6 * math.pi * (tau - 0.5) / 3 * radius * speed / (cells**3 - 4 / 3 * math.pi * radius**3)
    return max(
        (abs(found[n] + drift * n - speed * exact[n]) / (speed * exact[n]), n) for n in range(steps // 3, steps + 1)
    )[0]


RATIOS = (0.01, 0.1, 0.2, 0.5, 1.0, 10.0, 100.0)
TIMES = (0.55, 2 / 3, 1.0, 2.0)
LONG = 20000


def terminal(ratio, radius, tau, body="own", more=(), start=0.0):
    """Mean velocity over the last tenth of a long run in a closed box, in units of that without walls."""
    speed = 1e-4
    values = settings(ratio, radius, tau, 16 + 4 * int(radius), speed)
    if start:
        lattice_per_SI = (tau - 0.5) * CELL_M / (3 * VISCOSITY_M2_PER_S)
        values["bodies.0.velocity_m_per_s"] = [0, 0, start * speed / lattice_per_SI]
    found = velocities(values, LONG, body=body, more=more)
    return None if found is None else sum(found[-LONG // 100 :]) / (LONG // 100) / speed


_HEAD = """# Light bodies

```sh
tests/validation/light_bodies.py     # writes this page: {runs} runs, {minutes:.0f} minutes
```

On {cores} cores of an {processor}, shared with other work. A sphere that a constant force drives
through a fluid at rest: `configs/validation/light_sphere.yaml` with another radius, density and relaxation time, trt,
`moving_boundary: central_linear`, and `coupling.virtual_mass: auto` ([decision](../decisions/virtual_mass.md)).

## Terminal velocity

Mean over the last 2000 of {steps} steps in a closed box of four radii and 16 cells, in units of the velocity without
walls, at 1e-4 cells per step. In brackets the deviation from the sphere of the fluid's density. Spheres of 10 and 100
times the density start at the velocity of that sphere: their relaxation is longer than the run. "–": not run.

| radius | τ | bodies | {ratios} |
|---|---|---|{dashes}|
"""

_START = """
## Acceleration from rest

Largest deviation from the exact velocity of a sphere in an unbounded fluid, with Stokes drag, added mass and Basset's
history force [Maxey and Riley 1983], over the steps {first} to {last}, relative to the velocity there; radius 4 cells,
periodic box of 64 cells, in which the fluid feels the opposite force.

| τ | bodies | {ratios} |
|---|---|{dashes}|
"""

_TAIL = """
The heavy spheres, which move without virtual mass, deviate as much as the light ones: what is left is the error of the
fluid at four cells per radius and the images in the periodic box, not of the coupling.
"""


def _processor():
    for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
        if line.startswith("model name"):
            return line.split(":")[1].strip()
    return "unknown processor"


def _terminal_rows(pool):
    """Rows of the first table, and how many runs they took."""
    wanted = [(4.0, tau, "own", RATIOS) for tau in TIMES]
    wanted += [(4.0, tau, body, (0.01,)) for body in ("Bullet", "Python") for tau in (TIMES[0], TIMES[-1])]
    wanted += [(8.0, tau, "own", (0.01, 1.0)) for tau in TIMES[1::2]]
    neutral = {}
    for radius, tau in dict.fromkeys(row[:2] for row in wanted):
        neutral[radius, tau] = pool.submit(terminal, 1.0, radius, tau)
    found = {}
    for radius, tau, body, ratios in wanted:
        for ratio in ratios:
            if body == "own" and ratio == 1.0:
                found[radius, tau, body, ratio] = neutral[radius, tau]
                continue
            start = neutral[radius, tau].result() if ratio > 1 else 0.0
            found[radius, tau, body, ratio] = pool.submit(terminal, ratio, radius, tau, body, (), start)
    rows = []
    for radius, tau, body, ratios in wanted:
        reference = neutral[radius, tau].result()
        cells = []
        for ratio in RATIOS:
            value = found[radius, tau, body, ratio].result() if ratio in ratios else None
            if ratio not in ratios:
                cells.append("–")
            elif value is None:
                cells.append("diverged")
            else:
                cells.append(f"{value:.4f} ({100 * (value / reference - 1):+.2f} %)")
        rows.append(f"| {radius:.0f} | {tau:.3g} | {body} | {' | '.join(cells)} |")
    return rows, len(found)


def _start_rows(pool, steps):
    ratios = (0.01, 0.1, 0.2, 0.5, 1.0, 10.0)
    found = {
        (tau, body, ratio): pool.submit(deviation_of_start, ratio, 4.0, tau, steps, body=body)
        for tau in TIMES
        for body in ("own", "Python")
        for ratio in ratios
        if body == "own" or ratio < 0.1
    }
    rows = []
    for tau in TIMES:
        for body in ("own", "Python"):
            values = [found[tau, body, ratio].result() if (tau, body, ratio) in found else "–" for ratio in ratios]
            texts = [
                value if value == "–" else "diverged" if value is None else f"{100 * value:.1f} %" for value in values
            ]
            rows.append(f"| {tau:.3g} | {body} | {' | '.join(texts)} |")
    return rows, len(found), ratios


def main():
    started = time.monotonic()
    cores = min(2, os.cpu_count() or 1)
    first_steps = 300
    with ThreadPoolExecutor(cores) as pool:
        start_rows, start_runs, start_ratios = _start_rows(pool, first_steps)
        rows, runs = _terminal_rows(pool)
    page = _HEAD.format(
        runs=runs + start_runs,
        minutes=(time.monotonic() - started) / 60,
        cores=cores,
        processor=_processor(),
        steps=LONG,
        ratios=" | ".join(f"ρ_b/ρ = {ratio:g}" for ratio in RATIOS),
        dashes="|".join(["---"] * len(RATIOS)),
    )
    page += "\n".join(rows) + "\n"
    page += _START.format(
        first=first_steps // 3,
        last=first_steps,
        ratios=" | ".join(f"ρ_b/ρ = {ratio:g}" for ratio in start_ratios),
        dashes="|".join(["---"] * len(start_ratios)),
    )
    page += "\n".join(start_rows) + "\n" + _TAIL
    (ROOT / "docs/results/light_bodies.md").write_text(page, encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
