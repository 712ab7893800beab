"""Three spheres in a row: speed over phase lag and over amplitude, beside the theory of Golestanian and Ajdari."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from copepod_report.style import Theme, new_figure
from copepod_run.figures import markdown_table
from copepod_swimmers.runs import Member
from copepod_swimmers.theory import Stroke, any_stroke_velocity, small_stroke_velocity

LABELS = ("leading order", "any stroke", "Rotne-Prager")  # of theory: small strokes and spheres, small spheres, neither


@dataclass(frozen=True)
class Speed:
    """One run, in cells and steps: the measured speed and what theory makes of the measured arms."""

    value: float  # of the parameter that was varied
    period: int
    measured: float
    theory: tuple[float, float, float]  # as in LABELS
    amplitudes: tuple[float, float]
    stroke_squared: float  # d₁ d₂ / (l̄₁ l̄₂)


def speed_of(run: Member) -> Speed:
    """Of a run whose trajectory holds the last cycle in equal steps."""
    swimmer = run.summary()["swimmers"][0]
    start, stop = swimmer["window_steps"]
    beads = run.last_cycle(swimmer["name"]) / 1e-6
    radii = run.numbers("radius_m") / 1e-6
    arms = np.linalg.norm(np.diff(beads, axis=0), axis=2)
    moved = Stroke(beads[:, 0], radii, ((0, 1), (1, 2)), arms).motion()
    axis = (beads[2, 0] - beads[0, 0]) / np.linalg.norm(beads[2, 0] - beads[0, 0])
    theory = (
        small_stroke_velocity(radii, arms, stop - start),
        any_stroke_velocity(radii, arms, stop - start),
        float((moved[1] - moved[0]).mean(axis=0) @ axis / (stop - start)),
    )
    amplitudes = (swimmer["d1_cells"], swimmer["d2_cells"])
    mean = arms.mean(axis=1)
    return Speed(
        run.value, stop - start, swimmer["u_swim_lattice"], theory, amplitudes, np.prod(amplitudes) / np.prod(mean)
    )


@dataclass(frozen=True)
class Bulk:
    """What a swimmer does on its own."""

    speed_m_per_s: float
    dipole_N_m: float  # mean of Σ f·x along the axis, f the forces on the fluid
    period_s: float
    length_m: float  # mean distance of the outer beads
    viscosity_Pa_s: float

    @property
    def relative_dipole(self) -> float:
        """p/(η u L²)."""
        return self.dipole_N_m / (self.viscosity_Pa_s * self.speed_m_per_s * self.length_m**2)


def bulk_of(run: Member, swimmer: str) -> Bulk:
    """From a run whose trajectory holds the last cycle."""
    cycles = run.cycles(swimmer)
    places, forces = run.last_cycle(swimmer), -run.last_cycle(swimmer, "force_N")
    axis = np.array([cycles[f"axis_{letter}"][-1] for letter in "xyz"])
    dipole = np.mean(np.sum(((places - places.mean(axis=0)) @ axis) * (forces @ axis), axis=0))
    length = np.mean((places[2] - places[0]) @ axis)
    period_s = cycles["start_s"][1] - cycles["start_s"][0]
    viscosity_Pa_s = run.numbers("density_kg_per_m3")[0] * run.numbers("kinematic_viscosity_m2_per_s")[0]
    return Bulk(float(cycles["u_along_m_per_s"][-1]), float(dipole), float(period_s), float(length), viscosity_Pa_s)


def over_lag(stokes: Sequence[Speed], lattice: Sequence[Speed], theme: Theme) -> Any:
    """Speed over the lag of the leading force: dots measured, lines theory."""
    figure, panels = new_figure(theme, 3.6, ncols=2)
    for panel, speeds, title in zip(panels, (stokes, lattice), ("Stokes flow", "lattice Boltzmann")):
        lags = [speed.value / speed.period for speed in speeds]
        for number, (label, style) in enumerate(zip(LABELS, ("-", "--", ":"))):
            values = [1e6 * speed.theory[number] for speed in speeds]
            panel.plot(*_periodic(lags, values), style, color=theme.beads[number], linewidth=1.4, label=label)
        measured = [1e6 * speed.measured for speed in speeds]
        panel.plot(lags, measured, "o", color=theme.ink, markersize=4, label="Copepod")
        panel.set_title(title, fontsize=10, color=theme.ink)
        panel.set_xlabel("lag of the leading force φ/T")
    panels[0].set_ylabel("u [10⁻⁶ cells/step]")
    panels[0].legend(loc="lower left", fontsize=8, labelcolor=theme.ink, frameon=False)
    return figure


def _periodic(lags: Sequence[float], values: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """A smooth curve through points of a periodic function: its first waves, as many as the points determine."""
    orders = np.arange(1, (len(lags) - 1) // 2 + 1)[:4]

    def waves(places: np.ndarray) -> np.ndarray:
        phases = 2 * np.pi * np.outer(places, orders)
        return np.hstack([np.ones((len(places), 1)), np.cos(phases), np.sin(phases)])

    fine = np.linspace(0, 1, 200)
    return fine, waves(fine) @ np.linalg.lstsq(waves(np.array(lags)), np.array(values), rcond=None)[0]


def over_amplitude(stokes: Sequence[Speed], lattice: Sequence[Speed], theme: Theme) -> Any:
    """Measured speed over each theory's, over the square of the stroke."""
    figure, axes = new_figure(theme, 3.6)
    for speeds, marker, name in ((stokes, "o-", "Stokes"), (lattice, "s--", "lattice")):
        places = [speed.stroke_squared for speed in speeds]
        for number, label in enumerate(LABELS):
            ratios = [speed.measured / speed.theory[number] for speed in speeds]
            colour = theme.beads[number]
            axes.plot(places, ratios, marker, color=colour, markersize=4, linewidth=1, label=f"{name}: {label}")
    axes.axhline(1, color=theme.ink, linewidth=0.8)
    axes.set_xlim(left=0)
    axes.set_xlabel("d₁d₂/(l̄₁l̄₂)")
    axes.set_ylabel("u / u of theory")
    axes.legend(loc="center left", bbox_to_anchor=(1, 0.5), fontsize=8, labelcolor=theme.ink, frameon=False)
    return figure


