"""The swimmer in vacuum: its exact motion, and over all stiffnesses the resonance curve."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from copepod_report.page import HTML
from copepod_report.run_record import RunRecord, SwimmerRecord, fit_arm
from copepod_report.style import LIGHT, legend_above, new_figure
from copepod_run.figures import markdown_table

# Shapes of motion (B2, B1, B3) and how many times k and γ act on each; the third, a translation, is never driven.
_MODES = ((np.array([1.0, 0.0, -1.0]), 1.0), (np.array([1.0, -2.0, 1.0]), 3.0))


@dataclass(frozen=True)
class VacuumSwimmer:
    """Masses, springs and stroke; SI units, time in steps.

    The forces are those of docs/theory.md (C4): −a sin(ωt) on B2 for 0 ≤ t < cT, a sin(ω(t − φ)) on B3 for
    φ ≤ t < cT + φ, and on B1 what balances them.
    """

    mass_kg: float
    stiffness_N_per_m: float
    damping_N_s_per_m: float
    amplitude_N: float
    period_steps: int
    phase_lag_steps: int
    cycles: int
    step_s: float

    @classmethod
    def of_case(cls, case: Mapping[str, Any], swimmer: Mapping[str, Any]) -> "VacuumSwimmer":
        """From the resolved case and its section of the swimmer."""
        known = {"mass_kg": swimmer["bead_mass_kg"], "step_s": case["step_s"], **swimmer["spring"], **swimmer["stroke"]}
        return cls(**{field.name: known[field.name] for field in fields(cls)})

    @property
    def omega_rad_per_s(self) -> float:
        return 2 * np.pi / (self.period_steps * self.step_s)

    @property
    def frequency_ratio(self) -> float:
        """ω₀/ω with ω₀ = √(k/m)   [paper, resonance figure]."""
        return np.sqrt(self.stiffness_N_per_m / self.mass_kg) / self.omega_rad_per_s

    def displacements_m(self, steps: Sequence[int] | np.ndarray) -> np.ndarray:
        """Of B2, B1, B3 from their places at rest, shape (3, len(steps)).

        In the mode e the motion is q̈ + (nγ/m) q̇ + (nk/m) q = e·F/(m e·e); it responds to every sine that begins or
        ends with a steady part and a decaying one (`_response`), and the responses add up.
        """
        steps = np.asarray(steps, dtype=np.int64)
        total = np.zeros((3, len(steps)))
        for shape, times in _MODES:
            for bead, sign, start in ((0, -1.0, 0), (2, 1.0, self.phase_lag_steps)):
                # A force on an outer bead comes with its opposite on the middle one.
                pull = sign * self.amplitude_N * (shape[bead] - shape[1]) / (self.mass_kg * shape @ shape)
                stop = start + self.cycles * self.period_steps
                answer = self._response(times, steps - start) - self._response(times, steps - stop)
                total += np.outer(shape, pull * answer)
        return total

    def steady_amplitude_m(self, bead: int) -> float:
        """Amplitude of a bead (0, 1, 2 for B2, B1, B3) once every transient has died."""
        lag = 2 * np.pi * (self.phase_lag_steps % self.period_steps) / self.period_steps
        phasor = 0j
        for shape, times in _MODES:
            drive = -(shape[0] - shape[1]) + (shape[2] - shape[1]) * np.exp(-1j * lag)
            phasor += shape[bead] * drive * self._transfer(times) / (self.mass_kg * shape @ shape)
        return self.amplitude_N * abs(phasor)

    def _transfer(self, times: float) -> complex:
        """H of q̈ + g q̇ + w² q = e^{iωt}: q = H e^{iωt}."""
        omega = self.omega_rad_per_s
        return self.mass_kg / (
            times * self.stiffness_N_per_m - self.mass_kg * omega**2 + 1j * times * self.damping_N_s_per_m * omega
        )

    def _response(self, times: float, steps: np.ndarray) -> np.ndarray:
        """Answer to sin(ωt) for t ≥ 0 of an oscillator at rest; zero before.

            q = Im(H e^{iωt}) + e^{−gt/2} (C cos Ωt + S sin Ωt),   C = −Im H,   S = (g C/2 − ω Re H)/Ω

        Whole periods are taken off in integers, so that the phase of the steady part never drifts.
        """
        on = steps >= 0
        omega, transfer = self.omega_rad_per_s, self._transfer(times)
        friction = times * self.damping_N_s_per_m / self.mass_kg
        own = np.sqrt(times * self.stiffness_N_per_m / self.mass_kg - friction**2 / 4 + 0j)
        time_s = np.where(on, steps, 0) * self.step_s
        phase = 2 * np.pi * (steps % self.period_steps) / self.period_steps
        cosine = -transfer.imag
        sine = (friction * cosine / 2 - omega * transfer.real) / own
        dying = np.exp(-friction * time_s / 2) * (cosine * np.cos(own * time_s) + sine * np.sin(own * time_s))
        return np.where(on, (transfer * np.exp(1j * phase)).imag + dying.real, 0.0)


_BEAD = 0  # the paper's sphere 2, which trails


@dataclass(frozen=True)
class ResonancePoint:
    """One run, compared over the last whole period of its samples."""

    exact: VacuumSwimmer
    amplitude_m: float  # of B2, fitted
    steady_m: float  # of B2 without transients
    deviation: float  # largest distance of B2 from the exact motion, per amplitude

    @property
    def steady_deviation(self) -> float:
        return abs(self.amplitude_m / self.steady_m - 1)


def compare(run: RunRecord) -> ResonancePoint:
    """ResonancePoint of a run of one swimmer in vacuum."""
    swimmer, steps = run.swimmers[0], run.trajectory.steps
    exact = VacuumSwimmer.of_case(run.case, run.case["swimmers"][0])
    window = (steps > steps[-1] - swimmer.period) & (steps <= steps[-1])
    ours = swimmer.displacements_m()[_BEAD][window]
    theirs = exact.displacements_m(steps[window])[_BEAD]
    _, amplitude, _ = fit_arm(2 * np.pi * (steps[window] % swimmer.period) / swimmer.period, ours)
    return ResonancePoint(exact, amplitude, exact.steady_amplitude_m(_BEAD), np.abs(ours - theirs).max() / amplitude)


def points_of(runs: Sequence[RunRecord]) -> list[ResonancePoint]:
    """ResonancePoints of the members of a sweep, by stiffness."""
    return sorted((compare(run) for run in runs), key=lambda point: point.exact.stiffness_N_per_m)


def _cells(point: ResonancePoint) -> tuple[str, ...]:
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


def markdown(points: Sequence[ResonancePoint]) -> str:
    """Markdown: a row per stiffness."""
    heads = "ω₀/ω | k [N/m] | amplitude of B2 per force [m/N] | steady amplitude [m/N] | difference"
    return markdown_table(f"{heads} | from the exact motion", map(" | ".join, map(_cells, points)))


def curve(points: Sequence[ResonancePoint]) -> Any:
    """Amplitude over ω₀/ω: exact steady curve, the damping as strong as that of the first run, and a dot per run."""
    figure, axes = new_figure(3.6)
    first = points[0].exact
    ratios = np.linspace(first.frequency_ratio, points[-1].exact.frequency_ratio, 600)
    exact = []
    for scale in ratios / first.frequency_ratio:
        stiffness, damping = first.stiffness_N_per_m * scale**2, first.damping_N_s_per_m * scale
        swimmer = replace(first, stiffness_N_per_m=stiffness, damping_N_s_per_m=damping)
        exact.append(swimmer.steady_amplitude_m(_BEAD) / swimmer.amplitude_N)
    axes.plot(ratios, exact, color=LIGHT.beads[0], linewidth=1.4, label="exact, steady")
    found = [(point.exact.frequency_ratio, point.amplitude_m / point.exact.amplitude_N) for point in points]
    axes.plot(*np.transpose(found), "o", color=LIGHT.beads[1], markersize=4, label="Copepod, last period")
    axes.set(xlabel="ω₀/ω", ylabel="amplitude of B2 per force [m/N]")
    legend_above(axes)
    return figure


def sweeps_of(runs: Sequence[RunRecord]) -> dict[str, list[RunRecord]]:
    """Members of sweeps of the stiffness in vacuum, by the sweep's name."""
    sweeps: dict[str, list[RunRecord]] = {}
    for run in runs:
        varied = [key.rpartition(".")[2] for key in run.sweep.values]
        is_of_three_beads = [swimmer.is_three_beads for swimmer in run.swimmers] == [True]
        if varied == ["stiffness_N_per_m"] and is_of_three_beads and run.case["fluid"]["solver"] == "vacuum":
            sweeps.setdefault(run.sweep.name, []).append(run)
    return sweeps


def section(name: str, points: Sequence[ResonancePoint], figures: Sequence[str]) -> str:
    """HTML: the resonance curve of a sweep and its table."""
    heads = ("ω₀/ω", "k [N/m]", "amplitude / force [m/N]", "steady [m/N]", "difference", "from the exact motion")
    return str(HTML.resonance_section(name, figures, heads, map(_cells, points)))


def draw_exact(axes: Any, swimmer: SwimmerRecord) -> None:
    """The exact motion as dots on the lines of ours, and how far they are apart."""
    exact = VacuumSwimmer.of_case(swimmer.run.case, swimmer.section)
    rest = swimmer.positions()[:, :1]
    motion = rest + exact.displacements_m(swimmer.run.trajectory.steps) / swimmer.run.length_unit[0]
    shown = slice(None, None, max(1, len(swimmer.periods()) // 70))
    for values in motion:
        axes.plot(swimmer.periods()[shown], values[shown], ".", color=LIGHT.ink, markersize=2.5)
    apart = np.abs(motion - swimmer.positions()).max()
    title = f"dots: exact solution, at most {apart:.1e} {swimmer.run.length_unit[1]} away"
    axes.set_title(title, fontsize=9, loc="left", color=LIGHT.ink)
