"""A free sphere, capsule or spheroid between two walls that move in opposite directions."""

from dataclasses import dataclass

import numpy as np

from copepod_report.trajectory import Trajectory
from copepod_validation.experiment import CaseDict, Results, Section, lattice_case, sphere, table_by_point, worst
from copepod_validation.slow_bodies import ASPECTS

RADIUS, LENGTH = 4.0, 8.0  # of both; of the capsule's cylinder
_CELLS = 64


@dataclass(frozen=True)
class Point:
    shape: str
    tau: float
    rate: float
    steps: int


POINTS = [Point("sphere", 1.0, 4e-4, 1500), Point("capsule", 2.0, 1e-3, 9000)]  # over half an orbit of the capsule
POINTS += [Point(spheroid, 2.0, 1e-3, 12000) for spheroid in ASPECTS]
LABEL = "{0.shape}"
FAST = POINTS[:1]


def case_of(point: Point) -> CaseDict:
    body = sphere(RADIUS, 3 * [0.5 * _CELLS], "free")
    if point.shape == "capsule":
        body.update(shape="capsule", length_m=LENGTH, mass_kg=body["mass_kg"] + np.pi * RADIUS**2 * LENGTH)
    if point.shape in ASPECTS:
        across = RADIUS / min(ASPECTS[point.shape], 1)
        axes = [across, across, ASPECTS[point.shape] * across]
        del body["radius_m"]
        body.update(shape="ellipsoid", semi_axes_m=axes, mass_kg=4 / 3 * np.pi * float(np.prod(axes)))
    speed = point.rate * _CELLS / 2
    walls = {face: {"velocity_m_per_s": [0, 0, velocity]} for face, velocity in (("low", -speed), ("high", speed))}
    boundaries = {"x": walls, "y": "free_slip", "z": "periodic"}  # y is a plane of symmetry
    flow: CaseDict = {"symmetry_planes": ["y"], "initial_flow": {"kind": "shear"}}
    return lattice_case([_CELLS] * 3, point.tau, boundaries, [body], point.steps, **flow)


def evaluate(run: Trajectory, point: Point) -> tuple[float, float, float | None]:
    """Error of the mean rate, largest deviation from the form, both over γ/2 [%]; aspect ratio r of a capsule. Without
    the first third of the run, in which the rotation begins."""
    rate = -run.of("sphere")["angular_velocity_rad_per_s"][:, 1]
    angle, start = np.cumsum(rate), len(rate) // 3
    found = rate[start:] / (0.5 * point.rate)
    form = np.ones((len(found), 1))
    if point.shape != "sphere":
        form = np.column_stack([form, -np.cos(2 * angle[start:])])
    mean, *part = parts = np.linalg.lstsq(form, found, rcond=None)[0]
    aspect = float(np.sqrt((mean + part[0]) / (mean - part[0]))) if part else None
    return 100 * (mean - 1), 100 * np.abs(found - form @ parts).max(), aspect


def section(results: Results[tuple[float, float, float | None]]) -> Section:
    def cell(found: tuple[float, float, float | None]) -> str:
        return "{:+.2f} ± {:.1f}".format(*found) + (f" (r = {found[2]:.2f})" if found[2] else "")

    markdown = table_by_point(results, "body | τ", "{0.shape} | {0.tau:g}".format, cell)
    markdown += "\n\nError of the mean rate ± largest deviation from the form [% of γ/2]."
    return Section(markdown, worst(results, "shear [%]", lambda found: found[0]))
