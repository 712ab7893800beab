"""Drag of pairs of spheres in slow flow, in a periodic cube."""

import math
from typing import NamedTuple

import numpy as np

from copepod_report.trajectory import Trajectory
from copepod_validation.experiment import CaseDict, Results, Section, lattice_case, sphere
from copepod_validation.experiment import table_by_point, uniform_flow, viscosity, worst

RADIUS = 4.0
# Series of the papers, summed anew: drag of each sphere by the gap over the radius.
FOLLOWING = {0.5: 0.67292, 1.0: 0.69830, 2.0: 0.74226}
APPROACHING = {0.02: 28.11402, 0.125: 6.31928, 0.5: 2.77242, 1.0: 2.03865, 2.0: 1.59668}
_SPEED, _APPROACH = 2e-4, 2e-9


class Point(NamedTuple):
    kind: str
    gap: float  # over the radius

    @property
    def edge(self) -> int:
        """Of the cube; between approaching spheres the images act less simply than is accounted for."""
        return 96 if self.kind == "approaching" else 64

    @property
    def steps(self) -> int:
        return 2500 if self.kind == "approaching" else 6000

    @property
    def reference(self) -> float:
        return (FOLLOWING if self.kind == "following" else APPROACHING)[self.gap]

    @property
    def body_force(self) -> float:
        """Lets the fluid flow at _SPEED past bodies at rest, by theory."""
        mobility = 1 / (RADIUS * self.reference) + _mobility_by_images(self)
        return 12 * np.pi * viscosity(1.0) * _SPEED / mobility / self.edge**3


POINTS = [Point("following", gap) for gap in FOLLOWING] + [Point("approaching", gap) for gap in APPROACHING]
LABEL = "{0.kind}_gap{0.gap:g}"
FAST = POINTS[:1]


def images(distance: float, edge: float) -> float:
    """6πμ times the velocity along z, at (0, 0, distance), that the images of a unit force along z in the periodic
    cube cause: Ewald's sum [Lindbo & Tornberg, J. Comput. Phys. 229, 2010, with ξ = 3/L] less the force's own field."""
    xi, steps = 3 / edge, np.arange(-4, 5)
    x, y, z = (axis.ravel() for axis in np.meshgrid(steps, steps, steps))
    r_z = edge * z + distance
    r = np.sqrt((edge * x) ** 2 + (edge * y) ** 2 + r_z**2)
    r, r_z = r[r > 0], r_z[r > 0]
    gauss = xi * np.exp(-((xi * r) ** 2)) / np.sqrt(np.pi)
    beyond = np.array([math.erfc(xi * one) for one in r])
    near = np.sum(2 * (gauss / r**2 + beyond / (2 * r**3)) * (r**2 + r_z**2) - 4 * gauss)
    k_z, k2 = (2 * np.pi / edge * z, (2 * np.pi / edge) ** 2 * (x**2 + y**2 + z**2))
    k_z, k2 = k_z[k2 > 0], k2[k2 > 0]
    waves = (1 + k2 / (4 * xi**2)) * (k2 - k_z**2) / k2**2 * np.exp(-k2 / (4 * xi**2))
    far = 8 * np.pi / edge**3 * np.sum(waves * np.cos(k_z * distance))
    own = 4 * xi / np.sqrt(np.pi) if distance == 0 else 2 / distance
    return float(0.75 * (near + far - own))


def _mobility_by_images(point: Point) -> float:
    """What the images add to U/F of each body, times 6πμ; the second term is the first one of their finite size.

    Nothing where a narrow gap keeps the bodies from following what the images' flow would do to their distance.
    """
    own, size = images(0, point.edge), 4 / 3 * np.pi * RADIUS**2 / point.edge**3
    if point.kind == "approaching" and point.gap < 0.5:
        return 0.0
    other = images((2 + point.gap) * RADIUS, point.edge)
    return own - other if point.kind == "approaching" else own + other + 2 * size


def case_of(point: Point) -> CaseDict:
    middle, approaches = 0.5 * point.edge, point.kind == "approaching"
    flow: CaseDict = {"symmetry_planes": ["x", "y"]}
    if not approaches:
        flow["body_force_N_per_m3"] = [0, 0, point.body_force]
        flow["initial_flow"] = uniform_flow(_SPEED)
    bodies = []
    for name, side in (("sphere", -1), ("other", 1)):
        place = (middle, middle, middle + 0.3 + side * (1 + 0.5 * point.gap) * RADIUS)
        motion: CaseDict = {"velocity_m_per_s": [0, 0, -side * _APPROACH]} if approaches else {}
        bodies.append(sphere(RADIUS, place, "prescribed" if approaches else "fixed", name=name, **motion))
    boundaries = {"x": "free_slip", "y": "free_slip", "z": "periodic"}  # x and y are planes of symmetry
    return lattice_case([point.edge] * 3, 1.0, boundaries, bodies, point.steps, **flow)


def evaluate(run: Trajectory, point: Point) -> float:
    """Error of the drag of the free bodies [%]."""
    force = np.array([run.of(name)["force_N"][:, 2] for name in run.bodies])
    last = float(np.abs(force[:, -100:]).mean())
    velocity = _APPROACH
    if point.kind != "approaching":
        # The velocity of the flow is what momentum it has left; a gradient of pressure would act on the bodies, too.
        share = 1 - 8 / 3 * np.pi * RADIUS**3 / point.edge**3
        driving = point.body_force * share
        velocity = share * _SPEED + float(np.sum(driving - force.sum(axis=0) / point.edge**3))
        last /= share
    mobility = 6 * np.pi * viscosity(1.0) * velocity / last - _mobility_by_images(point)
    return 100 * (1 / (mobility * RADIUS * point.reference) - 1)


def section(results: Results[float]) -> Section:
    def row(point: Point) -> str:
        return f"{point.kind} | {point.gap * RADIUS:g} | {point.reference:.3f}"

    table = table_by_point(results, "bodies | gap [cells] | drag over Stokes'", row, "{:+.2f}".format)
    return Section({"table": table}, worst(results, "slow bodies [%]", float))
