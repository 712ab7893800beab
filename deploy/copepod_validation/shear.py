"""A free ellipsoid or capsule between two walls that move in opposite directions.

    ω₁ = Ω₁ + (b² − c²)/(b² + c²) E₂₃, and so on by turns, in the frame of an ellipsoid's semi-axes a, b, c;
    E and Ω: rate of strain and rotation of the undisturbed flow           [Jeffery, Proc. R. Soc. A 102, 1922]
"""

from typing import NamedTuple

import numpy as np

from copepod_report.run_record import rotated
from copepod_report.trajectory import Trajectory
from copepod_validation.experiment import CaseDict, Results, Section, lattice_case, sphere, table_by_point, worst
from copepod_validation.shapes import ASPECTS, semi_axes

RADIUS, LENGTH = 4.0, 8.0  # of the capsule, and its cylinder
AXES = {"sphere": 3 * [RADIUS], **{shape: semi_axes(ASPECTS[shape]) for shape in ASPECTS}, "triaxial": [4.0, 6.0, 9.0]}
_CELLS = 64
_TURN = [0.8, 0.36, 0.48, 0.0]  # unit quaternion of the body with three different axes


class Point(NamedTuple):
    shape: str
    tau: float
    rate: float
    steps: int


POINTS = [Point("sphere", 1.0, 4e-4, 1500), Point("capsule", 2.0, 1e-3, 9000)]  # over half an orbit of the capsule
POINTS += [Point(shape, 2.0, 1e-3, 12000) for shape in (*ASPECTS, "triaxial")]
LABEL = "{0.shape}"
FAST = POINTS[:1]

Found = tuple[float, float, str]


def case_of(point: Point) -> CaseDict:
    body = sphere(RADIUS, 3 * [0.5 * _CELLS], "free")
    planes = ["y"]
    if point.shape == "capsule":
        body.update(shape="capsule", length_m=LENGTH, mass_kg=body["mass_kg"] + np.pi * RADIUS**2 * LENGTH)
    elif point.shape != "sphere":
        del body["radius_m"]
        axes = AXES[point.shape]
        body.update(shape="ellipsoid", semi_axes_m=axes, mass_kg=4 / 3 * np.pi * float(np.prod(axes)))
    if point.shape == "triaxial":
        planes, body["orientation_wxyz"] = [], _TURN
    speed = point.rate * _CELLS / 2
    walls = {face: {"velocity_m_per_s": [0, 0, velocity]} for face, velocity in (("low", -speed), ("high", speed))}
    boundaries = {"x": walls, "y": "free_slip" if planes else "periodic", "z": "periodic"}
    flow: CaseDict = {"symmetry_planes": planes, "initial_flow": {"kind": "shear"}}
    return lattice_case([_CELLS] * 3, point.tau, boundaries, [body], point.steps, **flow)


def jeffery(axes: list[float], orientation: np.ndarray, rate: float) -> np.ndarray:
    """Angular velocity in shear, shape (…, 3), of an ellipsoid with these unit quaternions, shape (…, 4)."""
    back = orientation * [1, -1, -1, -1]
    flow, gradient, vorticity = (rotated(np.eye(3)[axis], back) for axis in (2, 0, 1))
    a, b, c = np.square(axes)
    form = np.array([(b - c) / (b + c), (c - a) / (c + a), (a - b) / (a + b)])
    one, other = [1, 2, 0], [2, 0, 1]
    strain = flow[..., one] * gradient[..., other] + flow[..., other] * gradient[..., one]
    return rotated(0.5 * rate * (form * strain - vorticity), orientation)


def angle_to_jeffery(axes: list[float], orientation: np.ndarray, rate: float) -> float:
    """Between the last of the orientations after each step and that to which the equation leads from the first [°]."""

    def change(quaternion: np.ndarray) -> np.ndarray:
        (w, *r), omega = quaternion, jeffery(axes, quaternion, rate)
        return 0.5 * np.concatenate([[-omega @ r], w * omega + np.cross(omega, r)])

    theory = orientation[0]
    for _ in orientation[1:]:
        theory = theory + change(theory + 0.5 * change(theory))
        theory /= np.linalg.norm(theory)
    return float(np.degrees(2 * np.arccos(min(1.0, abs(theory @ orientation[-1])))))


def evaluate(run: Trajectory, point: Point) -> Found:
    """Error of the rate and largest deviation from the form, both over γ/2 [%], without the first third of the run, in
    which the rotation begins; aspect ratio r of a capsule, or angle between an ellipsoid and theory at the end."""
    body = run.of("sphere")
    rates = body["angular_velocity_rad_per_s"] / (0.5 * point.rate)
    start = len(rates) // 3
    if point.shape == "capsule":
        angle = np.cumsum(-0.5 * point.rate * rates[:, 1])[start:]
        forms, found = np.column_stack([np.ones(len(angle)), -np.cos(2 * angle)]), -rates[start:, 1]
        mean, part = parts = np.linalg.lstsq(forms, found, rcond=None)[0]
        return 100 * (mean - 1), _most(found - forms @ parts), f"r = {np.sqrt((mean + part) / (mean - part)):.2f}"
    axes, orientation = AXES[point.shape], body["orientation_wxyz"][start:]
    form, found = jeffery(axes, orientation, point.rate) / (0.5 * point.rate), rates[start:]
    mean = np.sum(found * form) / np.sum(form**2)
    angle = angle_to_jeffery(axes, orientation, point.rate)
    return 100 * (mean - 1), _most(found - mean * form), f"{angle:.1f}°"


def _most(deviations: np.ndarray) -> float:
    return float(100 * np.abs(deviations).max())


def section(results: Results[Found]) -> Section:
    row, cell = "{0.shape} | {0.tau:g}".format, "{0[0]:+.2f} ± {0[1]:.1f} ({0[2]})".format
    table = table_by_point(results, "body | τ", row, cell)
    return Section({"table": table}, worst(results, "shear [%]", lambda found: found[0]))
