"""Radii of beads as the fluid feels them, measured by drag runs, and the theory's speed with them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np

from copepod_report.page import table
from copepod_report.run_record import RunRecord, z_axis
from copepod_run.figures import at, number_text
from copepod_swimmers.theory import geometrical_factor

Kind = tuple[float, float, str]  # radius [m], distance of its centres [m], orientation


@dataclass(frozen=True)
class Radii:
    """Hydrodynamic radius of each kind of capsule [m]."""

    by_kind: dict[Kind, float]

    def of(self, bead: Mapping[str, Any]) -> float | None:
        """Of a bead of a swimmer, or None if its kind was not measured. A sphere's is its own."""
        if bead["shape"] == "sphere":
            return bead["radius_m"]
        return self.by_kind.get((bead["radius_m"], bead["length_m"], bead["orientation"]))


@dataclass(frozen=True)
class Prediction:
    """Speeds and errors of one swimmer: with the paper's sphere for every capsule, and with measured radii."""

    name: str
    u_swim: float
    radii_cells: tuple[float, ...]
    u_GA_paper: float
    u_GA_measured: float

    @property
    def error_paper_percent(self) -> float:
        return 100 * abs(self.u_GA_paper - self.u_swim) / abs(self.u_GA_paper)

    @property
    def error_measured_percent(self) -> float:
        return 100 * abs(self.u_GA_measured - self.u_swim) / abs(self.u_GA_measured)


def is_drag_run(run: RunRecord) -> bool:
    """Whether a run holds one fixed body and no swimmer."""
    bodies = run.case.get("bodies") or []
    return not run.case.get("swimmers") and len(bodies) == 1 and bodies[0]["motion"] == "fixed"


def measure(runs: Sequence[RunRecord]) -> Radii | None:
    """Radii from drag runs of spheres and capsules in one and the same channel, or None without enough of them.

    A capsule's radius is that of the sphere with the same drag there, interpolated between the spheres: what the
    channel adds to the drag is the same for both, to first order in radius over width.
    """
    spheres: list[tuple[Mapping[str, Any], float]] = []
    capsules: list[tuple[Mapping[str, Any], float]] = []
    for run in runs:
        body = run.case["bodies"][0]
        drag_N = abs(run.trajectory.of(body["name"])["force_N"][-1, 2])
        (spheres if body["shape"] == "sphere" else capsules).append((body, drag_N))
    if len(spheres) < 2 or not capsules:
        return None
    spheres.sort(key=lambda pair: pair[1])
    drags = [drag for _, drag in spheres]
    radii = [body["radius_m"] for body, _ in spheres]
    # Drag over radius varies slowly with the radius, so that interpolating it loses no accuracy.
    coefficients = np.polyfit(drags, np.array(radii) / drags, min(2, len(spheres) - 1))
    return Radii(
        {
            (body["radius_m"], body["length_m"], _orientation(body)): float(drag * np.polyval(coefficients, drag))
            for body, drag in capsules
        }
    )


def _orientation(body: Mapping[str, Any]) -> str:
    """Of a capsule to the flow along z, as a swimmer's bead would call it."""
    return "parallel" if abs(z_axis(body["orientation_wxyz"])[2]) > 0.5 else "perpendicular"


def predict(run: RunRecord, radii: Radii) -> list[Prediction]:
    """Prediction of every analysed swimmer in a fluid whose beads are all known; the right ω throughout."""
    if run.case["fluid"]["solver"] == "vacuum":
        return []
    predictions = []
    for swimmer in run.swimmers:
        found = [radii.of(bead) for bead in swimmer.beads]
        if at(swimmer.figures, "u_GA_lattice") is None or None in found:
            continue
        cells = tuple(radius / run.cell_size_m for radius in found)
        scale = geometrical_factor(cells, swimmer.figures["mean_arm_cells"]) / swimmer.figures["K"]
        u_GA = swimmer.figures["u_GA_lattice"]
        predictions.append(Prediction(run.name, swimmer.figures["u_swim_lattice"], cells, u_GA, u_GA * scale))
    return predictions


def section(radii: Radii, predictions: Sequence[Prediction]) -> str:
    """HTML: measured radii, and how far the theory is off with them and with the paper's sphere for every capsule."""
    kinds = "".join(
        f"<dt>{escape(orientation)} capsule, radius {1e6 * radius:g} µm, {1e6 * length:g} µm between its centres</dt>"
        f"<dd>as a sphere of radius {1e6 * value:.2f} µm</dd>"
        for (radius, length, orientation), value in radii.by_kind.items()
    )
    heads = ("run", "radii [cells]", "u_swim", "u_GA, paper's radii", "off", "u_GA, measured radii", "off")
    rows = [
        (
            row.name,
            " ".join(f"{radius:.2f}" for radius in row.radii_cells),
            number_text(row.u_swim),
            number_text(row.u_GA_paper),
            f"{row.error_paper_percent:.1f} %",
            number_text(row.u_GA_measured),
            f"{row.error_measured_percent:.1f} %",
        )
        for row in predictions
    ]
    shown = table(heads, rows) if rows else ""
    return f"<section><h2>Hydrodynamic radii, and the theory with them</h2><dl>{kinds}</dl>{shown}</section>"
