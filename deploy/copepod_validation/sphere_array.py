"""Drag of a simple cubic array of spheres and of a square one of cylinders: one of them in a periodic cell of edge L,
driven by a body force f; U is the superficial velocity.

    K(φ) = f L³/(6π μ R U)                                                       [Zick & Homsy 1982, table 2]
    F(φ) = f L²/(μ U)                                                            [Sangani & Acrivos 1982, table 1]
"""

from collections.abc import Sequence
from typing import NamedTuple

import h5py
import numpy as np

from copepod_report.style import LIGHT, describe, new_figure, picture_of
from copepod_report.trajectory import Trajectory
from copepod_validation.experiment import COLOURS, CaseDict, Results, Section, by_scheme, lattice_case, sphere
from copepod_validation.experiment import grouped, table_by_point, uniform_flow, viscosity

DRAG = {
    "sphere": {0.027: 2.008, 0.125: 4.292, 0.343: 15.4, 0.45: 28.1},  # K
    "cylinder": {0.1: 24.83, 0.3: 102.9, 0.5: 532.6},  # F
}

_CENTRES = np.random.default_rng(1).random((5, 3))
_OUTPUTS = 5
_TICKS = (-30, -10, -5, -2, 0, 2, 5, 10, 20)  # of the figure [%]
_RELAXATIONS = 5
_DEPTH = 4  # of the cell, along a cylinder [cells]


class Point(NamedTuple):
    solid_fraction: float
    cells: int  # along an edge of the cube
    tau: float
    centre: int = 0
    shape: str = "sphere"

    @property
    def radius(self) -> float:
        if self.shape == "cylinder":
            return float(self.cells * np.sqrt(self.solid_fraction / np.pi))
        return float(self.cells * np.cbrt(0.75 * self.solid_fraction / np.pi))

    @property
    def domain(self) -> list[int]:
        return [_DEPTH if self.shape == "cylinder" else self.cells, self.cells, self.cells]

    @property
    def volume(self) -> int:
        return int(np.prod(self.domain))

    @property
    def resistance(self) -> float:
        """Force over the velocity, by theory."""
        drag = DRAG[self.shape][self.solid_fraction]
        return viscosity(self.tau) * drag * (_DEPTH if self.shape == "cylinder" else 6 * np.pi * self.radius)

    @property
    def velocity(self) -> float:
        """The expected mean."""
        return 0.01 * viscosity(self.tau) / (2 * self.radius)

    @property
    def body_force(self) -> float:
        return self.resistance * self.velocity / self.volume


def _with_all_centres(*grid: tuple[float, int, float], shape: str = "sphere") -> list[Point]:
    return [Point(*values, centre, shape) for values in grid for centre in range(len(_CENTRES))]


LABEL = "{0.shape}_phi{0.solid_fraction:g}_L{0.cells}_tau{0.tau:g}_centre{0.centre}"
FAST = _with_all_centres((0.125, 13, 0.6), (0.125, 13, 2.0))
POINTS = FAST + _with_all_centres(  # low relaxation times and dense arrays at fine resolution take hours
    *((0.125, 13, 0.51), (0.125, 20, 0.6), (0.125, 20, 2.0), (0.125, 32, 0.6), (0.125, 32, 2.0)),
    *((0.027, 22, 0.6), (0.027, 22, 2.0), (0.343, 32, 0.6), (0.45, 32, 0.6)),
)
POINTS += _with_all_centres((0.1, 24, 0.6), (0.1, 24, 2.0), (0.3, 32, 0.6), (0.5, 48, 0.6), shape="cylinder")


def case_of(point: Point) -> CaseDict:
    """Starts with the expected mean velocity; what is left of the start decays with V/(6π ν R K) at the slowest."""
    edge = point.cells
    slowest = max(point.volume / point.resistance, edge**2 / (4 * np.pi**2 * viscosity(point.tau)))
    between = max(8, int(np.ceil(_RELAXATIONS * slowest / _OUTPUTS)))
    place = (0.5 * edge + _CENTRES[point.centre]).tolist()
    flow: CaseDict = {"body_force_N_per_m3": [0, 0, point.body_force], "initial_flow": uniform_flow(point.velocity)}
    bodies, obstacles = [], []
    if point.shape == "cylinder":
        quarter = [np.sqrt(0.5), 0, np.sqrt(0.5), 0]
        keys = {"radius_m": point.radius, "length_m": 2 * _DEPTH, "position_m": place, "orientation_wxyz": quarter}
        obstacles = [{"name": "cylinder", "shape": "cylinder", **keys}]
    else:
        bodies = [sphere(point.radius, place, "fixed")]
    case = lattice_case(point.domain, point.tau, "periodic", bodies, _OUTPUTS * between, **flow)
    return case | {"obstacles": obstacles, "output": {"fields": {"every_steps": between}}}


