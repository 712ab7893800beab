"""One flow in two frames of reference: a sphere that moves through fluid, and fluid that moves past a sphere."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from copepod_report.trajectory import Trajectory
from copepod_validation.experiment import CaseDict, Experiment, Section, lattice_case, sphere, table

REFERENCE = (
    "Galilean invariance: the force on a sphere is the same in every frame. A sphere of radius 4 in a periodic cube "
    "of 40 cells starts suddenly at 0.02 or 0.04 cells per step through fluid at rest; in the other frame the fluid "
    "starts at the same velocity, opposite, past a sphere at rest. Forces are means of steps 400 to 900."
)
RADIUS = 4.0
_CELLS, _FROM, _STEPS = 40, 400, 900


@dataclass(frozen=True)
class Point:
    frame: str  # "fluid" or "sphere": what moves
    speed: float
    tau: float


def experiments(scheme: str, keys: Mapping[str, str], fast: bool) -> list[Experiment]:
    pairs = [(speed, tau) for tau in (0.6, 1.0) for speed in (0.02, 0.04)]
    points = [Point(frame, *pair) for pair in (pairs[:1] if fast else pairs) for frame in ("fluid", "sphere")]
    return [
        Experiment(
            f"frames-{scheme}-{point.frame}_u{point.speed:g}_tau{point.tau:g}", scheme, point, _case(point, keys)
        )
        for point in points
    ]


def _case(point: Point, keys: Mapping[str, str]) -> CaseDict:
    place = (0.5 * _CELLS + 0.13, 0.5 * _CELLS + 0.31, 0.25 * _CELLS + 0.17)
    flow: CaseDict = {"kind": "rest"}
    if point.frame == "sphere":
        body = sphere(RADIUS, place, "prescribed", velocity_m_per_s=[0, 0, point.speed])
    else:
        body = sphere(RADIUS, place, "fixed")
        flow = {"kind": "uniform", "velocity_m_per_s": [0, 0, -point.speed]}
    case = lattice_case([_CELLS] * 3, point.tau, "periodic", [body], _STEPS, initial_flow=flow, **keys)
    case["output"] = {"trajectory": {"every_steps": 1, "from_step": _FROM}}
    return case


def evaluate(folder: Path, experiment: Experiment) -> float:
    """Mean force along z [N]."""
    trajectory = Trajectory(folder / "trajectory.csv")
    return float(np.mean(trajectory.of("sphere")["force_N"][trajectory.steps >= _FROM, 2]))


def section(results: Sequence[tuple[Experiment, float]]) -> Section:
    forces = {(experiment.scheme, experiment.point): force for experiment, force in results}
    schemes = list(dict.fromkeys(scheme for scheme, _ in forces))
    rows, worst = [], dict.fromkeys(schemes, 0.0)
    for point in dict.fromkeys(point for _, point in forces if point.frame == "sphere"):
        row = [f"{point.tau:g}", f"{point.speed:g}"]
        for scheme in schemes:
            at_rest = forces[scheme, Point("fluid", point.speed, point.tau)]
            error = 100 * (forces[scheme, point] / at_rest - 1)
            worst[scheme] = max(worst[scheme], error, key=abs)
            row.append(f"{error:+.2f}")
        rows.append(row)
    markdown = table(["τ", "velocity [cells/step]", *schemes], rows)
    markdown += "\n\nForce on the moving sphere relative to that on the sphere at rest, minus one [%]."
    return Section(markdown, {}, {scheme: {"frames [%]": f"{error:+.2f}"} for scheme, error in worst.items()})
