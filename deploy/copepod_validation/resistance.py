"""Resistances of a sphere beside a wall and of two spheres that slide past each other and turn, with their films."""

from typing import Any, NamedTuple

import numpy as np

from copepod_report.trajectory import Trajectory
from copepod_validation.experiment import CaseDict, Results, Section, grouped, lattice_case, sphere
from copepod_validation.experiment import table_by_point, viscosity, worst

_SPEED = 1e-9
# Centres along a wall, from a corner of the cells; the first is mirrored there, so that half of the domain is computed.
_PLACES = [(0.0, 0.0), *np.random.default_rng(1).random((4, 2)).tolist()]
_AT_WALL, _OF_PAIR = (0.5431, 0.1276, 0.0453, 0.01), (1.0, 0.2, 0.0453, 0.01)  # gaps over the radius
# Force and torque on the (first) sphere at each gap; NaN: zero, or an effect of the box as large as itself.
_LOADS: tuple[Any, ...] = (
    ("wall", "sliding", _AT_WALL, (1.5674, 0.01465), (2.1516, 0.07373), (2.6480, 0.14559), (3.4225, 0.27652)),
    ("wall", "turning", _AT_WALL, (0.01953, 1.0998), (0.09831, 1.3877), (0.19412, 1.6999), (0.36869, 2.2408)),
    ("pair", "sliding", _OF_PAIR, (1.38928, 0.12107), (1.83479, 0.3663), (2.30958, 0.68058), (2.8084, 1.03888)),
    ("pair", "rolling", _OF_PAIR, (0.16142, 1.03965), (0.4884, 1.21407), (0.90744, 1.49537), (1.38517, 1.84062)),
    ("pair", "geared", _OF_PAIR, (np.nan, 0.99632), (np.nan, 1.06555), (np.nan, 1.22414), (np.nan, 1.4295)),
    ("pair", "spinning", (0.1276, 0.01), (np.nan, 1.13609), (np.nan, 1.19097)),
    ("pair of 1:2", "sliding", (0.1276, 0.0453), (2.43781, 0.46411), (2.90915, 0.69435)),
)
EXACT = {(kind, way): dict(zip(gaps, loads)) for kind, way, gaps, *loads in _LOADS}


class Point(NamedTuple):
    kind: str
    way: str
    gap: float  # over the radius
    radius: float = 4.0
    place: int = 0  # number of it in _PLACES

    @property
    def reference(self) -> tuple[float, float]:
        return EXACT[self.kind, self.way][self.gap]


POINTS: list[Point] = []
_FINER = {
    ("wall", "sliding"): (0.1276, 0.0453),
    ("wall", "turning"): (0.1276, 0.0453),
    ("pair", "sliding"): (0.2, 0.0453),
    ("pair", "rolling"): (0.0453,),
    ("pair of 1:2", "sliding"): (0.0453,),
}
MORE = {
    "parabolic": [
        Point(*of, gap, place=place)
        for of, gaps in EXACT.items()
        for gap in gaps
        for place in range(len(_PLACES) if of[0] == "wall" else 1)
    ]
    + [Point(*of, gap, 8.0) for of, gaps in _FINER.items() for gap in gaps]
}
LABEL = "{0.kind}_{0.way}_gap{0.gap:g}_radius{0.radius:g}_place{0.place}"
FAST = [Point("wall", "sliding", 0.0453)]


def case_of(point: Point) -> CaseDict:
    R, at_wall = point.radius, point.kind == "wall"
    axis = "z" if point.way == "spinning" else "y"
    key, speed, along = "angular_velocity_rad_per_s", _SPEED / R, axis
    if point.way == "sliding":
        key, speed, along = "velocity_m_per_s", _SPEED, "x"
    box = [24, 24, 20] if at_wall else [20, 16, 20]
    height = 1 + point.gap if at_wall else 0.5 * box[2] - 0.5 * point.gap - 1
    others: dict[str, list[float]] = {"wall": [], "pair": [1.0], "pair of 1:2": [2.0]}
    bodies = []
    for radius, z, sign in [(1.0, height, 1), *((r, height + 1 + point.gap + r, -1) for r in others[point.kind])]:
        velocity = [sign * speed * (one == along) for one in "xyz"]
        if point.way == "rolling":
            velocity = [abs(one) for one in velocity]
        motion: CaseDict = {key: velocity, "name": "sphere" if sign > 0 else "other"}
        x, y = (0.5 * cells * R + off for cells, off in zip(box, _PLACES[point.place]))
        bodies.append(sphere(radius * R, (x, y, z * R), "prescribed", **motion))
    planes = [] if axis == "z" or point.place else ["y"]
    boundaries = {"x": "periodic", "y": "free_slip" if planes else "periodic", "z": "no_slip"}
    cells, steps = [int(edge * R) for edge in box], int(1000 * (R / 4) ** 2)
    return lattice_case(cells, 2.0, boundaries, bodies, steps, steps - 2, symmetry_planes=planes)


def evaluate(run: Trajectory, point: Point) -> tuple[float, float]:
    """Force and torque on the first sphere, scaled, positive where the reference is."""
    sample = run.of("sphere")
    force, torque = (sample[key][-2:].mean(axis=0) for key in ("force_N", "torque_N_m"))
    scale = np.pi * viscosity(2.0) * point.radius * _SPEED
    sign = {("wall", "sliding"): (-1, 1), ("wall", "turning"): (1, -1)}.get((point.kind, point.way), (-1, -1))
    of = 2 if point.way == "spinning" else 1
    return sign[0] * float(force[0]) / (6 * scale), sign[1] * float(torque[of]) / (8 * scale * point.radius)


def section(results: Results[tuple[float, float]]) -> Section:
    def row(point: Point) -> str:
        exact = ", ".join("–" if np.isnan(value) else f"{value:.4g}" for value in point.reference)
        return f"{point.kind} | {point.way} | {point.radius:g} | {point.gap:g} | {exact}"

    def text(errors: np.ndarray) -> str:
        if np.isnan(errors).any():
            return "–"
        spread = f" ± {np.abs(errors - errors.mean()).max():.1f}" if len(errors) > 1 else ""
        return f"{errors.mean():+.1f}{spread}"

    found = grouped(results, lambda point: point._replace(place=0))
    pairs = [(scheme, point, 100 * (np.array(values) / point.reference - 1)) for scheme, point, values in found]
    heads = "bodies | way | R [cells] | gap / R | exact force, torque"
    table = table_by_point(pairs, heads, row, lambda errors: ", ".join(map(text, errors.T)))
    large = [(scheme, point, errors[:, np.array(point.reference) > 0.3]) for scheme, point, errors in pairs]
    return Section({"table": table}, worst(large, "resistances [%]", lambda errors: float(max(errors.flat, key=abs))))
