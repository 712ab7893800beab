"""Drag of a sphere in a stream, Reynolds numbers of 20 to 100: between an inflow and an outflow, with free-slip sides.

The sides make the stream faster around the sphere, by the body's volume and by its wake [Pope and Harper, Low-Speed
Wind Tunnel Testing, 1966, 6.20 and 6.32], C the section of the stream, S the sphere's, V its volume:

    u/U − 1 = 0.9 V/C^(3/2) + S C_d/(4C)
"""

from typing import NamedTuple

import numpy as np

from copepod_report.trajectory import Trajectory
from copepod_validation.experiment import CaseDict, Results, Section, lattice_case, sphere
from copepod_validation.experiment import table_by_point, uniform_flow, worst

_SPEED, _WIDTH, _LENGTH, _UPSTREAM, _TRAVEL = 0.05, 12, 18, 6, 20  # lengths in diameters


class Point(NamedTuple):
    reynolds: float
    diameter: int = 8

    @property
    def tau(self) -> float:
        return 0.5 + 3 * _SPEED * self.diameter / self.reynolds

    @property
    def coefficient(self) -> float:
        """[Clift, Grace and Weber, Bubbles, Drops and Particles, 1978, table 5.2]"""
        return 24 / self.reynolds * (1 + 0.1935 * self.reynolds**0.6305)


POINTS = [Point(20), Point(50), Point(100, 12)]  # at 8 cells per diameter the last one diverges
MORE = {"parabolic": [Point(20, 16), Point(50, 16), Point(100, 16)]}
LABEL = "Re{0.reynolds:g}, D{0.diameter}"
FAST: list[Point] = []  # each takes a quarter of a minute


def case_of(point: Point) -> CaseDict:
    width, length, steps = _WIDTH * point.diameter, _LENGTH * point.diameter, round(_TRAVEL * point.diameter / _SPEED)
    body = sphere(0.5 * point.diameter, (0.5 * width, 0.5 * width, _UPSTREAM * point.diameter + 0.3), "fixed")
    stream = {"low": {"velocity_m_per_s": [0, 0, _SPEED]}, "high": "outflow"}
    faces = {"x": "free_slip", "y": "free_slip", "z": stream}
    flow = {"symmetry_planes": ["x", "y"], "initial_flow": uniform_flow(_SPEED)}
    return lattice_case((width, width, length), point.tau, faces, [body], steps, steps * 3 // 4, **flow)


def evaluate(run: Trajectory, point: Point) -> float:
    """Error of the drag coefficient [%]."""
    force = float(np.mean(run.of("sphere")["force_N"][1:, 2]))
    found = force / (0.5 * _SPEED**2 * np.pi * point.diameter**2 / 4)
    blockage = 0.9 * np.pi / 6 / _WIDTH**3 + np.pi / 16 * found / _WIDTH**2
    return 100 * (found / (1 + blockage) ** 2 / point.coefficient - 1)


def section(results: Results[float]) -> Section:
    row = "{0.reynolds:g} | {0.diameter} | {0.tau:.3f} | {0.coefficient:.3f}".format
    table = table_by_point(results, "Re | cells per diameter | τ | drag coefficient", row, "{:+.1f}".format)
    return Section({"table": table}, worst(results, "drag at Re 20 … 100 [%]", float))
