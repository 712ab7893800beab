"""One flow in two frames of reference: a sphere that moves through fluid, and fluid that moves past a sphere; a sphere
that turns in fluid at rest, and in fluid that carries it along."""

from typing import NamedTuple

import numpy as np

from copepod_report.trajectory import Trajectory
from copepod_validation.experiment import CaseDict, Results, Section, lattice_case, sphere
from copepod_validation.experiment import table_by_point, uniform_flow, worst

RADIUS = 4.0
_SPIN = 0.02 / RADIUS
_DISPLACED = 4.18879 * RADIUS**3
_CELLS, _FROM, _STEPS = 40, 400, 900


class Point(NamedTuple):
    frame: str  # "fluid" or "sphere": what moves; of a sphere that turns, the one in which all rests or moves
    speed: float
    tau: float
    motion: str = "moves"  # or "turns"


POINTS = [
    Point(frame, speed, tau, motion)
    for motion in ("moves", "turns")
    for tau in (0.6, 1.0)
    for speed in (0.02, 0.04)
    for frame in ("fluid", "sphere")
]
LABEL = "{0.motion}_{0.frame}_u{0.speed:g}_tau{0.tau:g}"
FAST = POINTS[:2]


def case_of(point: Point) -> CaseDict:
    turns = point.motion == "turns"
    place = (0.5 * _CELLS + (0.03 if turns else 0.13), 0.5 * _CELLS + 0.31, 0.25 * _CELLS + 0.17)
    motion: CaseDict = {"angular_velocity_rad_per_s": [_SPIN, 0, 0]} if turns else {}
    flow: CaseDict = {"kind": "rest"}
    if point.frame == "sphere":
        motion["velocity_m_per_s"] = [0, 0, point.speed]
        flow = uniform_flow(point.speed) if turns else flow
    elif not turns:
        flow = uniform_flow(-point.speed)
    body = sphere(RADIUS, place, "prescribed" if motion else "fixed", **motion)
    return lattice_case([_CELLS] * 3, point.tau, "periodic", [body], _STEPS, _FROM, initial_flow=flow)


def evaluate(run: Trajectory, point: Point) -> np.ndarray:
    """Mean force [N] and torque [N m]."""
    loads = run.of("sphere")
    return np.mean([loads["force_N"], loads["torque_N_m"]], axis=1)


def section(results: Results[np.ndarray]) -> Section:
    loads = {(scheme, point): value for scheme, point, value in results}
    moves, turns = [], []
    for scheme, point, (force, torque) in results:
        if point.frame == "fluid":
            continue
        other_force, other_torque = loads[scheme, point._replace(frame="fluid")]
        if point.motion == "moves":
            moves.append((scheme, point, 100 * (abs(force[2] / other_force[2]) - 1)))
            continue
        unit = _DISPLACED * _SPIN * point.speed
        of_torque = np.linalg.norm(torque - other_torque) / np.linalg.norm(other_torque)
        turns.append((scheme, point, (np.linalg.norm(force - other_force) / unit, 100 * of_torque)))
    row, heads = "{0.tau:g} | {0.speed:g}".format, "τ | velocity [cells/step]"
    tables = {
        "moves": table_by_point(moves, heads, row, "{:+.2f}".format),
        "turns": table_by_point(turns, heads, row, "{0[0]:.3f}, {0[1]:.2f}".format),
    }
    overview = worst(moves, "frames [%]", float, "+.2f")
    return Section(tables, overview | worst(turns, "frames, turning [ρVωv]", lambda both: both[0], ".3f"))