def table(head: str, names: Sequence[str], speeds: Sequence[Speed]) -> str:
    """Markdown: a row per run, with these names."""
    rows = []
    strongest = max(abs(speed.theory[0] / speed.stroke_squared) for speed in speeds)
    for name, speed in zip(names, speeds):
        swims = abs(speed.theory[0] / speed.stroke_squared) > 1e-2 * strongest
        ratios = [f"{speed.measured / theory:.4f}" if swims else "–" for theory in speed.theory]
        arms = ", ".join(f"{value:.3f}" for value in speed.amplitudes)
        rows.append(" | ".join([name, arms, f"{speed.measured:.3e}", *ratios]))
    heads = [head, "d₁, d₂ [cells]", "u [cells/step]", *(f"u over {text}" for text in LABELS)]
    return markdown_table(" | ".join(heads), rows)


def directions(runs: dict[str, Member]) -> str:
    """Markdown: the same swimmer along several axes, in all cycles but the first; the first run is the reference."""
    rows, reference = [], None
    for name, run in runs.items():
        cycles = run.cycles("swimmer")
        summary = run.summary()
        scale = summary["step_s"] / summary["cell_size_m"]
        speeds = cycles["u_along_m_per_s"][1:] * scale
        reference = reference or speeds.mean()
        across = np.mean(cycles["u_across_m_per_s"][1:]) * scale / speeds.mean()
        rows.append(
            f"[{', '.join(name)}] | {', '.join(f'{1e5 * speed:.3f}' for speed in speeds)} | "
            f"{speeds.mean():.3e} | {speeds.mean() / reference:.4f} | {across:.1e} | {cycles['tilt_rad'][-1]:.1e}"
        )
    heads = "axis | u along its axis, cycle by cycle [10⁻⁵ cells/step] | mean | over the first | across over along"
    return markdown_table(f"{heads} | tilt at the end", rows)
