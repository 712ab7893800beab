"""Cases of configs/validation/ with motion and flow that have an exact theory, run by all three services."""

import csv
import json
import math
import os
import sys
import unittest
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests" / "integration"))

from copepod_session import CommandTest  # noqa: E402
from copepod_validation.oscillating_sphere import resistance  # noqa: E402
from copepod_validation.sudden_start import inverse_laplace  # noqa: E402

DENSITY, VISCOSITY, CELL_M = 1000.0, 1.0e-6, 1.0e-5


class UnsteadyMotion(CommandTest):
    programs = Path(os.environ.get("COPEPOD_BUILT_PROGRAMS", ROOT / "build/bin"))

    def run_of(self, name, *settings):
        """Rows of the trajectory of a case."""
        words = [word for setting in settings for word in ("--set", setting)]
        session = self.start("run", ROOT / f"configs/validation/{name}.yaml", *words, "--out", name)
        self.assertEqual(session.end(timeout_s=100), 0, "".join(session.stderr))
        return list(csv.DictReader((self.folder / name / "trajectory.csv").read_text().splitlines()))

    def step_s(self, name):
        return json.loads((self.folder / name / "summary.json").read_text())["step_s"]

    def test_oscillating_sphere_feels_the_force_of_stokes(self):
        rows = self.run_of("oscillating_sphere")
        force_N = np.array([float(row["fz_N"]) for row in rows[800:1200]])
        steps = np.array([int(row["step"]) for row in rows[800:1200]])
        phasor = 2 / 400 * np.sum(force_N * np.exp(-2j * math.pi * steps / 400))
        omega = 2 * math.pi / (400 * self.step_s("oscillating_sphere"))
        expected = -resistance(1j * omega, 4 * CELL_M, 32 * CELL_M, VISCOSITY, DENSITY) * (-2e-3j)  # velocity of a sine
        self.assertAlmostEqual(abs(phasor / expected), 1, delta=0.01)
        self.assertAlmostEqual(np.angle(phasor / expected), 0, delta=0.01)
        self.assertAlmostEqual(float(rows[1200]["z_m"]), 16.3e-5, delta=1e-15)

    def test_jerked_sphere_receives_the_impulse_of_basset(self):
        rows = self.run_of("jerked_sphere")
        step_s = self.step_s("jerked_sphere")
        impulse = step_s * np.cumsum([float(row["fz_N"]) for row in rows[:1000]])
        for step in range(200, 1000, 100):
            expected = -2e-3 * inverse_laplace(
                lambda s: resistance(s, 4e-5, 32e-5, VISCOSITY, DENSITY) / s**2, (step + 1) * step_s
            )
            self.assertAlmostEqual(impulse[step] / expected, 1, delta=0.015)

    def test_light_sphere_beside_a_moved_one_gets_its_own_virtual_mass(self):
        mass = 4 / 3 * math.pi * DENSITY * (4 * CELL_M) ** 3
        moved = "velocity_m_per_s: [0, 0, 2.0e-3], signal: {kind: sinusoid, amplitude: 1, period_steps: 400}"
        bodies = (
            f"{{name: ball, radius_m: 4.0e-5, mass_kg: {mass:.6e}, position_m: [1.6e-4, 1.6e-4, 1.6e-4], "
            f"motion: {{prescribed: {{{moved}}}}}}}",
            f"{{name: light, radius_m: 4.0e-5, mass_kg: {0.01 * mass:.6e}, position_m: [6.0e-5, 1.6e-4, 1.6e-4]}}",
        )
        rows = self.run_of("oscillating_sphere", f"bodies=[{', '.join(bodies)}]", "run.steps=200")
        speed = [abs(float(row["vz_m_per_s"])) for row in rows if row["body"] == "light"]
        self.assertGreater(max(speed), 0.0)
        self.assertLess(max(speed), 2e-3)  # carried along by the other one, not faster than it

    def test_driven_sphere_turns_against_the_torque_of_kirchhoff(self):
        spin = [float(row["wz_rad_per_s"]) for row in self.run_of("rotating_sphere")[-2:]]
        self.assertAlmostEqual(spin[0] / spin[1], 1, delta=1e-4)
        solid_fraction = 4 / 3 * math.pi / 6**3
        expected = 5e-14 * (1 - solid_fraction) / (8 * math.pi * DENSITY * VISCOSITY * 4e-5**3)
        self.assertAlmostEqual(spin[1] / expected, 1, delta=0.01)

    def test_taylor_green_vortex_decays_by_its_viscosity(self):
        self.run_of("taylor_green")
        with h5py.File(self.folder / "taylor_green/fields.h5") as fields:
            energy = [np.sum(fields[f"step_{step:09d}/velocity_m_per_s"][...] ** 2) for step in (100, 200)]
        k = 2 * math.pi / (32 * CELL_M)
        viscosity = math.log(energy[0] / energy[1]) / (4 * k**2 * 100 * self.step_s("taylor_green"))
        self.assertAlmostEqual(viscosity / VISCOSITY, 1, delta=0.005)


if __name__ == "__main__":
    unittest.main()
