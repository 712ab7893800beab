"""A swimmer in vacuum against the exact solution, and over all stiffnesses the resonance curve."""

from dataclasses import dataclass, replace

import numpy as np

from copepod_report.run_record import fit_arm
from copepod_report.style import new_figure
from copepod_report.vacuum_solution import VacuumSwimmer

_BEAD = 0  # the paper's sphere 2, which trails


@dataclass(frozen=True)
class ResonancePoint:
    """One run, compared over the last whole period of its samples."""

    exact: VacuumSwimmer
    amplitude_m: float  # of B2, fitted
    steady_m: float  # of B2 without transients
    deviation: float  # largest distance of B2 from the exact motion, per amplitude

    @property
    def steady_deviation(self):
        return abs(self.amplitude_m / self.steady_m - 1)


def compare(run):
    """ResonancePoint of a run of one swimmer in vacuum."""
    swimmer = run.swimmers()[0]
    exact = VacuumSwimmer.of_case(run.case, run.case["swimmers"][0])
    steps = run.trajectory.steps
    window = (steps > steps[-1] - swimmer.period) & (steps <= steps[-1])
    ours = swimmer.displacements_m()[_BEAD]
    theirs = exact.displacements_m(steps[window])[_BEAD]
    phase = 2 * np.pi * (steps[window] % swimmer.period) / swimmer.period
    _, amplitude, _ = fit_arm(phase, ours[window])
    return ResonancePoint(
        exact,
        amplitude,
        exact.steady_amplitude_m(_BEAD),
        np.abs(ours[window] - theirs).max() / amplitude,
    )


def points_of(runs):
    """ResonancePoints of the members of a sweep, by stiffness."""
    return sorted((compare(run) for run in runs), key=lambda point: point.exact.stiffness_N_per_m)


def cells(point):
    """Texts of a table row."""
    force = point.exact.amplitude_N
    return (
        f"{point.exact.frequency_ratio:.2f}",
        f"{point.exact.stiffness_N_per_m:.6g}",
        f"{point.amplitude_m / force:.10f}",
        f"{point.steady_m / force:.10f}",
        f"{point.steady_deviation:.1e}",
        f"{point.deviation:.1e}",
    )


def table(points):
    """Markdown: a row per stiffness."""
    lines = [
        "| ω₀/ω | k [N/m] | amplitude of B2 per force [m/N] | steady amplitude [m/N] | difference | from the exact motion |",
        "|---|---|---|---|---|---|",
    ]
    return "\n".join([*lines, *("| " + " | ".join(cells(point)) + " |" for point in points)])


def curve(points, theme):
    """Amplitude over ω₀/ω: exact steady curve, and a dot per run."""
    figure, axes = new_figure(theme, 3.6)
    first = points[0].exact
    ratios = np.linspace(points[0].exact.frequency_ratio, points[-1].exact.frequency_ratio, 600)
    base_k, damping_ratio = first.stiffness_N_per_m / first.frequency_ratio**2, first.damping_N_s_per_m / (
        2 * np.sqrt(first.mass_kg * first.stiffness_N_per_m)
    )
    exact = []
    for ratio in ratios:
        stiffness = base_k * ratio**2
        damping = 2 * damping_ratio * np.sqrt(first.mass_kg * stiffness)
        swimmer = replace(first, stiffness_N_per_m=stiffness, damping_N_s_per_m=damping)
        exact.append(swimmer.steady_amplitude_m(_BEAD) / swimmer.amplitude_N)
    axes.plot(ratios, exact, color=theme.beads[0], linewidth=1.4, label="exact, steady")
    axes.plot(
        [point.exact.frequency_ratio for point in points],
        [point.amplitude_m / point.exact.amplitude_N for point in points],
        "o",
        color=theme.beads[1],
        markersize=4,
        label="Copepod, last period",
    )
    axes.set_xlabel("ω₀/ω")
    axes.set_ylabel("amplitude of B2 per force [m/N]")
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2, fontsize=9, labelcolor=theme.ink, frameon=False)
    return figure
