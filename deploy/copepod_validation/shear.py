"""A free sphere and a free capsule between two walls that move in opposite directions."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from copepod_report.trajectory import Trajectory
from copepod_validation.experiment import CaseDict, Results, Section, lattice_case, sphere, table_by_point, worst

REFERENCE = (
    "Jeffery's orbit [Proc. R. Soc. A 102, 1922]: in shear at the rate γ a body of revolution, whose axis has turned "
    "by θ from the flow, rotates at γ/2 (1 − (r² − 1)/(r² + 1) cos 2θ), a sphere at γ/2. Every such body has an "
    "aspect ratio r [Bretherton, J. Fluid Mech. 14, 1962]; that of a capsule is measured, and the test is that the "
    "rotation has this form with the mean γ/2. Radius 4, capsule of length 16, in a cube of 64 cells between walls; "
    "half the length squared times γ/ν is 0.04 and 0.13."
)
RADIUS, LENGTH = 4.0, 8.0  # of both; of the capsule's cylinder
_CELLS = 64


@dataclass(frozen=True)
class Point:
    shape: str
    tau: float
    rate: float
    steps: int


POINTS = [Point("sphere", 1.0, 4e-4, 1500), Point("capsule", 2.0, 1e-3, 9000)]  # over half an orbit of the capsule
LABEL = "{0.shape}"
FAST = POINTS[:1]


def case_of(point: Point) -> CaseDict:
    body = sphere(RADIUS, 3 * [0.5 * _CELLS], "free")
    if point.shape == "capsule":
        body.update(shape="capsule", length_m=LENGTH, mass_kg=body["mass_kg"] + np.pi * RADIUS**2 * LENGTH)
    speed = point.rate * _CELLS / 2
    walls = {face: {"velocity_m_per_s": [0, 0, velocity]} for face, velocity in (("low", -speed), ("high", speed))}
    boundaries = {"x": walls, "y": "free_slip", "z": "periodic"}  # y is a plane of symmetry
    flow: CaseDict = {"symmetry_planes": ["y"], "initial_flow": {"kind": "shear"}}
    return lattice_case([_CELLS] * 3, point.tau, boundaries, [body], point.steps, **flow)


@dataclass(frozen=True)
class Rotation:
    """Error of the mean rate, largest deviation from the form, both over γ/2 [%]; aspect ratio r of a capsule."""

    error: float
    deviation: float
    aspect: float | None


def evaluate(folder: Path, point: Point) -> Rotation:
    """Without the first third of the run, in which the rotation begins."""
    rate = -Trajectory(folder).of("sphere")["angular_velocity_rad_per_s"][:, 1]
    angle, start = np.cumsum(rate), len(rate) // 3
    found = rate[start:] / (0.5 * point.rate)
    form = np.ones((len(found), 1))
    if point.shape == "capsule":
        form = np.column_stack([form, -np.cos(2 * angle[start:])])
    mean, *part = parts = np.linalg.lstsq(form, found, rcond=None)[0]
    aspect = float(np.sqrt((mean + part[0]) / (mean - part[0]))) if part else None
    return Rotation(100 * (mean - 1), 100 * np.abs(found - form @ parts).max(), aspect)


def section(results: Results[Rotation]) -> Section:
    def cell(one: Rotation) -> str:
        return f"{one.error:+.2f} ± {one.deviation:.1f}" + (f" (r = {one.aspect:.2f})" if one.aspect else "")

    markdown = table_by_point(results, "body | τ", "{0.shape} | {0.tau:g}".format, cell)
    markdown += "\n\nError of the mean rate ± largest deviation from the form [% of γ/2]."
    return Section(markdown, worst(results, "shear [%]", lambda rotation: rotation.error))
