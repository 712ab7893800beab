"""A free sphere and a free capsule between two walls that move in opposite directions."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from copepod_report.trajectory import Trajectory
from copepod_validation.experiment import Experiment, Section, by_point, lattice_case, sphere, table

REFERENCE = (
    "Jeffery's orbit [Proc. R. Soc. A 102, 1922]: in shear at the rate γ a body of revolution, whose axis has turned "
    "by θ from the flow, rotates at γ/2 (1 − (r² − 1)/(r² + 1) cos 2θ), a sphere at γ/2. Every such body has an "
    "aspect ratio r [Bretherton, J. Fluid Mech. 14, 1962]; that of a capsule is measured, and the test is that the "
    "rotation has this form with the mean γ/2. Radius 4, capsule of length 16, in a cube of 64 cells between walls; "
    "half the length squared times γ/ν is 0.04 and 0.13."
)
RADIUS, LENGTH = 4.0, 8.0  # of both; of the capsule's cylinder
_CELLS = 64


@dataclass(frozen=True)
class Point:
    shape: str
    tau: float
    rate: float
    steps: int


SPHERE = Point("sphere", 1.0, 4e-4, 1500)
CAPSULE = Point("capsule", 2.0, 1e-3, 9000)  # over half an orbit


def experiments(scheme: str, keys: Mapping[str, str], fast: bool) -> list[Experiment]:
    found = []
    for point in (SPHERE,) if fast else (SPHERE, CAPSULE):
        body = sphere(RADIUS, 3 * [0.5 * _CELLS], "free")
        if point.shape == "capsule":
            body.update(shape="capsule", length_m=LENGTH, mass_kg=body["mass_kg"] + np.pi * RADIUS**2 * LENGTH)
        walls = {
            face: {"velocity_m_per_s": [0, 0, sign * point.rate * _CELLS / 2]}
            for face, sign in (("low", -1), ("high", 1))
        }
        boundaries = {"x": walls, "y": "free_slip", "z": "periodic"}  # y is a plane of symmetry
        case = lattice_case(
            [_CELLS] * 3,
            point.tau,
            "periodic",
            [body],
            point.steps,
            boundaries=boundaries,
            symmetry_planes=["y"],
            initial_flow={"kind": "shear"},
            **keys,
        )
        del case["coupling"]  # as bodies move by default
        case["output"] = {"trajectory": {"every_steps": 1}}
        found.append(Experiment(f"shear-{scheme}-{point.shape}", scheme, point, case))
    return found


@dataclass(frozen=True)
class Rotation:
    """Error of the mean rate, largest deviation from the form, both over γ/2 [%]; aspect ratio r."""

    error: float
    deviation: float
    aspect: float


def evaluate(folder: Path, experiment: Experiment) -> Rotation:
    """Without the first third of the run, in which the rotation begins."""
    rate = -Trajectory(folder / "trajectory.csv").of("sphere")["angular_velocity_rad_per_s"][:, 1]
    angle, start = np.cumsum(rate), len(rate) // 3
    found = rate[start:] / (0.5 * experiment.point.rate)
    form = np.ones((len(found), 1))
    if experiment.point.shape == "capsule":
        form = np.column_stack([form, -np.cos(2 * angle[start:])])
    parts = np.linalg.lstsq(form, found, rcond=None)[0]
    mean, part = (*parts, 0.0)[:2]
    deviation = np.abs(found - form @ parts).max()
    return Rotation(100 * (mean - 1), 100 * deviation, float(np.sqrt((mean + part) / (mean - part))))


def section(results: Sequence[tuple[Experiment, Rotation]]) -> Section:
    schemes, values = by_point(results)
    rows = []
    for point, found in values.items():
        cells = [found[scheme] for scheme in schemes]
        texts = [f"{one.error:+.2f} ± {one.deviation:.1f}" for one in cells]
        if point.shape == "capsule":
            texts = [f"{text} (r = {one.aspect:.2f})" for text, one in zip(texts, cells)]
        rows.append([point.shape, f"{point.tau:g}", *texts])
    markdown = table(["body", "τ", *schemes], rows)
    markdown += "\n\nError of the mean rate ± largest deviation from the form [% of γ/2]."
    worst = {scheme: max((found[scheme].error for found in values.values()), key=abs) for scheme in schemes}
    return Section(markdown, {}, {scheme: {"shear [%]": f"{error:+.1f}"} for scheme, error in worst.items()})
