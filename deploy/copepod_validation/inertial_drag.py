"""Drag of a sphere at rest in a flow with inertia, Reynolds numbers of 20 to 100."""

from dataclasses import dataclass

import numpy as np

from copepod_report.trajectory import Trajectory
from copepod_validation.experiment import CaseDict, Results, Section, lattice_case, sphere
from copepod_validation.experiment import table_by_point, uniform_flow, worst

DIAMETER = 8
_SPEED, _WIDTH, _LENGTH, _TRAVEL = 0.05, 14, 24, 16  # lengths in diameters


@dataclass(frozen=True)
class Point:
    reynolds: float

    @property
    def tau(self) -> float:
        return 0.5 + 3 * _SPEED * DIAMETER / self.reynolds

    @property
    def coefficient(self) -> float:
        return 24 / self.reynolds * (1 + 0.1935 * self.reynolds**0.6305)


POINTS = [Point(20), Point(50), Point(100)]
LABEL = "Re{0.reynolds:g}"
FAST: list[Point] = []  # each takes a quarter of a minute


def case_of(point: Point) -> CaseDict:
    width, length, steps = _WIDTH * DIAMETER, _LENGTH * DIAMETER, round(_TRAVEL * DIAMETER / _SPEED)
    body = sphere(0.5 * DIAMETER, (0.5 * width, 0.5 * width, length / 3 + 0.3), "fixed")
    walls = {"x": "free_slip", "y": "free_slip", "z": "periodic"}
    flow = {"symmetry_planes": ["x", "y"], "initial_flow": uniform_flow(_SPEED)}
    return lattice_case((width, width, length), point.tau, walls, [body], steps, steps * 3 // 4, **flow)


def evaluate(run: Trajectory, point: Point) -> float:
    """Error of the drag coefficient [%]."""
    force = float(np.mean(run.of("sphere")["force_N"][1:, 2]))
    found = force / (0.5 * _SPEED**2 * np.pi * DIAMETER**2 / 4)
    return 100 * (found / point.coefficient - 1)


def section(results: Results[float]) -> Section:
    row = "{0.reynolds:g} | {0.tau:.3f} | {0.coefficient:.3f}".format
    markdown = table_by_point(results, "Re | τ | drag coefficient", row, "{:+.1f}".format)
    markdown += "\n\nError of the mean drag [%]."
    return Section(markdown, worst(results, "drag at Re 20 … 100 [%]", float))
