"""Radii of beads as the fluid feels them, measured by drag runs, and the theory's speed with them."""

from dataclasses import dataclass

import numpy as np

from copepod_run.figures import at


@dataclass(frozen=True)
class Radii:
    """Hydrodynamic radius of each kind of bead [m], by (shape, radius, length, orientation)."""

    by_kind: dict

    def of(self, bead):
        """Of a bead of a swimmer, or None if its kind was not measured. A sphere's is its own."""
        if bead["shape"] == "sphere":
            return bead["radius_m"]
        return self.by_kind.get((bead["radius_m"], bead["length_m"], bead["orientation"]))


@dataclass(frozen=True)
class Prediction:
    """Speeds and errors of one swimmer: with the paper's sphere for every capsule, and with measured radii."""

    name: str
    u_swim: float
    radii_cells: tuple
    u_GA_paper: float
    u_GA_measured: float

    @property
    def error_paper_percent(self):
        return 100 * abs(self.u_GA_paper - self.u_swim) / abs(self.u_GA_paper)

    @property
    def error_measured_percent(self):
        return 100 * abs(self.u_GA_measured - self.u_swim) / abs(self.u_GA_measured)


def is_drag_run(run):
    """Whether a run holds one fixed body and no swimmer."""
    bodies = run.case.get("bodies") or []
    return not run.case.get("swimmers") and len(bodies) == 1 and bodies[0]["motion"] == "fixed"


def measure(runs):
    """Radii from drag runs of spheres and capsules in one and the same channel, or None without enough of them.

    A capsule's radius is that of the sphere with the same drag there, interpolated between the spheres: what the
    channel adds to the drag is the same for both, to first order in radius over width.
    """
    spheres, capsules = [], []
    for run in runs:
        body = run.case["bodies"][0]
        drag_N = abs(run.trajectory.of(body["name"])["force_N"][-1, 2])
        (spheres if body["shape"] == "sphere" else capsules).append((body, drag_N))
    if len(spheres) < 2 or not capsules:
        return None
    spheres.sort(key=lambda pair: pair[1])
    drags = [drag for _, drag in spheres]
    radii = [body["radius_m"] for body, _ in spheres]
    # Drag over radius varies slowly with the radius: interpolating it loses nothing that the runs know.
    coefficients = np.polyfit(drags, np.array(radii) / drags, min(2, len(spheres) - 1))
    return Radii(
        {
            (body["radius_m"], body["length_m"], _orientation(body)): drag * np.polyval(coefficients, drag)
            for body, drag in capsules
        }
    )


def _orientation(body):
    """Of a capsule to the flow along z, as a swimmer's bead would call it."""
    w, x, y, z = body["orientation_wxyz"]
    along = w * w - x * x - y * y + z * z
    return "parallel" if abs(along) > 0.5 else "perpendicular"


def geometrical_factor(radii, mean_arms):
    """K = 3 r₁r₂r₃ / (2 (r₁+r₂+r₃)²) · [1/l̄₁² + 1/l̄₂² − 1/(l̄₁+l̄₂)²]   [paper, eq. (29)]; any one unit of length."""
    first, second = mean_arms
    brackets = 1 / first**2 + 1 / second**2 - 1 / (first + second) ** 2
    return 3 * np.prod(radii) / (2 * np.sum(radii) ** 2) * brackets


def predict(run, radii):
    """Prediction of every analysed swimmer in a fluid whose beads are all known; the right ω throughout."""
    if run.case["fluid"]["solver"] == "vacuum":
        return []
    predictions = []
    for swimmer in run.swimmers():
        found = [radii.of(bead) for bead in swimmer.beads]
        if at(swimmer.figures, "u_GA_lattice") is None or None in found:
            continue
        cells = tuple(radius / run.cell_size_m for radius in found)
        scale = geometrical_factor(cells, swimmer.figures["mean_arm_cells"]) / swimmer.figures["K"]
        u_GA = swimmer.figures["u_GA_lattice"]
        predictions.append(Prediction(run.name, swimmer.figures["u_swim_lattice"], cells, u_GA, u_GA * scale))
    return predictions
