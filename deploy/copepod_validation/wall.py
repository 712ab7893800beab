"""A sphere that moves near a wall or turns there, so slowly and briefly that the gap stays what it is."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from copepod_report.style import LIGHT, new_figure, png_of
from copepod_report.trajectory import Trajectory
from copepod_validation.experiment import (
    COLOURS,
    CaseDict,
    Experiment,
    Section,
    by_point,
    lattice_case,
    sphere,
    table,
    viscosity,
)

REFERENCE = (
    "Drag over 6πμRU, torque over 8πμR³Ω. Towards the wall: Brenner's series [Chem. Eng. Sci. 16, 1961]; along it "
    "and turning about an axis along it: Goldman, Cox, Brenner [Chem. Eng. Sci. 22, 1967]. τ = 1; boxes of 16 × "
    "16 × 12 radii, periodic along the wall, with a second wall opposite. The box lowers the drag along the wall "
    "at the widest gap by 2 %: in one of 32 × 24 × 18 radii the error of central_linear there is 0.0 %. All with "
    "`lubrication: {cut_off_cells: auto}`, which acts at gaps below two cells."
)
TOWARDS = (2.3524, 1.5431, 1.26, 1.125, 1.06, 1.02)  # height of the centre over the radius
ALONG = {2.3524: 1.3079, 1.5431: 1.5675, 1.1276: 2.1514, 1.0453: 2.6475, 1.005004: 3.7863}
TURNING = {1.5431: 1.0998, 1.1276: 1.3877, 1.0453: 1.6996, 1.005004: 2.5056}
# Each in boxes of 16 radii: 2700 points to the cube of the radius.
FINE = (("towards", 1.06), ("towards", 1.02), ("along", 1.0453), ("turning", 1.0453))
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


@dataclass(frozen=True)
class Point:
    way: str  # "towards", "along" or "turning"
    height: float  # of the centre, over the radius
    radius: float

    @property
    def gap(self) -> float:
        """[cells]"""
        return (self.height - 1) * self.radius

    @property
    def steps(self) -> int:
        return int(3000 * (self.radius / 4) ** 1.5)

    @property
    def reference(self) -> float:
        if self.way == "towards":
            return approach(self.height)
        return (ALONG if self.way == "along" else TURNING)[self.height]


def experiments(scheme: str, keys: Mapping[str, str], fast: bool) -> list[Experiment]:
    ways = {"towards": TOWARDS, "along": ALONG, "turning": TURNING}
    points = [Point(way, height, 4.0) for way, heights in ways.items() for height in heights]
    if scheme == "parabolic":
        points += [Point(way, height, 8.0) for way, height in FINE]
    return [
        Experiment(
            f"wall-{scheme}-{point.way}_height{point.height:g}_radius{point.radius:g}",
            scheme,
            point,
            _case(point, keys),
        )
        for point in (points[4:5] if fast else points)
    ]


def _case(point: Point, keys: Mapping[str, str]) -> CaseDict:
    R = point.radius
    motion: CaseDict = {"velocity_m_per_s": [0, 0, -_SPEED] if point.way == "towards" else [_SPEED, 0, 0]}
    if point.way == "turning":
        motion = {"angular_velocity_rad_per_s": [0, _SPEED / R, 0]}
    body = sphere(R, (8 * R, 8 * R, point.height * R), "prescribed", **motion)
    planes = ["x", "y"] if point.way == "towards" else ["y"]
    boundaries = {"x": "periodic", "z": "no_slip", **{axis: "free_slip" for axis in planes}}  # which here is periodic
    box = [int(16 * R), int(16 * R), int(12 * R)]
    case = lattice_case(
        box, 1.0, "periodic", [body], point.steps, boundaries=boundaries, symmetry_planes=planes, **keys
    )
    case["lubrication"] = {"cut_off_cells": "auto"}
    case["output"] = {"trajectory": {"every_steps": 1, "from_step": point.steps * 2 // 3}}
    return case


@dataclass(frozen=True)
class Drag:
    """Error of the drag, what the last third of the run changed in it, and how far it alternates between steps [%]."""

    error: float
    change: float
    alternating: float


def evaluate(folder: Path, experiment: Experiment) -> Drag:
    point, sample = experiment.point, Trajectory(folder / "trajectory.csv").of("sphere")
    if point.way == "turning":
        load, stokes = sample["torque_N_m"][1:-1, 1], 8 * np.pi * viscosity(1.0) * point.radius**2 * _SPEED
    else:
        load = sample["force_N"][1:-1, 2 if point.way == "towards" else 0]
        stokes = 6 * np.pi * viscosity(1.0) * point.radius * _SPEED
    before, last = (abs(load[place : place + 2].mean()) for place in (0, len(load) - 2))
    step = load[-1] - load[-2]
    return Drag(100 * (last / (stokes * point.reference) - 1), 100 * abs(last / before - 1), 50 * abs(step / last))


def section(results: Sequence[tuple[Experiment, Drag]]) -> Section:
    schemes, values = by_point(results)
    rows = [
        [point.way, f"{point.radius:g}", f"{point.gap:.2f}", f"{point.reference:.3f}"]
        + [f"{drags[scheme].error:+.2f}" if scheme in drags else "" for scheme in schemes]
        for point, drags in values.items()
    ]
    markdown = table(["way", "R [cells]", "gap [cells]", "over Stokes'", *schemes], rows)
    change, alternating = max(drag.change for _, drag in results), max(drag.alternating for _, drag in results)
    markdown += (
        "\n\nError of the load [%], mean of two steps, between which the sudden start leaves it alternating by up to "
        f"±{alternating:.1g} %. The last third of the runs changed it by at most {change:.1g} %.\n\n"
        "![Error of the load over the gap](accuracy_wall.png)"
    )
    worst = {
        scheme: max((drags[scheme].error for drags in values.values() if scheme in drags), key=abs)
        for scheme in schemes
    }
    overview = {scheme: {"wall [%]": f"{error:+.1f}"} for scheme, error in worst.items()}
    return Section(markdown, {"accuracy_wall.png": _figure(schemes, values)}, overview)


def _figure(schemes: Sequence[str], values: Mapping[Point, Mapping[str, Drag]]) -> bytes:
    figure, panels = new_figure(LIGHT, 3.2, ncols=3, sharey=True)
    for panel, way in zip(panels, ("towards", "along", "turning")):
        chosen = [point for point in values if point.way == way and point.radius == 4]
        for scheme in schemes:
            panel.semilogx(
                [point.gap for point in chosen],
                [values[point][scheme].error for point in chosen],
                "o-",
                markersize=4,
                linewidth=1,
                color=COLOURS[scheme],
                label=scheme,
            )
        panel.axhline(0, color=LIGHT.ink, linewidth=0.8)
        panel.set_title(f"{way} the wall" if way != "turning" else "turning", fontsize=10)
        panel.set_xlabel("gap [cells]")
    panels[0].set_ylabel("error of the load [%]")
    panels[-1].legend(fontsize=8, frameon=False)
    return png_of(figure)
