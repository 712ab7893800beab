"""Three spheres in a row: speed over phase lag and over amplitude, beside the theory of Golestanian and Ajdari."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from copepod import Run
from copepod_report.style import LIGHT, describe, new_figure
from copepod_run.figures import markdown_table
from copepod_swimmers.runs import last_cycle, period_s, radii_m
from copepod_swimmers.theory import Stroke, any_stroke_velocity, small_stroke_velocity

LABELS = ("leading order", "any stroke", "Rotne-Prager")  # of theory: small strokes and spheres, small spheres, neither
ROW = ((0, 1), (1, 2))  # its arms


def speed_of(run: Run) -> dict[str, float]:
    """What was varied, the measured speed and arms, and by LABELS what theory makes of the arms, in cells and steps; of
    a run whose trajectory holds the last cycle in equal steps."""
    swimmer, stroke = run.summary["swimmers"][0], run.case["swimmers.0.stroke"]
    start, stop = swimmer["window_steps"]
    beads, radii = last_cycle(run, swimmer["name"]) / 1e-6, radii_m(run) / 1e-6
    arms = np.linalg.norm(np.diff(beads, axis=0), axis=2)
    moved = Stroke(beads[:, 0], radii, ROW, arms).motion()
    axis = (beads[2, 0] - beads[0, 0]) / np.linalg.norm(beads[2, 0] - beads[0, 0])
    d1, d2 = swimmer["d1_cells"], swimmer["d2_cells"]
    theory = (
        small_stroke_velocity(radii, arms, stop - start),
        any_stroke_velocity(radii, arms, stop - start),
        float((moved[1] - moved[0]).mean(axis=0) @ axis / (stop - start)),
    )
    return {
        "force": 1e6 * stroke["amplitude_N"],
        "lag": stroke["phase_lag_steps"],
        "period": stop - start,
        "measured": swimmer["u_swim_lattice"],
        "d1": d1,
        "d2": d2,
        "stroke_squared": d1 * d2 / np.prod(arms.mean(axis=1)),
        **dict(zip(LABELS, theory)),
    }


@dataclass(frozen=True)
class Alone:
    """What a swimmer without a neighbour does in a cycle."""

    measured: float  # [m]
    theory: float  # the same from its stroke by integration [m]
    dipole_N_m: float  # mean of Σ f·x along the axis, f the forces on the fluid
    period_s: float
    length_m: float  # mean distance of the outer beads
    viscosity_Pa_s: float

    @classmethod
    def of(cls, run: Run) -> "Alone":
        """Of the swimmer called swimmer of a run whose trajectory holds the last cycle."""
        last, period, fluid = run.cycles.loc["swimmer"].iloc[-1], period_s(run, "swimmer"), run.case["fluid"]
        axis = np.array(last[["axis_x", "axis_y", "axis_z"]])
        beads, forces = last_cycle(run, "swimmer"), -last_cycle(run, "swimmer", "f{}_N")
        arms = np.linalg.norm(np.diff(beads, axis=0), axis=2)
        moved = Stroke(beads[:, 0], radii_m(run), ROW, arms).motion()
        return cls(
            last["u_along_m_per_s"] * period,
            float(np.linalg.norm((moved[1] - moved[0]).mean(axis=0))),
            float(np.mean(np.sum(((beads - beads.mean(axis=0)) @ axis) * (forces @ axis), axis=0))),
            period,
            float(np.mean((beads[2] - beads[0]) @ axis)),
            fluid["density_kg_per_m3"] * fluid["kinematic_viscosity_m2_per_s"],
        )

    def __str__(self) -> str:
        relative = self.dipole_N_m * self.period_s / (self.viscosity_Pa_s * self.measured * self.length_m**2)
        return f"p/(η u L²) = {relative:.3f}, L = {1e6 * self.length_m:.1f} cells"


def over_lag(stokes: Any, lattice: Any) -> Any:
    """Speed over the lag of the leading force: dots measured, lines theory."""
    figure, panels = new_figure(LIGHT, 3.6, ncols=2)
    for panel, speeds, title in zip(panels, (stokes, lattice), ("Stokes flow", "lattice Boltzmann")):
        lags = np.array(speeds["lag"] / speeds["period"])
        for label, style, colour in zip(LABELS, ("-", "--", ":"), LIGHT.beads):
            panel.plot(*_periodic(lags, 1e6 * speeds[label]), style, color=colour, linewidth=1.4, label=label)
        panel.plot(lags, 1e6 * speeds["measured"], "o", color=LIGHT.ink, markersize=4, label="Copepod")
        describe(panel, title, xlabel="lag of the leading force φ/T")
    describe(panels[0], legend={"loc": "lower left"}, ylabel="u [10⁻⁶ cells/step]")
    return figure


def _periodic(lags: np.ndarray, values: Any) -> tuple[np.ndarray, np.ndarray]:
    """A smooth curve through points of a periodic function: its first waves, as many as the points determine."""
    orders = np.arange(1, (len(lags) - 1) // 2 + 1)[:4]

    def waves(places: np.ndarray) -> np.ndarray:
        phases = 2 * np.pi * np.outer(places, orders)
        return np.hstack([np.ones((len(places), 1)), np.cos(phases), np.sin(phases)])

    fine = np.linspace(0, 1, 200)
    return fine, waves(fine) @ np.linalg.lstsq(waves(lags), values, rcond=None)[0]


def over_amplitude(stokes: Any, lattice: Any) -> Any:
    """Measured speed over each theory's, over the square of the stroke."""
    figure, axes = new_figure(LIGHT, 3.6)
    for speeds, marker, name in ((stokes, "o-", "Stokes"), (lattice, "s--", "lattice")):
        for label, colour in zip(LABELS, LIGHT.beads):
            look = {"color": colour, "markersize": 4, "linewidth": 1, "label": f"{name}: {label}"}
            axes.plot(speeds["stroke_squared"], speeds["measured"] / speeds[label], marker, **look)
    axes.axhline(1, color=LIGHT.ink, linewidth=0.8)
    axes.set_xlim(left=0)
    place = {"loc": "center left", "bbox_to_anchor": (1, 0.5)}
    describe(axes, legend=place, xlabel="d₁d₂/(l̄₁l̄₂)", ylabel="u / u of theory")
    return figure


