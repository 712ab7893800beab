"""Drag of a sphere at rest in a flow with inertia, Reynolds numbers of 20 to 100."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from copepod_report.trajectory import Trajectory
from copepod_validation.experiment import Experiment, Section, by_point, lattice_case, sphere, table

REFERENCE = (
    "Standard drag of a sphere, 24/Re (1 + 0.1935 Re^0.6305) for Re of 20 to 260 [Clift, Grace, Weber, Bubbles, Drops "
    "and Particles, 1978, table 5.2], uncertain by some 3 %. Fluid that moves uniformly at 0.05 cells per step at "
    "first passes a sphere at rest, 8 cells in diameter, in a box of 14 × 14 × 24 diameters with walls without "
    "friction; mean drag from 12 to 16 diameters of travel, before the wake meets the sphere again. The box raises "
    "it: at Re = 100, one that is 10 diameters wide gives 1 % more. bgk is unstable at Re = 100."
)
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


def experiments(scheme: str, keys: Mapping[str, str], fast: bool) -> list[Experiment]:
    found = []
    for point in [] if fast else [Point(reynolds) for reynolds in (20, 50, 100)]:  # these take a quarter of a minute
        if keys["collision"] == "bgk" and point.tau < 0.52:
            continue  # unstable
        width, length = _WIDTH * DIAMETER, _LENGTH * DIAMETER
        body = sphere(0.5 * DIAMETER, (0.5 * width, 0.5 * width, length / 3 + 0.3), "fixed")
        case = lattice_case(
            (width, width, length),
            point.tau,
            "periodic",
            [body],
            round(_TRAVEL * DIAMETER / _SPEED),
            boundaries={"x": "free_slip", "y": "free_slip", "z": "periodic"},
            symmetry_planes=["x", "y"],
            initial_flow={"kind": "uniform", "velocity_m_per_s": [0, 0, _SPEED]},
            **keys,
        )
        case["output"] = {"trajectory": {"every_steps": 1, "from_step": case["run"]["steps"] * 3 // 4}}
        found.append(Experiment(f"inertial_drag-{scheme}-Re{point.reynolds:g}", scheme, point, case))
    return found


def evaluate(folder: Path, experiment: Experiment) -> float:
    """Error of the drag coefficient [%]."""
    force = float(np.mean(Trajectory(folder / "trajectory.csv").of("sphere")["force_N"][1:, 2]))
    found = force / (0.5 * _SPEED**2 * np.pi * DIAMETER**2 / 4)
    return 100 * (found / experiment.point.coefficient - 1)


def section(results: Sequence[tuple[Experiment, float]]) -> Section:
    schemes, values = by_point(results)
    rows = [
        [f"{point.reynolds:g}", f"{point.tau:.3f}", f"{point.coefficient:.3f}"]
        + [f"{errors[scheme]:+.1f}" if scheme in errors else "–" for scheme in schemes]
        for point, errors in values.items()
    ]
    markdown = table(["Re", "τ", "drag coefficient", *schemes], rows) + "\n\nError of the mean drag [%]."
    worst: dict[str, float] = {}
    for experiment, error in results:
        worst[experiment.scheme] = max(worst.get(experiment.scheme, 0.0), error, key=abs)
    return Section(
        markdown, {}, {scheme: {"drag at Re 20 … 100 [%]": f"{error:+.1f}"} for scheme, error in worst.items()}
    )
