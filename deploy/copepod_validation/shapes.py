"""Drag of bodies of other shapes, aslant in slow flow, in a periodic cube.

    U = M F,   6πμ M = d dᵀ/ζ_along + (1 − d dᵀ)/ζ_across + what the images add,   d the body's axis
"""

import math
from typing import NamedTuple

import numpy as np

from copepod_report.trajectory import Trajectory
from copepod_validation.experiment import CaseDict, Results, Section, by_scheme, grouped, lattice_case
from copepod_validation.experiment import table_by_point, viscosity
from copepod_validation.slow_bodies import images

ASPECTS = {"prolate 2": 2.0, "prolate 3": 3.0, "oblate 2": 0.5, "oblate 3": 1 / 3}  # of spheroids: along over across
# Drag over 6πμR of a capsule twice as long as wide: singularities of the papers, summed anew.
CAPSULE = (1.3152990479696505, 1.4848097221802163)
CUBE = 0.6607  # hydrodynamic radius over the edge
_SHORTEST, _EDGE, _SPEED = 4.0, 12.0, 2e-4
_POSES = np.random.default_rng(1)
_CENTRES, _TURNS = _POSES.random((5, 3)), _POSES.normal(size=(5, 4))

Drags = tuple[float, float]  # along and across the axis


def spheroid_drag(aspect: float) -> Drags:
    """Over 6πμR of a sphere of its volume [Oberbeck, J. reine angew. Math. 81, 1876]."""
    e = math.sqrt(1 - min(aspect, 1 / aspect) ** 2)
    if aspect > 1:
        log = math.log((1 + e) / (1 - e))
        along, across = 8 / 3 / (-2 * e + (1 + e * e) * log), 16 / 3 / (2 * e + (3 * e * e - 1) * log)
        longest = aspect ** (2 / 3)
    else:
        root, angle = math.sqrt(1 - e * e), math.asin(e)
        along, across = 4 / 3 / (e * root + (2 * e * e - 1) * angle), 8 / 3 / (-e * root + (2 * e * e + 1) * angle)
        longest = aspect ** (-1 / 3)
    return longest * e**3 * along, longest * e**3 * across


def semi_axes(aspect: float) -> list[float]:
    """Of a spheroid about z, the shorter one as given [cells]."""
    across = _SHORTEST / min(aspect, 1)
    return [across, across, aspect * across]


class Point(NamedTuple):
    shape: str
    pose: int
    edge: int = 96  # of the periodic cube
    steps: int = 6000

    @property
    def keys(self) -> CaseDict:
        """Of the shape, and its mass in the fluid's density."""
        if self.shape == "capsule":
            volume = (4 / 3 + 2) * np.pi * _SHORTEST**3
            return {"shape": "capsule", "radius_m": _SHORTEST, "length_m": 2 * _SHORTEST, "mass_kg": volume}
        if self.shape == "cube":
            return {"shape": "box", "edges_m": 3 * [_EDGE], "mass_kg": _EDGE**3}
        axes = semi_axes(ASPECTS[self.shape])
        return {"shape": "ellipsoid", "semi_axes_m": axes, "mass_kg": 4 / 3 * np.pi * float(np.prod(axes))}

    @property
    def reference(self) -> Drags:
        """Over 6πμ."""
        if self.shape == "capsule":
            return CAPSULE[0] * _SHORTEST, CAPSULE[1] * _SHORTEST
        if self.shape == "cube":
            return CUBE * _EDGE, CUBE * _EDGE
        radius = float(np.cbrt(np.prod(semi_axes(ASPECTS[self.shape]))))
        along, across = spheroid_drag(ASPECTS[self.shape])
        return radius * along, radius * across

    @property
    def images(self) -> float:
        """What the images add to 6πμ M, to the first order of the body's size."""
        size = np.mean(np.square(self.keys.get("semi_axes_m", self.reference)))
        return images(0, self.edge) + float(4 / 3 * np.pi * size / self.edge**3)

    @property
    def turn(self) -> list[float]:
        """Unit quaternion."""
        turn = _TURNS[self.pose]
        return [float(number) for number in turn / np.linalg.norm(turn)]

    @property
    def axis(self) -> np.ndarray:
        w, x, y, z = self.turn
        return np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])

    @property
    def flow(self) -> np.ndarray:
        """6πμ times the velocity for a unit force along z, by theory."""
        along, across = self.reference
        return (1 / across + self.images) * np.array([0, 0, 1]) + (1 / along - 1 / across) * self.axis[2] * self.axis

    @property
    def velocity(self) -> np.ndarray:
        """Expected of the flow."""
        return _SPEED / self.flow[2] * self.flow

    @property
    def body_force(self) -> float:
        """Per volume, along z."""
        return float(6 * np.pi * viscosity(1.0) * _SPEED / self.flow[2] / self.edge**3)


POINTS = [Point(shape, pose) for shape in (*ASPECTS, "capsule", "cube") for pose in range(len(_CENTRES))]
LABEL = "{0.shape}_pose{0.pose}"
FAST = [Point("oblate 2", 0, 64, 1500)]


def case_of(point: Point) -> CaseDict:
    """Begins with the velocity expected."""
    place = 0.5 * point.edge + _CENTRES[point.pose]
    body = {"name": "body", "motion": "fixed", "position_m": place.tolist(), "orientation_wxyz": point.turn}
    flow: CaseDict = {"body_force_N_per_m3": [0, 0, point.body_force]}
    flow["initial_flow"] = {"kind": "uniform", "velocity_m_per_s": point.velocity.tolist()}
    return lattice_case([point.edge] * 3, 1.0, "periodic", [body | point.keys], point.steps, **flow)


def evaluate(run: Trajectory, point: Point) -> Drags:
    """Errors of the drag along and across the axis [%]."""
    force = run.of("body")["force_N"]
    # The velocity of the flow is what momentum it has left; a gradient of pressure would act on the body, too.
    share = 1 - point.keys["mass_kg"] / point.edge**3
    driving = np.array([0, 0, point.body_force * share])
    velocity = share * point.velocity + np.sum(driving - force / point.edge**3, axis=0)
    last = force[-100:].mean(axis=0) / share
    rest = 6 * np.pi * viscosity(1.0) * velocity - point.images * last
    along = (last @ point.axis) * point.axis
    (mobility_along, mobility_across), *_ = np.linalg.lstsq(np.column_stack([along, last - along]), rest, rcond=None)
    drag_along, drag_across = point.reference
    return 100 * (1 / (mobility_along * drag_along) - 1), 100 * (1 / (mobility_across * drag_across) - 1)


def section(results: Results[Drags]) -> Section:
    """A row per shape: means over the poses, and the largest deviation from them."""
    found = grouped(results, lambda point: point.shape)
    shapes = [(scheme, shape, np.array(errors)) for scheme, shape, errors in found]

    def cell(errors: np.ndarray) -> str:
        mean = errors.mean(axis=0)
        return "{:+.2f}, {:+.2f} ± {:.2f}".format(*mean, np.abs(errors - mean).max())

    overview = {}
    for scheme, of_shapes in by_scheme(shapes).items():
        means = [mean for each in of_shapes for mean in each.mean(axis=0)]
        overview[scheme, "spheroids, cube [%]"] = f"{min(means):+.2f} … {max(means):+.2f}"
    return Section({"table": table_by_point(shapes, "shape", str, cell)}, overview)
