"""A sphere that moves near a wall or turns there, so slowly and briefly that the gap stays what it is."""

from typing import NamedTuple

import numpy as np

from copepod_report.style import LIGHT, describe, new_figure, picture_of
from copepod_report.trajectory import Trajectory
from copepod_validation.experiment import COLOURS, CaseDict, Results, Section, by_scheme, lattice_case, sphere
from copepod_validation.experiment import table_by_point, viscosity, worst

_SPEED = 1e-9  # of the surface


def approach(height: float) -> float:
    """Drag of a sphere that moves towards a wall over Stokes' [Brenner 1961]; `height` of its centre over its radius.

    λ = 4/3 sinh α Σ n(n+1)/((2n−1)(2n+3)) [(2 sinh (2n+1)α + (2n+1) sinh 2α)/(4 sinh² (n+½)α − (2n+1)² sinh² α) − 1]
    """
    alpha = np.arccosh(height)
    n = np.arange(1, int(25 / alpha) + 2)
    above = 2 * np.sinh((2 * n + 1) * alpha) + (2 * n + 1) * np.sinh(2 * alpha)
    below = 4 * np.sinh((n + 0.5) * alpha) ** 2 - (2 * n + 1) ** 2 * np.sinh(alpha) ** 2
    terms = n * (n + 1) / ((2 * n - 1) * (2 * n + 3)) * (above / below - 1)
    return float(4 / 3 * np.sinh(alpha) * terms.sum())


DRAG = {  # by the height of the centre over the radius
    "towards": {height: approach(height) for height in (2.3524, 1.5431, 1.26, 1.125, 1.06, 1.02)},
    "along": {2.3524: 1.3079, 1.5431: 1.5675, 1.1276: 2.1514, 1.0453: 2.6475, 1.005004: 3.7863},
    "turning": {1.5431: 1.0998, 1.1276: 1.3877, 1.0453: 1.6996, 1.005004: 2.5056},
}


class Point(NamedTuple):
    way: str  # "towards", "along" or "turning"
    height: float  # of the centre, over the radius
    radius: float = 4.0

    @property
    def gap(self) -> float:
        """[cells]"""
        return (self.height - 1) * self.radius

    @property
    def steps(self) -> int:
        return int(3000 * (self.radius / 4) ** 1.5)

    @property
    def reference(self) -> float:
        return DRAG[self.way][self.height]


POINTS = [Point(way, height) for way, drags in DRAG.items() for height in drags]
LABEL = "{0.way}_height{0.height:g}_radius{0.radius:g}"
FAST = POINTS[4:5]
_FINE = (("towards", 1.06), ("towards", 1.02), ("along", 1.0453), ("turning", 1.0453))
MORE = {"parabolic": [Point(*fine, 8.0) for fine in _FINE]}  # boxes of 16 radii: 2700 points to the cube of the radius


def case_of(point: Point) -> CaseDict:
    R = point.radius
    motion: CaseDict = {"velocity_m_per_s": [0, 0, -_SPEED] if point.way == "towards" else [_SPEED, 0, 0]}
    if point.way == "turning":
        motion = {"angular_velocity_rad_per_s": [0, _SPEED / R, 0]}
    body = sphere(R, (8 * R, 8 * R, point.height * R), "prescribed", **motion)
    planes = ["x", "y"] if point.way == "towards" else ["y"]
    boundaries = {"x": "periodic", "z": "no_slip", **{axis: "free_slip" for axis in planes}}  # which here is periodic
    box, start = [int(16 * R), int(16 * R), int(12 * R)], point.steps * 2 // 3
    return lattice_case(box, 1.0, boundaries, [body], point.steps, start, symmetry_planes=planes)


def evaluate(run: Trajectory, point: Point) -> tuple[float, float, float]:
    """Error of the load, what the last third of the run changed in it, how far it alternates between steps [%]."""
    sample = run.of("sphere")
    if point.way == "turning":
        load, stokes = sample["torque_N_m"][1:-1, 1], 8 * np.pi * viscosity(1.0) * point.radius**2 * _SPEED
    else:
        load = sample["force_N"][1:-1, 2 if point.way == "towards" else 0]
        stokes = 6 * np.pi * viscosity(1.0) * point.radius * _SPEED
    before, last = (abs(load[place : place + 2].mean()) for place in (0, len(load) - 2))
    step = load[-1] - load[-2]
    return 100 * (last / (stokes * point.reference) - 1), 100 * abs(last / before - 1), 50 * abs(step / last)


def section(results: Results[tuple[float, float, float]]) -> Section:
    heads = "way | R [cells] | gap [cells] | over Stokes'"
    row = "{0.way} | {0.radius:g} | {0.gap:.2f} | {0.reference:.3f}".format
    _, change, alternating = np.max([found for _, _, found in results], axis=0)
    table = table_by_point(results, heads, row, "{0[0]:+.2f}".format, none="")
    values = {"table": table, "alternating": f"{alternating:.1g}", "change": f"{change:.1g}"}
    overview = worst(results, "wall [%]", lambda found: found[0])
    return Section(values, overview, {"accuracy_wall.png": _figure(results)})


def _figure(results: Results[tuple[float, float, float]]) -> bytes:
    figure, panels = new_figure(3.2, ncols=3, sharey=True)
    for panel, way in zip(panels, DRAG):
        for scheme in by_scheme(results):
            chosen = [(p.gap, found[0]) for one, p, found in results if (one, p.way, p.radius) == (scheme, way, 4)]
            gaps, errors = np.reshape(chosen, (-1, 2)).T
            panel.semilogx(gaps, errors, "o-", markersize=4, linewidth=1, color=COLOURS[scheme], label=scheme)
        panel.axhline(0, color=LIGHT.ink, linewidth=0.8)
        describe(panel, f"{way} the wall" if way != "turning" else "turning", xlabel="gap [cells]")
    panels[0].set_ylabel("error of the load [%]")
    describe(panels[-1], legend={})
    return picture_of(figure)
