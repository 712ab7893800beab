"""Drag of a simple cubic array of spheres: a fixed sphere in a periodic cube, driven by a body force.

    K(φ) = f L³/(6π μ R U),   U the superficial velocity                         [Zick & Homsy 1982, table 2]
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from copepod_report.style import LIGHT, new_figure, png_of
from copepod_validation.experiment import COLOURS, CaseDict, Experiment, Section, lattice_case, sphere, table, viscosity

REFERENCE = (
    "K = fL³/(6πμRU) of simple cubic arrays, f the body force, U the superficial velocity: 2.008, 4.292, 15.4 and "
    "28.1 at solid fractions φ of 0.027, 0.125, 0.343 and 0.45 [Zick & Homsy, J. Fluid Mech. 115, 1982]. Reynolds "
    "number 0.01. For each point the sphere's centre has five places between the cells (random, fixed seed). bgk is "
    "unstable at τ = 0.51."
)
DRAG = {0.027: 2.008, 0.125: 4.292, 0.343: 15.4, 0.45: 28.1}

Groups = dict[tuple[float, int, float], dict[str, list[float]]]  # (φ, cells, τ): scheme: errors [%]

_CENTRES = np.random.default_rng(1).random((5, 3))
_OUTPUTS = 5
_TICKS = (-30, -10, -5, -2, 0, 2, 5, 10, 20)  # of the figure [%]
_RELAXATIONS = 5


@dataclass(frozen=True)
class Point:
    solid_fraction: float
    cells: int  # along an edge of the cube
    tau: float
    centre: int

    @property
    def radius(self) -> float:
        return float(self.cells * np.cbrt(0.75 * self.solid_fraction / np.pi))


def _points(fast: bool) -> list[Point]:
    grid = [(0.125, 13, 0.6), (0.125, 13, 2.0)]
    if not fast:  # low relaxation times and dense arrays at fine resolution take hours
        grid += [(0.125, 13, 0.51), *((0.125, cells, tau) for cells in (20, 32) for tau in (0.6, 2.0))]
        grid += [(0.027, 22, 0.6), (0.027, 22, 2.0), (0.343, 32, 0.6), (0.45, 32, 0.6)]
    return [Point(*values, centre) for values in grid for centre in range(len(_CENTRES))]


def experiments(scheme: str, keys: Mapping[str, str], fast: bool) -> list[Experiment]:
    found = []
    for point in _points(fast):
        if keys["collision"] == "bgk" and point.tau < 0.52:
            continue  # unstable
        label = f"phi{point.solid_fraction:g}_L{point.cells}_tau{point.tau:g}_centre{point.centre}"
        found.append(Experiment(f"sphere_array-{scheme}-{label}", scheme, point, _case(point, keys)))
    return found


def _case(point: Point, keys: Mapping[str, str]) -> CaseDict:
    """Starts with the expected mean velocity; what is left of the start decays with V/(6π ν R K) at the slowest."""
    nu, edge, radius = viscosity(point.tau), point.cells, point.radius
    velocity = 0.01 * nu / (2 * radius)
    resistance = 6 * np.pi * nu * radius * DRAG[point.solid_fraction]
    slowest = max(edge**3 / resistance, edge**2 / (4 * np.pi**2 * nu))
    between = max(8, int(np.ceil(_RELAXATIONS * slowest / _OUTPUTS)))
    centre = 0.5 * edge + _CENTRES[point.centre]
    force = float(resistance * velocity / edge**3)
    case = lattice_case(
        [edge] * 3,
        point.tau,
        "periodic",
        [sphere(radius, centre, "fixed")],
        _OUTPUTS * between,
        body_force_N_per_m3=[0, 0, force],
        initial_flow={"kind": "uniform", "velocity_m_per_s": [0, 0, float(velocity)]},
        **keys,
    )
    case["output"] = {"fields": {"every_steps": between}}
    return case


@dataclass(frozen=True)
class Drag:
    """Error of K, and what the last fifth of the run changed in it [%]."""

    error: float
    change: float


def evaluate(folder: Path, experiment: Experiment) -> Drag:
    point, fluid = experiment.point, experiment.case["fluid"]
    velocities = []
    with h5py.File(folder / "fields.h5", "r") as file:
        for name in sorted(name for name in file if name.startswith("step_"))[-4:]:
            is_fluid = file[name]["body"][:] == 0
            momentum = file[name]["density_kg_per_m3"][:] * file[name]["velocity_m_per_s"][..., 2]
            velocities.append(momentum[is_fluid].sum() / point.cells**3)
    force = fluid["body_force_N_per_m3"][2] * point.cells**3
    stokes = 6 * np.pi * fluid["kinematic_viscosity_m2_per_s"] * point.radius
    now, before = (force / (stokes * _limit(velocities[place:][:3])) for place in (1, 0))
    return Drag(100 * (now / DRAG[point.solid_fraction] - 1), 100 * abs(now / before - 1))


def _limit(values: Sequence[float]) -> float:
    """Limit of three equidistant values that approach it exponentially [Aitken 1926]; the last if they do not."""
    first, second, third = values
    if not 0 < (third - second) * (second - first) < (second - first) ** 2:
        return third
    return third - (third - second) ** 2 / (third - 2 * second + first)


def section(results: Sequence[tuple[Experiment, Drag]]) -> Section:
    """A row per scheme and point: mean over the centres, largest deviation from it."""
    groups: Groups = {}
    for experiment, drag in results:
        point = experiment.point
        group = groups.setdefault((point.solid_fraction, point.cells, point.tau), {})
        group.setdefault(experiment.scheme, []).append(drag.error)
    schemes = list(dict.fromkeys(experiment.scheme for experiment, _ in results))
    rows = []
    for (fraction, cells, tau), group in sorted(groups.items()):
        diameter = 2 * Point(fraction, cells, tau, 0).radius
        found = [_cell(group[scheme]) if scheme in group else "–" for scheme in schemes]
        rows.append([f"{fraction:g}", f"{diameter:.1f}", f"{tau:g}", *found])
    worst = max(drag.change for _, drag in results)
    markdown = table(["φ", "D [cells]", "τ", *schemes], rows)
    markdown += (
        "\n\nError of K [%]: mean ± largest deviation of a centre. The last fifth of the runs changed K by at most "
        f"{worst:.1g} %.\n\n![Error of the drag against cells per diameter](accuracy_array.png)"
    )
    overview = {}
    for scheme in schemes:
        dilute = [group[scheme] for (fraction, _, _), group in groups.items() if fraction <= 0.125 and scheme in group]
        means = [float(np.mean(errors)) for errors in dilute]
        overview[scheme] = {
            "array drag, φ ≤ 0.125 [%]": f"{min(means):+.2f} … {max(means):+.2f}",
            "spread [%]": f"{max(map(_spread, dilute)):.2f}",
        }
    return Section(markdown, {"accuracy_array.png": _figure(groups, schemes)}, overview)


def _cell(errors: Sequence[float]) -> str:
    return f"{np.mean(errors):+.2f} ± {_spread(errors):.2f}"


def _spread(errors: Sequence[float]) -> float:
    return float(np.abs(np.array(errors) - np.mean(errors)).max())


def _figure(groups: Groups, schemes: Sequence[str]) -> bytes:
    """Error against cells per diameter at φ = 0.125, a panel per relaxation time."""
    taus = sorted({tau for fraction, _, tau in groups if fraction == 0.125})
    figure, panels = new_figure(LIGHT, 3.2, ncols=len(taus), sharey=True, squeeze=False)
    for panel, tau in zip(panels.flat, taus):
        chosen = sorted(
            (cells, group) for (fraction, cells, t), group in groups.items() if (fraction, t) == (0.125, tau)
        )
        for number, scheme in enumerate(schemes):
            shift = 1 + 0.02 * (number - 1.5)
            found = [(cells, group[scheme]) for cells, group in chosen if scheme in group]
            errors = [values for _, values in found]
            panel.errorbar(
                [shift * 2 * Point(0.125, cells, tau, 0).radius for cells, _ in found],
                [np.mean(values) for values in errors],
                [_spread(values) for values in errors],
                fmt="o-",
                markersize=4,
                linewidth=1,
                capsize=2,
                color=COLOURS[scheme],
                label=scheme,
            )
        panel.axhline(0, color=LIGHT.ink, linewidth=0.8)
        panel.set_xlim(6, 22)
        panel.set_yscale("symlog", linthresh=5, linscale=2)
        panel.set_yticks(_TICKS, [f"{tick:+d}" for tick in _TICKS], minor=False)
        panel.set_title(f"τ = {tau:g}", fontsize=10)
        panel.set_xlabel("cells per diameter")
    panels.flat[0].set_ylabel("error of the drag [%]")
    panels.flat[0].legend(fontsize=8, frameon=False)
    return png_of(figure)
