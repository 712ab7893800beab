"""One flow in two frames of reference: a sphere that moves through fluid, and fluid that moves past a sphere."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from copepod_report.trajectory import Trajectory
from copepod_validation.experiment import CaseDict, Results, Section, lattice_case, sphere
from copepod_validation.experiment import table_by_point, uniform_flow, worst

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


POINTS = [Point(frame, speed, tau) for tau in (0.6, 1.0) for speed in (0.02, 0.04) for frame in ("fluid", "sphere")]
LABEL = "{0.frame}_u{0.speed:g}_tau{0.tau:g}"
FAST = POINTS[:2]


def case_of(point: Point) -> CaseDict:
    place = (0.5 * _CELLS + 0.13, 0.5 * _CELLS + 0.31, 0.25 * _CELLS + 0.17)
    flow: CaseDict = {"kind": "rest"}
    if point.frame == "sphere":
        body = sphere(RADIUS, place, "prescribed", velocity_m_per_s=[0, 0, point.speed])
    else:
        body = sphere(RADIUS, place, "fixed")
        flow = uniform_flow(-point.speed)
    return lattice_case([_CELLS] * 3, point.tau, "periodic", [body], _STEPS, _FROM, initial_flow=flow)


def evaluate(folder: Path, point: Point) -> float:
    """Mean force along z [N]."""
    trajectory = Trajectory(folder)
    return float(np.mean(trajectory.of("sphere")["force_N"][trajectory.steps >= _FROM, 2]))


def section(results: Results[float]) -> Section:
    forces = {(scheme, point): force for scheme, point, force in results}
    errors = [
        (scheme, point, 100 * (force / forces[scheme, replace(point, frame="fluid")] - 1))
        for scheme, point, force in results
        if point.frame == "sphere"
    ]
    row = "{0.tau:g} | {0.speed:g}".format
    markdown = table_by_point(errors, "τ | velocity [cells/step]", row, "{:+.2f}".format)
    markdown += "\n\nForce on the moving sphere relative to that on the sphere at rest, minus one [%]."
    return Section(markdown, worst(errors, "frames [%]", float, "+.2f"))
