#!/usr/bin/python3
"""Six cases with each engine that moves bodies; writes docs/results/engines.md."""

import csv
import json
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ENGINES = ("own", "bullet", "mujoco")

_BOX = """fluid: {solver: lattice_boltzmann, density_kg_per_m3: 970, kinematic_viscosity_m2_per_s: 3.845e-4,
        cell_size_m: 1.875e-3, relaxation_time: 0.9, domain_cells: [24, 24, 24]}
"""
_SPHERE = "{name: sphere, radius_m: 7.5e-3, mass_kg: 1.979e-3, position_m: [0.0225, 0.0225, %s]}"
_CHAIN = 10


def _chain():
    links = "".join(
        f"  - {{name: link {i}, shape: capsule, radius_m: 1.0e-3, length_m: 6.0e-3, mass_kg: 1.0e-4, "
        f"position_m: [{8e-3 * i + 4e-3}, 0, 0], orientation_wxyz: [0.7071067811865476, 0, 0.7071067811865475, 0]}}\n"
        for i in range(_CHAIN)
    )
    joints = "".join(
        f"  - {{name: joint {i}, kind: ball, bodies: [link {i}, {f'link {i - 1}' if i else 'world'}], "
        f"anchor_m: [{8e-3 * i}, 0, 0]}}\n"
        for i in range(_CHAIN)
    )
    return (
        f"case: chain\nfluid: {{solver: vacuum}}\nstep_s: 1.0e-5\nbodies:\n{links}joints:\n{joints}"
        "gravity_m_per_s2: [0, 0, -9.81]\nrun: {steps: 5000}\noutput: {trajectory: {every_steps: 100}}\n"
    )


@dataclass(frozen=True)
class Case:
    name: str
    what: str  # is compared, with its unit
    text: str  # of the case, or its file
    value: object  # of (summary, last positions and velocities by body)


CASES = (
    Case(
        "swimmer",
        "speed of `configs/quick/three_sphere.yaml` [cells/step]",
        "configs/quick/three_sphere.yaml",
        lambda summary, last: summary["swimmers"][0]["u_swim_lattice"],
    ),
    Case(
        "settling",
        "velocity of a sphere in a box of oil after 200 steps [m/s]",
        f"case: settling\n{_BOX}bodies:\n  - {_SPHERE % 0.03}\ngravity_m_per_s2: [0, 0, -9.81]\nrun: {{steps: 200}}\n",
        lambda summary, last: float(last["sphere"]["vz_m_per_s"]),
    ),
    Case(
        "rebound",
        "relative velocity of two spheres after an impact in vacuum, to that before",
        "case: rebound\nfluid: {solver: vacuum}\nstep_s: 1.0e-4\nbodies:\n"
        "  - {name: thrown, radius_m: 1.0e-2, mass_kg: 1.0e-2, position_m: [0, 0, 0], velocity_m_per_s: [1, 0, 0]}\n"
        "  - {name: hit, radius_m: 1.0e-2, mass_kg: 1.0e-2, position_m: [0.03, 0, 0]}\n"
        "contact: {restitution: 0.7, friction: 0}\nrun: {steps: 500}\n",
        lambda summary, last: float(last["hit"]["vx_m_per_s"]) - float(last["thrown"]["vx_m_per_s"]),
    ),
    Case(
        "pendulum in fluid",
        "velocity of that sphere on a hinge, 200 steps after it was let go [m/s]",
        f"case: pendulum\n{_BOX}bodies:\n  - {_SPHERE % 0.0225}\n"
        "joints:\n  - {name: hook, kind: hinge, bodies: [sphere, world], anchor_m: [0.0125, 0.0225, 0.0325], "
        "axis: [0, 1, 0]}\ngravity_m_per_s2: [0, 0, -9.81]\nrun: {steps: 200}\n",
        lambda summary, last: float(last["sphere"]["vx_m_per_s"]),
    ),
    Case(
        "chain",
        f"place of the last of {_CHAIN} capsules that swing down in vacuum, after 0.05 s [m]",
        _chain(),
        lambda summary, last: float(last[f"link {_CHAIN - 1}"]["z_m"]),
    ),
    Case(
        "prescribed stroke",
        "speed of `configs/examples/prescribed_stroke.yaml` [cells/step]",
        "configs/examples/prescribed_stroke.yaml",
        lambda summary, last: summary["groups"][0]["kinematics"]["u_along_m_per_s"] * 7.5e-10 / 1e-6,
    ),
)

_HEAD = """# Engines side by side

```sh
tests/integration/engines.py        # writes this page
```

The same case files with `body.solver: own`, `bullet` and `mujoco`: what is compared with our own solver, and the time
of the body service per coupling step ({processor}; in the processes of a run, so without the messages).

| case | own | Bullet | MuJoCo | time per step: own | Bullet | MuJoCo |
|---|---|---|---|---|---|---|
"""

_TAIL = """
Deviations are those of a first-order method: half a step's way, h v/2 ([decision](../decisions/engines.md)). What an
engine cannot do is refused by the names of the features, before step 0: joints with Bullet, friction with MuJoCo,
periodic faces with both. Walls that move, and in MuJoCo rods, sliders, springs and drives in joints that close loops,
are refused with an error.
"""


def run(case, engine, folder):
    """(value, seconds per step), or the feature for which the case was refused."""
    file = ROOT / case.text if case.text.endswith(".yaml") else Path(folder) / "case.yaml"
    if not case.text.endswith(".yaml"):
        file.write_text(case.text)
    out = Path(folder) / f"{case.name} {engine}"
    command = [ROOT / "deploy/copepod", "run", file, "--out", out]
    for setting in (f"body.solver={engine}", "services.transport=ipc"):
        command += ["--set", setting]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        missing = re.search(r"cannot do \((.*?)\)", done.stderr)
        if missing:
            return missing[1]
        raise RuntimeError(f"{case.name} with {engine}: exit code {done.returncode}\n{done.stderr}")
    summary = json.loads((out / "summary.json").read_text())
    with open(out / "trajectory.csv") as rows:
        last = {row["body"]: row for row in csv.DictReader(rows)}
    return case.value(summary, last), sum(summary["phases_s"]["body"].values()) / summary["steps"]


def _row(case, folder):
    own, *others = results = [run(case, engine, folder) for engine in ENGINES]
    cells = [f"{own[0]:.5g}"]
    cells += [
        f"refused: {found}" if isinstance(found, str) else f"{100 * (found[0] / own[0] - 1):+.2g} %" for found in others
    ]
    cells += ["–" if isinstance(found, str) else f"{1e6 * found[1]:.1f} µs" for found in results]
    return f"| {case.name}: {case.what} | " + " | ".join(cells) + " |\n"


def main():
    processor = re.search(r"^model name\s*: (.*)$", Path("/proc/cpuinfo").read_text(), re.MULTILINE)[1]
    page = _HEAD.format(processor=processor)
    with tempfile.TemporaryDirectory() as folder:
        for case in CASES:
            row = _row(case, folder)
            print(row, end="", file=sys.stderr, flush=True)
            page += row
    (ROOT / "docs/results/engines.md").write_text(page + _TAIL)


if __name__ == "__main__":
    sys.exit(main())