def evaluate(run: Trajectory, point: Point) -> tuple[float, float]:
    """Error of K or F, and what the last fifth of the run changed in it [%]."""
    velocities = []
    with h5py.File(run.directory / "fields.h5", "r") as file:
        for name in sorted(name for name in file if name.startswith("step_"))[-4:]:
            is_fluid = file[name]["body"][:] == 0
            momentum = file[name]["density_kg_per_m3"][:] * file[name]["velocity_m_per_s"][..., 2]
            velocities.append(momentum[is_fluid].sum() / point.volume)
    now, before = (point.velocity / _limit(velocities[place:][:3]) for place in (1, 0))
    return 100 * (now - 1), 100 * abs(now / before - 1)


def _limit(values: Sequence[float]) -> float:
    """Limit of three equidistant values that approach it exponentially [Aitken 1926]; the last if they do not."""
    first, second, third = values
    if not 0 < (third - second) * (second - first) < (second - first) ** 2:
        return third
    return third - (third - second) ** 2 / (third - 2 * second + first)


def section(results: Results[tuple[float, float]]) -> Section:
    """A row per point: mean over the centres, largest deviation from it."""
    errors = [(scheme, point, error) for scheme, point, (error, _) in sorted(results, key=lambda result: result[1])]
    arrays = grouped(errors, lambda point: point._replace(centre=0))

    def row(point: Point) -> str:
        return f"{point.shape} | {point.solid_fraction:g} | {2 * point.radius:.1f} | {point.tau:g}"

    def cell(found: list[float]) -> str:
        return f"{np.mean(found):+.2f} ± {_spread(found):.2f}"

    changes = [change for _, _, (_, change) in results]
    values = {"table": table_by_point(arrays, "array | φ | D [cells] | τ", row, cell), "change": f"{max(changes):.1g}"}
    overview = {}
    for scheme, dilute in by_scheme([array for array in arrays if array[1].solid_fraction <= 0.125]).items():
        means = np.mean(dilute, axis=1)
        overview[scheme, "array drag, φ ≤ 0.125 [%]"] = f"{min(means):+.2f} … {max(means):+.2f}"
        overview[scheme, "spread [%]"] = f"{max(map(_spread, dilute)):.2f}"
    return Section(values, overview, {"accuracy_array.png": _figure(arrays)})


def _spread(errors: Sequence[float]) -> float:
    return float(np.abs(np.array(errors) - np.mean(errors)).max())


def _figure(arrays: Results[list[float]]) -> bytes:
    """Error against cells per diameter at φ = 0.125, a panel per relaxation time."""
    shown = [array for array in arrays if array[1].solid_fraction == 0.125]
    taus = sorted({point.tau for _, point, _ in shown})
    figure, panels = new_figure(3.2, ncols=len(taus), sharey=True, squeeze=False)
    for panel, tau in zip(panels.flat, taus):
        for number, scheme in enumerate(by_scheme(arrays)):
            found = [(point, errors) for one, point, errors in shown if (one, point.tau) == (scheme, tau)]
            places = [(1 + 0.02 * (number - 1.5)) * 2 * point.radius for point, _ in found]
            means, spreads = zip(*((np.mean(errors), _spread(errors)) for _, errors in found)) if found else ((), ())
            look = {"markersize": 4, "linewidth": 1, "capsize": 2, "color": COLOURS[scheme], "label": scheme}
            panel.errorbar(places, means, spreads, fmt="o-", **look)
        panel.axhline(0, color=LIGHT.ink, linewidth=0.8)
        panel.set_yscale("symlog", linthresh=5, linscale=2)
        panel.set_yticks(_TICKS, [f"{tick:+d}" for tick in _TICKS], minor=False)
        describe(panel, f"τ = {tau:g}", xlim=(6, 22), xlabel="cells per diameter")
    describe(panels.flat[0], legend={}, ylabel="error of the drag [%]")
    return picture_of(figure)
