"""Impulse on a sphere that starts suddenly in a periodic cube: Stokes drag, added mass and Basset's history force."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from copepod_report.trajectory import Trajectory
from copepod_validation.experiment import CaseDict, Results, Section, lattice_case, sphere
from copepod_validation.experiment import table_by_point, viscosity, worst
from copepod_validation.oscillating_sphere import CELLS, RADIUS, resistance

REFERENCE = (
    "Impulse by the theory of the case before, every 50 steps from step 200 to 1000 [inverse Laplace transform: Abate "
    "& Valkó, Int. J. Numer. Meth. Eng. 60, 2004]. Radius 4, cube of 32 cells, 0.002 cells per step. «Alternating»: "
    "half the difference of the forces of successive steps after 300 steps, relative to their mean; the mean of two "
    "steps, which bodies receive by default, has none."
)
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


@dataclass(frozen=True)
class Point:
    tau: float


POINTS = [Point(0.55), Point(0.7), Point(1.0)]
LABEL = "tau{0.tau:g}"
FAST = POINTS[:1]


def case_of(point: Point) -> CaseDict:
    body = sphere(RADIUS, 3 * [0.5 * CELLS + 0.3], "prescribed", velocity_m_per_s=[0, 0, _SPEED])
    return lattice_case([CELLS] * 3, point.tau, "periodic", [body], _STEPS)


@dataclass(frozen=True)
class Start:
    """Largest error of the impulse, and how far the force alternates between steps [%]."""

    error: float
    alternating: float


def evaluate(folder: Path, point: Point) -> Start:
    force = Trajectory(folder).of("sphere")["force_N"][:, 2]
    nu, impulse = viscosity(point.tau), np.cumsum(force)
    errors = []
    for step in range(200, _STEPS, 50):
        theory = -_SPEED * inverse_laplace(lambda s: resistance(s, RADIUS, CELLS, nu) / s**2, step + 1)
        errors.append(100 * float(impulse[step] / theory - 1))
    later = force[_ALTERNATING]
    alternating = abs(np.mean(later * (-1) ** np.arange(len(later))) / np.mean(later))
    return Start(max(errors, key=abs), 100 * float(alternating))


def section(results: Results[Start]) -> Section:
    cell = "{0.error:+.2f} ({0.alternating:.2g})".format
    markdown = table_by_point(results, "τ", "{0.tau:g}".format, cell)
    markdown += "\n\nLargest error of the impulse [%]; in brackets alternating part [%]."
    return Section(markdown, worst(results, "sudden start [%]", lambda start: start.error))
