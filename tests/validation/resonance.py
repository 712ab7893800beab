"""Amplitude of the trailing bead in vacuum over its natural frequency, beside the exact one: table and picture.

    deploy/copepod run configs/paper/resonance.yaml
    deploy/copepod python tests/validation/resonance.py runs/resonance docs/results/resonance.png
"""

import sys
from dataclasses import dataclass, replace

import copepod
import matplotlib.pyplot as plt
import numpy as np
from copepod_swimmers.vacuum import VacuumSwimmer

BEAD = 0  # B2, the paper's sphere 2, which trails
HEADS = "ω₀/ω | k [N/m] | amplitude of B2 per force [m/N] | steady amplitude [m/N] | difference | from the exact motion"


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

    def row(self):
        exact = self.exact
        amplitudes = " | ".join(f"{value / exact.amplitude_N:.10f}" for value in (self.amplitude_m, self.steady_m))
        known = f"| {exact.frequency_ratio:.2f} | {exact.stiffness_N_per_m:.6g} | {amplitudes} "
        return f"{known}| {self.steady_deviation:.1e} | {self.deviation:.1e} |"


def compared(run):
    swimmer = run.case["swimmers"][0]
    exact = VacuumSwimmer.of_case(run.case, swimmer)
    places_m = run.trajectory.loc[f"{swimmer['name']}.B2"]["z_m"]
    steps, period = places_m.index.to_numpy(), exact.period_steps
    window = (steps > steps[-1] - period) & (steps <= steps[-1])
    ours = (places_m.to_numpy() - places_m.iloc[0])[window]
    theirs = exact.displacements_m(steps[window])[BEAD]
    phase = 2 * np.pi * (steps[window] % period) / period
    fit = np.linalg.lstsq(np.column_stack([np.ones_like(phase), np.cos(phase), np.sin(phase)]), ours, rcond=None)[0]
    amplitude = np.hypot(*fit[1:])
    return ResonancePoint(exact, amplitude, exact.steady_amplitude_m(BEAD), np.abs(ours - theirs).max() / amplitude)


def points_of(directory):
    """Of the runs of a sweep, by stiffness."""
    return sorted(map(compared, copepod.load(directory)), key=lambda point: point.exact.stiffness_N_per_m)


def main(directory, picture):
    points = points_of(directory)
    print("\n".join([f"| {HEADS} |", "|---" * 6 + "|", *(point.row() for point in points)]))
    first = points[0].exact
    ratios = np.linspace(first.frequency_ratio, points[-1].exact.frequency_ratio, 600)
    exact = []
    for scale in ratios / first.frequency_ratio:  # with a damping as strong as that of the first run
        stiffness, damping = first.stiffness_N_per_m * scale**2, first.damping_N_s_per_m * scale
        swimmer = replace(first, stiffness_N_per_m=stiffness, damping_N_s_per_m=damping)
        exact.append(swimmer.steady_amplitude_m(BEAD) / swimmer.amplitude_N)
    figure, axes = plt.subplots(figsize=(8, 3.6))
    axes.plot(ratios, exact, linewidth=1.4, label="exact, steady")
    found = [(point.exact.frequency_ratio, point.amplitude_m / point.exact.amplitude_N) for point in points]
    axes.plot(*np.transpose(found), "o", markersize=4, label="Copepod, last period")
    axes.set(xlabel="ω₀/ω", ylabel="amplitude of B2 per force [m/N]")
    axes.legend()
    figure.tight_layout()
    figure.savefig(picture, dpi=110)


if __name__ == "__main__":
    main(*sys.argv[1:])