def table(head: str, names: Iterable[Any], speeds: Any) -> str:
    """Markdown: a row per run, with these names."""
    per_stroke = abs(speeds[LABELS[0]] / speeds["stroke_squared"])
    ratios = 1 / speeds[list(LABELS)].where(per_stroke > 1e-2 * per_stroke.max()).div(speeds["measured"], axis=0)
    rows = [
        f"{name} | {one.d1:.3f}, {one.d2:.3f} | {one.measured:.3e} | " + " | ".join(map("{:.4f}".format, found))
        for name, one, found in zip(names, speeds.itertuples(), ratios.to_numpy())
    ]
    heads = " | ".join([head, "d₁, d₂ [cells]", "u [cells/step]", *(f"u over {label}" for label in LABELS)])
    return markdown_table(heads, rows).replace("nan", "–")


def directions(runs: dict[str, Run]) -> str:
    """Markdown: the same swimmer along several axes, in all cycles but the first; the first run is the reference."""
    rows, reference = [], None
    for name, run in runs.items():
        cycles = run.cycles.loc["swimmer"]
        scale = run.summary["step_s"] / run.summary["cell_size_m"]
        speeds = cycles["u_along_m_per_s"][1:] * scale
        reference = reference or speeds.mean()
        across = cycles["u_across_m_per_s"][1:].mean() * scale / speeds.mean()
        rows.append(
            f"[{', '.join(name)}] | {', '.join(f'{1e5 * speed:.3f}' for speed in speeds)} | {speeds.mean():.3e} | "
            f"{speeds.mean() / reference:.4f} | {across:.1e} | {cycles['tilt_rad'].iloc[-1]:.1e}"
        )
    heads = "axis | u along its axis, cycle by cycle [10⁻⁵ cells/step] | mean | over the first | across over along"
    return markdown_table(f"{heads} | tilt at the end", rows)
