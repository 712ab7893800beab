#!/usr/bin/python3
"""Runs the quick swimmer with every fluid and every body component, each swapped by one option or one --set.

    tests/integration/combinations.py        runs all of them completely and writes docs/results/combinations.md
"""

import json
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
CASE = ROOT / "configs/quick/three_sphere.yaml"
_EXAMPLES = ROOT / "examples/python"

# what to add to the command for each component
FLUIDS = {
    "lattice": (),
    "stokes": ("--set", "fluid.solver=stokes"),
    "vacuum": ("--set", "fluid.solver=vacuum"),
    "Python": ("--fluid", f"/usr/bin/python3 {_EXAMPLES}/stokes_drag_fluid.py"),
}
BODIES = {
    "own": (),
    "Bullet": ("--set", "body.solver=bullet"),
    "MuJoCo": ("--set", "body.solver=mujoco"),
    "Python": ("--body", f"/usr/bin/python3 {_EXAMPLES}/point_masses.py"),
}

_HEAD = """# Every fluid with every body component

```sh
tests/integration/combinations.py        # writes this page
```

`configs/quick/three_sphere.yaml` in full; only the component changes: `--set fluid.solver=stokes`,
`--set fluid.solver=vacuum`, `--fluid "python3 examples/python/stokes_drag_fluid.py"`, `--set body.solver=bullet`
(or `mujoco`), `--body "python3 examples/python/point_masses.py"`. Speeds are in cells per step. Δ compares u_swim
with our own bodies in the same fluid. Wall times: {processor}.

| fluid | bodies | u_swim | Δ | d₁ [cells] | d₂ [cells] | sin(φ₁ − φ₂) | u_GA | u_swim to u_GA | wall time | digest |
|---|---|---|---|---|---|---|---|---|---|---|
"""

_TAIL = """
Differences and their causes:

* **Between bodies, in one fluid.** Bullet, MuJoCo and Python use semi-implicit Euler, so they agree to rounding; our
  own bodies use Runge-Kutta 4 with driving forces sampled inside the step. Euler with forces from the start of the step
  is off by half a step, ωh/2 = 8e-4 rad of the stroke's phase; amplitudes and speed differ by parts in a thousand or
  less. Digests differ because the hashed states differ.
* **Lattice against Stokes.** With the same spheres and springs the swimmer is 38 % faster in Stokes flow, which has
  neither inertia nor walls. At this short period the viscous penetration depth √(2ν/ω) is {depth:.1f} cells, less than
  an arm, so the arms oscillate differently (d₁, phase), and the interaction of the beads is weaker; walls 20 cells away
  contribute. Relative to the stroke, that is in u_swim/u_GA, the two are 10 % apart. [Stokes](stokes.md) compares them
  for design (a), whose period is seven times longer.
* **Stokes against u_GA.** The formula of Golestanian and Ajdari is the leading order of Stokes flow in a/l and d/l,
  both 1/4 here; the 10 % vanish with them as expected ([Stokes](stokes.md)).
* **Vacuum.** There is no propulsion without a fluid: u_swim is a remnant of the start of the stroke, which only the
  springs' dampers remove. u_GA is not zero there, since it depends on the arms only.
* **Python fluid.** It computes the Stokes drag of each sphere alone, without interaction, so there is no propulsion.
"""


def arguments(fluid, body):
    return [*FLUIDS[fluid], *BODIES[body]]


def run(folder, fluid, body, *more, environment=None):
    """(summary, wall time [s]) of one combination, run in `folder`. Raises RuntimeError with its stderr if it fails."""
    start = time.monotonic()
    out = Path(folder) / f"{fluid}_{body}"
    done = subprocess.run(
        [ROOT / "deploy/copepod", "run", CASE, "--out", out, *arguments(fluid, body), *more],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    if done.returncode:
        raise RuntimeError(f"{fluid} with {body}: exit code {done.returncode}\n{done.stderr}")
    return json.loads((out / "summary.json").read_text()), time.monotonic() - start


def _row(fluid, body, summary, wall_s, reference):
    swimmer = summary["swimmers"][0]
    speed = swimmer["u_swim_lattice"]
    theory = swimmer["u_GA_lattice"]
    difference = "–" if body == "own" or abs(reference) < 1e-12 else f"{100 * (speed / reference - 1):+.3f} %"
    against_theory = f"{100 * (speed / theory - 1):+.1f} %" if abs(speed) > 1e-12 else "–"
    return (
        f"| {fluid} | {body} | {speed:.4e} | {difference} | {swimmer['d1_cells']:.4f} | {swimmer['d2_cells']:.4f} | "
        f"{swimmer['sin_dphi']:.4f} | {theory:.3e} | {against_theory} | {wall_s:.0f} s | "
        f"`{summary['digest']}` |\n"
    )


def main():
    processor = re.search(r"^model name\s*: (.*)$", Path("/proc/cpuinfo").read_text(), re.MULTILINE)[1]
    page = _HEAD.format(processor=processor)
    with tempfile.TemporaryDirectory() as folder:
        for fluid in FLUIDS:
            reference = None
            for body in BODIES:
                summary, wall_s = run(folder, fluid, body)
                reference = reference or summary["swimmers"][0]["u_swim_lattice"]
                row = _row(fluid, body, summary, wall_s, reference)
                print(row, end="", file=sys.stderr, flush=True)
                page += row
    period = 4000
    depth_cells = (2 * (1 / 18) * period / (2 * 3.141592653589793)) ** 0.5
    (ROOT / "docs/results/combinations.md").write_text(page + _TAIL.format(depth=depth_cells))


if __name__ == "__main__":
    sys.exit(main())
