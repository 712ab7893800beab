"""Impulse on a sphere that starts suddenly in a periodic cube: Stokes drag, added mass and Basset's history force."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from copepod_report.trajectory import Trajectory
from copepod_validation.experiment import CaseDict, Results, Section, lattice_case, sphere
from copepod_validation.experiment import table_by_point, viscosity, worst
from copepod_validation.oscillating_sphere import CELLS, RADIUS, resistance

_SPEED, _STEPS, _ALTERNATING = 2e-3, 1000, slice(300, 400)


def inverse_laplace(transform: Callable[[complex], complex], time: float, points: int = 24) -> float:
    """Talbot's contour with the points of Abate and Valkó (2004)."""
    r = 2 * points / (5 * time)
    total = 0.5 * np.real(transform(r) * np.exp(r * time))
    for angle in np.arange(1, points) * np.pi / points:
        cotangent = 1 / np.tan(angle)
        s = r * angle * (cotangent + 1j)
        total += np.real(np.exp(time * s) * transform(s) * (1 + 1j * (angle + (angle * cotangent - 1) * cotangent)))
    return float(total * r / points)


class Point(NamedTuple):
    tau: float


POINTS = [Point(0.55), Point(0.7), Point(1.0)]
LABEL = "tau{0.tau:g}"
FAST = POINTS[:1]


def case_of(point: Point) -> CaseDict:
    body = sphere(RADIUS, 3 * [0.5 * CELLS + 0.3], "prescribed", velocity_m_per_s=[0, 0, _SPEED])
    return lattice_case([CELLS] * 3, point.tau, "periodic", [body], _STEPS)


def evaluate(run: Trajectory, point: Point) -> tuple[float, float]:
    """Largest error of the impulse, and how far the force alternates between steps [%]."""
    force = run.of("sphere")["force_N"][:, 2]
    nu, impulse = viscosity(point.tau), np.cumsum(force)
    steps = range(200, _STEPS, 50)
    of_theory = [inverse_laplace(lambda s: resistance(s, RADIUS, CELLS, nu) / s**2, step + 1) for step in steps]
    errors = impulse[steps] / (-_SPEED * np.array(of_theory)) - 1
    later = force[_ALTERNATING]
    alternating = abs(np.mean(later * (-1) ** np.arange(len(later))) / np.mean(later))
    return 100 * float(max(errors, key=abs)), 100 * float(alternating)


def section(results: Results[tuple[float, float]]) -> Section:
    table = table_by_point(results, "τ", "{0.tau:g}".format, "{0[0]:+.2f} ({0[1]:.2g})".format)
    return Section({"table": table}, worst(results, "sudden start [%]", lambda start: start[0]))
