"""A sphere that moves near a wall, towards it or along it, so slowly and briefly that the gap stays what it is."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from copepod_report.style import LIGHT, new_figure, png_of
from copepod_report.trajectory import Trajectory
from copepod_validation.experiment import COLOURS, CaseDict, Experiment, Section, lattice_case, sphere, table, viscosity

REFERENCE = (
    "Drag over 6πμRU at the height h of the centre. Towards the wall: Brenner's series [Chem. Eng. Sci. 16, 1961]; "
    "along it: 1.3079 and 1.5675 at h/R of 2.3524 and 1.5431 [Goldman, Cox, Brenner, Chem. Eng. Sci. "
    "22, 1967]. Radius 4, τ = 1; a box of 16 × 16 × 12 radii, periodic along the wall, with a second wall opposite. "
    "The box lowers the drag along the wall at the wider gap by 2 %: in one of 32 × 24 × 18 radii the error of "
    "central_linear there is 0.0 %."
)
ALONG = {2.3524: 1.3079, 1.5431: 1.5675}
TOWARDS = (*ALONG, 1.26)  # a cell of fluid between the surfaces is the least
RADIUS = 4.0
_SPEED, _STEPS = 1e-6, 3000


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
    way: str  # "towards" or "along"
    height: float  # of the centre, over the radius
    tau: float

    @property
    def reference(self) -> float:
        return approach(self.height) if self.way == "towards" else ALONG[self.height]


def experiments(scheme: str, keys: Mapping[str, str], fast: bool) -> list[Experiment]:
    found = []
    points = [Point("towards", height, 1.0) for height in TOWARDS] + [Point("along", height, 1.0) for height in ALONG]
    for point in points[2:3] if fast else points:
        name = f"wall-{scheme}-{point.way}_height{point.height:g}_tau{point.tau:g}"
        found.append(Experiment(name, scheme, point, _case(point, keys)))
    return found


def _case(point: Point, keys: Mapping[str, str]) -> CaseDict:
    velocity = [0, 0, -_SPEED] if point.way == "towards" else [_SPEED, 0, 0]
    body = sphere(RADIUS, (32, 32, point.height * RADIUS), "prescribed", velocity_m_per_s=velocity)
    planes = ["x", "y"] if point.way == "towards" else ["y"]
    boundaries = {"x": "periodic", "z": "no_slip", **{axis: "free_slip" for axis in planes}}  # which here is periodic
    case = lattice_case(
        (64, 64, 48), point.tau, "periodic", [body], _STEPS, boundaries=boundaries, symmetry_planes=planes, **keys
    )
    case["output"] = {"trajectory": {"every_steps": 1, "from_step": _STEPS * 2 // 3}}
    return case


@dataclass(frozen=True)
class Drag:
    """Error of the drag, what the last third of the run changed in it, and how far it alternates between steps [%]."""

    error: float
    change: float
    alternating: float


def evaluate(folder: Path, experiment: Experiment) -> Drag:
    point = experiment.point
    force = Trajectory(folder / "trajectory.csv").of("sphere")["force_N"][1:-1, 2 if point.way == "towards" else 0]
    (before, last), step = (abs(force[place : place + 2].mean()) for place in (0, len(force) - 2)), force[-1] - force[
        -2
    ]
    stokes = 6 * np.pi * viscosity(point.tau) * RADIUS * _SPEED
    return Drag(100 * (last / (stokes * point.reference) - 1), 100 * abs(last / before - 1), 50 * abs(step / last))


def section(results: Sequence[tuple[Experiment, Drag]]) -> Section:
    schemes = list(dict.fromkeys(experiment.scheme for experiment, _ in results))
    errors = {(experiment.point, experiment.scheme): drag.error for experiment, drag in results}
    points = list(dict.fromkeys(experiment.point for experiment, _ in results))
    rows = [
        [point.way, f"{(point.height - 1) * RADIUS:.2f}", f"{point.reference:.3f}"]
        + [f"{errors[point, scheme]:+.2f}" for scheme in schemes]
        for point in points
    ]
    markdown = table(["way", "gap [cells]", "drag over Stokes'", *schemes], rows)
    change, alternating = max(drag.change for _, drag in results), max(drag.alternating for _, drag in results)
    markdown += (
        "\n\nError of the drag [%], mean of two steps, between which the sudden start leaves it alternating by up to "
        f"±{alternating:.1g} %. The last third of the runs changed it by at most {change:.1g} %.\n\n"
        "![Error of the drag over the gap](accuracy_wall.png)"
    )
    overview = {
        scheme: {"wall [%]": f"{max((errors[point, scheme] for point in points), key=abs):+.1f}"} for scheme in schemes
    }
    return Section(markdown, {"accuracy_wall.png": _figure(errors, points, schemes)}, overview)


def _figure(errors: Mapping[tuple[Point, str], float], points: Sequence[Point], schemes: Sequence[str]) -> bytes:
    figure, panels = new_figure(LIGHT, 3.2, ncols=2, sharey=True)
    for panel, way in zip(panels, ("towards", "along")):
        chosen = [point for point in points if point.way == way]
        for scheme in schemes:
            gaps = [(point.height - 1) * RADIUS for point in chosen]
            values = [errors[point, scheme] for point in chosen]
            panel.plot(gaps, values, "o-", markersize=4, linewidth=1, color=COLOURS[scheme], label=scheme)
        panel.axhline(0, color=LIGHT.ink, linewidth=0.8)
        panel.set_title(f"{way} the wall", fontsize=10)
        panel.set_xlim(0, 6)
        panel.set_xlabel("gap [cells]")
    panels[0].set_ylabel("error of the drag [%]")
    panels[-1].legend(fontsize=8, frameon=False)
    return png_of(figure)
