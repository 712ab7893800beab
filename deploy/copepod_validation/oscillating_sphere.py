"""Force on a sphere that oscillates in a periodic cube: Stokes drag, added mass and Basset's history force."""

from typing import NamedTuple

import numpy as np

from copepod_report.trajectory import Trajectory
from copepod_validation.experiment import CaseDict, Results, Section, lattice_case, sphere
from copepod_validation.experiment import table_by_point, viscosity, worst

RADIUS, CELLS = 4.0, 32
_SPEED, _PERIOD, _PERIODS = 2e-3, 400, 3


def resistance(s: complex, radius: float, edge: float, viscosity: float, density: float = 1.0) -> complex:
    """−F/U of a sphere of a simple cubic array, whose velocity is U e^{st} in a fluid at rest at first, kinematic
    viscosity ν; unsteady_sphere_test.cpp derives it. Neglected: terms of the order of (radius/edge)⁵."""
    alpha = np.sqrt(s / viscosity + 0j)
    x = np.arange(-3, 4)
    distance = edge * np.sqrt(sum(np.square(axis) for axis in np.meshgrid(x, x, x))).ravel()
    distance = distance[distance > 0]
    others = np.sum(np.exp(-alpha * distance) / (4 * np.pi * distance))
    carried = (1 + 2 * alpha**2 * edge**3 * others) / (3 * s * density * edge**3)
    free = 6 * np.pi * density * viscosity * radius * (1 + alpha * radius + (alpha * radius) ** 2 / 9)
    inertia = 4 / 3 * np.pi * density * radius**3 * s
    return complex((free - (free + inertia) * carried * inertia) / (1 + (free + inertia) * carried))


class Point(NamedTuple):
    depths: float  # radius over δ

    @property
    def tau(self) -> float:
        return 0.5 + 3 * np.pi * RADIUS**2 / (_PERIOD * self.depths**2)

    @property
    def resistance(self) -> complex:
        return resistance(2j * np.pi / _PERIOD, RADIUS, CELLS, viscosity(self.tau))


POINTS = [Point(0.75), Point(1.5), Point(3.0)]
LABEL = "{0.depths:g}"
FAST = POINTS[1:2]


def case_of(point: Point) -> CaseDict:
    signal = {"kind": "sinusoid", "period_steps": _PERIOD}
    motion = {"prescribed": {"velocity_m_per_s": [0, 0, _SPEED], "signal": signal}}
    body = sphere(RADIUS, 3 * [0.5 * CELLS + 0.3], motion)
    return lattice_case([CELLS] * 3, point.tau, "periodic", [body], _PERIODS * _PERIOD, (_PERIODS - 1) * _PERIOD)


def evaluate(run: Trajectory, point: Point) -> complex:
    """Phasor of the force, over that of theory."""
    waves = np.exp(-2j * np.pi / _PERIOD * run.steps)
    phasor = 2 * np.mean((run.of("sphere")["force_N"][:, 2] * waves)[:-1])  # the last sample begins a period
    velocity = -1j * _SPEED  # of a sine
    return complex(phasor / (-point.resistance * velocity))


def section(results: Results[complex]) -> Section:
    def row(point: Point) -> str:
        drag, stokes = point.resistance, 6 * np.pi * viscosity(point.tau) * RADIUS
        return f"{point.depths:g} | {point.tau:.3f} | {abs(drag) / stokes:.2f} | {np.degrees(np.angle(drag)):.0f}°"

    def cell(ratio: complex) -> str:
        return f"{100 * (abs(ratio) - 1):+.1f}, {np.degrees(np.angle(ratio)):+.1f}°"

    heads = "R/δ | τ | force over Stokes' | ahead of the velocity by"
    overview = worst(results, "oscillation [%]", lambda ratio: 100 * abs(ratio - 1), ".1f")
    return Section({"table": table_by_point(results, heads, row, cell)}, overview)
