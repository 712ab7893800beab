"""Spheres of any density that a constant force drives through fluid at rest: how they start, and where they tend to."""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from copepod_report.trajectory import Trajectory
from copepod_run.checkout import ROOT
from copepod_validation.experiment import CaseDict, Results, Section, lattice_case, sphere
from copepod_validation.experiment import table_by_point, viscosity, worst
from copepod_validation.sudden_start import inverse_laplace

BODIES = {
    "own": "own",
    "Bullet": "bullet",
    "Python": {"command": f"/usr/bin/python3 {ROOT}/examples/python/point_masses.py"},
}
_SPEED = {"terminal": 1e-4, "start": 1e-5}  # without walls, in cells per step
_STEPS = {"terminal": 20000, "start": 300}
_DENSITIES = (0.01, 0.1, 0.2, 0.5, 1.0, 10.0, 100.0)  # over the fluid's
_NEUTRAL = {0.55: 0.5433, 2 / 3: 0.5431, 1.0: 0.5430, 2.0: 0.5430}  # by τ: where heavier spheres start, as measured
_NEUTRAL_FINE = 0.4104  # the same at R = 8


class Point(NamedTuple):
    kind: str  # "terminal" or "start"
    density: float
    tau: float
    radius: float = 4.0
    bodies: str = "own"

    @property
    def cells(self) -> int:
        """Along an edge of the cube."""
        wide = self.radius > 4 or self.tau > 1  # images felt sooner
        return (128 if wide else 64) if self.kind == "start" else 16 + 4 * int(self.radius)

    @property
    def resistance(self) -> float:
        return 6 * np.pi * viscosity(self.tau) * self.radius


LABEL = "{0.kind}_r{0.radius:g}_tau{0.tau:.3g}_{0.bodies}_density{0.density:g}"
POINTS: list[Point] = []
FAST = [Point("start", 0.01, tau) for tau in (0.55, 1.0)]


def _points(kind: str, densities: Sequence[float], taus: Iterable[float], **more: Any) -> list[Point]:
    return [Point(kind, density, tau, **more) for tau in taus for density in densities]


_CHOSEN = [
    *_points("terminal", _DENSITIES, _NEUTRAL),
    *(point for bodies in ("Bullet", "Python") for point in _points("terminal", (0.01,), (0.55, 2.0), bodies=bodies)),
    *_points("terminal", (0.01, 1.0), (2 / 3, 2.0), radius=8.0),
    *_points("start", _DENSITIES[:-1], _NEUTRAL),
    *_points("start", (0.01,), _NEUTRAL, bodies="Python"),
]
_ALL_BODIES = [
    *(point for name in ("Bullet", "Python") for point in _points("terminal", (1.0, 100.0), (0.55, 2.0), bodies=name)),
    *_points("terminal", _DENSITIES, _NEUTRAL, radius=8.0),
    *_points("start", (0.01, 1.0, 10.0), _NEUTRAL, radius=8.0),
    *_points("start", (10.0,), (0.55, 2.0), bodies="Python"),  # Bullet has no periodic domains
]
MORE = {"central_linear": _CHOSEN, "parabolic": list(dict.fromkeys(_CHOSEN + _ALL_BODIES))}


def case_of(point: Point) -> CaseDict:
    speed, steps, fluid = _SPEED[point.kind], _STEPS[point.kind], {}
    force = point.resistance * speed
    boundaries, from_step, start = "no_slip", steps * 9 // 10, 0.0
    if point.kind == "start":
        boundaries, from_step = "periodic", 0
        fluid["body_force_N_per_m3"] = [0, 0, -force / point.cells**3]
    elif point.density > 1:  # its relaxation is longer than the run
        start = (_NEUTRAL[point.tau] if point.radius == 4 else _NEUTRAL_FINE) * speed
    place = [0.5 * point.cells + shift for shift in (0.3, 0.2, -0.9)]
    body = sphere(point.radius, place, "free", point.density, velocity_m_per_s=[0, 0, start])
    case = lattice_case([point.cells] * 3, point.tau, boundaries, [body], steps, from_step, **fluid)
    drive = {"kind": "world_force", "body": "sphere", "direction": [0, 0, 1]}
    case["actuators"] = [drive | {"signal": {"kind": "constant", "amplitude_N": force}}]
    return case | {"body": {"solver": BODIES[point.bodies]}}


def exact_start(point: Point) -> np.ndarray:
    """Velocity after each step, over the terminal one, of a sphere that a constant force sets into motion from rest:
        (ρ + 1/2) V' = D (1 − V) − 9/(2 r) √(ν/π) ∫ V'(s)/√(t − s) ds,   D = 9 ν/(2 r²)
    [Basset 1888; Maxey and Riley 1983]."""
    nu, r = viscosity(point.tau), point.radius
    drag = 4.5 * nu / r**2

    def transform(s: complex) -> complex:
        return complex(drag / s / ((point.density + 0.5) * s + drag + 4.5 / r * np.sqrt(nu * s)))

    return np.array([inverse_laplace(transform, step) for step in range(1, _STEPS["start"] + 1)])


def evaluate(run: Trajectory, point: Point) -> float:
    """Terminal velocity over that without walls; largest deviation of a start, from a third of the steps on [%]."""
    found = run.of("sphere")["velocity_m_per_s"][1:, 2] / _SPEED[point.kind]
    if point.kind == "terminal":
        return float(found.mean())
    # The force on the fluid accelerates it as a whole.
    drift = point.resistance / (point.cells**3 - 4 / 3 * np.pi * point.radius**3)
    exact = exact_start(point)
    deviation = np.abs((found + drift * np.arange(1, len(found) + 1)) / exact - 1)
    return float(100 * deviation[len(found) // 3 - 1 :].max())


def section(results: Results[float]) -> Section:
    values = {(scheme, point): value for scheme, point, value in results}

    def cell(scheme: str, point: Point, value: float) -> str:
        if point.kind == "start":
            return f"{value:.1f}"
        neutral = values[scheme, point._replace(density=1.0, bodies="own")]
        return f"{value:.4f} ({100 * (value / neutral - 1):+.2f})"

    tables = {}
    for kind in dict.fromkeys(point.kind for _, point, _ in results):
        found = [
            (f"ρ = {point.density:g}", (scheme, point._replace(density=0.0)), cell(scheme, point, value))
            for scheme, point, value in results
            if point.kind == kind
        ]
        row = "{0[0]} | {0[1].radius:g} | {0[1].tau:.3g} | {0[1].bodies}".format
        tables[kind] = table_by_point(found, "scheme | R [cells] | τ | bodies", row, str)
    starts = [result for result in results if result[1].kind == "start"]
    return Section(tables, worst(starts, "start of light bodies [%]", float, ".1f"))
