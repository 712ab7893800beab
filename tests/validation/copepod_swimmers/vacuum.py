"""The paper's swimmer in vacuum: its exact motion, and its amplitude once it is steady."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

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
