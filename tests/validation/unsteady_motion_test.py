"""Cases of configs/validation/ with motion and flow that have an exact theory."""

import csv
import json
import math
import sys
import unittest
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests" / "integration"))

from copepod_session import WholeRunTest  # noqa: E402
from copepod_validation.oscillating_sphere import resistance  # noqa: E402
from copepod_validation.sudden_start import inverse_laplace  # noqa: E402

DENSITY, VISCOSITY, CELL_M = 1000.0, 1.0e-6, 1.0e-5


class UnsteadyMotion(WholeRunTest):
    def rows_of(self, name, *settings):
        """Rows of the trajectory of a case; `self.directory` is that of the run, `self.step_s` its step."""
        self.directory = self.run_of(f"validation/{name}.yaml", *settings)
        self.step_s = json.loads((self.directory / "summary.json").read_text())["step_s"]
        return list(csv.DictReader((self.directory / "trajectory.csv").read_text().splitlines()))

    def test_oscillating_sphere_feels_the_force_of_stokes(self):
        rows = self.rows_of("oscillating_sphere")
        force_N = np.array([float(row["fz_N"]) for row in rows[800:1200]])
        steps = np.array([int(row["step"]) for row in rows[800:1200]])
        phasor = 2 / 400 * np.sum(force_N * np.exp(-2j * math.pi * steps / 400))
        omega = 2 * math.pi / (400 * self.step_s)
        expected = -resistance(1j * omega, 4 * CELL_M, 32 * CELL_M, VISCOSITY, DENSITY) * (-2e-3j)  # velocity of a sine
        self.assertAlmostEqual(abs(phasor / expected), 1, delta=0.01)
        self.assertAlmostEqual(np.angle(phasor / expected), 0, delta=0.01)
        self.assertAlmostEqual(float(rows[1200]["z_m"]), 16.3e-5, delta=1e-15)

    def test_jerked_sphere_receives_the_impulse_of_basset(self):
        rows = self.rows_of("jerked_sphere")
        impulse = self.step_s * np.cumsum([float(row["fz_N"]) for row in rows[:1000]])
        for step in range(200, 1000, 100):
            expected = -2e-3 * inverse_laplace(
                lambda s: resistance(s, 4e-5, 32e-5, VISCOSITY, DENSITY) / s**2, (step + 1) * self.step_s
            )
            self.assertAlmostEqual(impulse[step] / expected, 1, delta=0.015)

    def test_cylinder_in_a_slit_drifts_to_its_place_between_wall_and_middle(self):
        place = float(self.rows_of("migrating_cylinder")[-1]["x_m"]) / 48.0e-5
        self.assertAlmostEqual(place / 0.2745, 1, delta=0.01)  # [Inamuro, Maeba and Ogino 2000], Re = 12.78

    def test_neutral_sphere_of_three_fifths_of_a_slit_lags_behind_the_flow(self):
        """0.86 of the velocity in the middle [Staben, Zinchenko and Davis 2003]; 0.88 by Faxen's law alone."""
        width, radius, fastest = 24 * CELL_M, 7.2 * CELL_M, 2e-3
        pressure_gradient = 8 * DENSITY * VISCOSITY * fastest / width**2
        pushed = f"{4 / 3 * math.pi * radius**3 * pressure_gradient:.9e}"
        rows = self.rows_of(
            "migrating_cylinder",
            "fluid.relaxation_time=1",
            "fluid.domain_cells=[24, 64, 64]",
            f"fluid.body_force_N_per_m3=[0, {pressure_gradient:.9e}, 0]",
            f"bodies=[{{name: cylinder, radius_m: {radius:.9e}, density_kg_per_m3: {DENSITY}, "
            "position_m: [1.2e-4, 3.23e-4, 3.22e-4]}]",
            f"actuators.0.signal.amplitude_N={pushed}",
            "run.steps=5000",
        )
        self.assertAlmostEqual(float(rows[-1]["vy_m_per_s"]) / fastest / 0.86, 1, delta=0.015)

    def test_started_sphere_and_fluid_keep_their_momentum(self):
        for ratio in (0.5, 1, 2):
            mass = ratio * 4 / 3 * math.pi * DENSITY * (4 * CELL_M) ** 3
            body = (
                f"{{name: ball, radius_m: 4.0e-5, mass_kg: {mass:.9e}, position_m: [1.21e-4, 1.19e-4, 1.23e-4], "
                "velocity_m_per_s: [2.0e-3, 0, 0]}"
            )
            rows = self.rows_of(
                "oscillating_sphere",
                f"bodies=[{body}]",
                "coupling.load_averaging=two_step",
                "fluid.domain_cells=[24, 24, 24]",
                "run.steps=300",
                "output.fields.every_steps=300",
            )
            with h5py.File(self.directory / "fields.h5") as fields:
                last = fields["step_000000300"]
                momenta = last["density_kg_per_m3"][...] * last["velocity_m_per_s"][..., 0] * CELL_M**3
                of_fluid = np.sum(momenta[last["body"][...] == 0])
            end = mass * float(rows[-1]["vx_m_per_s"])
            self.assertAlmostEqual((of_fluid + end) / (mass * 2e-3), 1, delta=0.005)
            summary = json.loads((self.directory / "summary.json").read_text())
            self.assertLess(summary["momentum_drift"], 0.005)
            momentum = summary["balance"]["momentum_N_s"]
            self.assertAlmostEqual(momentum["bodies_at_start"][0] / (mass * 2e-3), 1, delta=1e-8)
            self.assertAlmostEqual(momentum["bodies_at_end"][0] / end, 1, delta=1e-8)
            self.assertAlmostEqual(-momentum["from_fluid"][0] / of_fluid, 1, delta=0.005)
            energy = summary["balance"]["energy_J"]
            self.assertAlmostEqual(energy["bodies_at_start"] / (0.5 * mass * 4e-6), 1, delta=1e-8)
            # The first load acts with the velocity before it: the bodies lose less than the fluid receives.
            self.assertLess(energy["from_fluid"], energy["bodies_at_end"] - energy["bodies_at_start"])

    def test_light_sphere_beside_a_moved_one_gets_its_own_virtual_mass(self):
        mass = 4 / 3 * math.pi * DENSITY * (4 * CELL_M) ** 3
        moved = "velocity_m_per_s: [0, 0, 2.0e-3], signal: {kind: sinusoid, amplitude: 1, period_steps: 400}"
        bodies = (
            f"{{name: ball, radius_m: 4.0e-5, mass_kg: {mass:.6e}, position_m: [1.6e-4, 1.6e-4, 1.6e-4], "
            f"motion: {{prescribed: {{{moved}}}}}}}",
            f"{{name: light, radius_m: 4.0e-5, mass_kg: {0.01 * mass:.6e}, position_m: [6.0e-5, 1.6e-4, 1.6e-4]}}",
        )
        rows = self.rows_of("oscillating_sphere", f"bodies=[{', '.join(bodies)}]", "run.steps=200")
        speed = [abs(float(row["vz_m_per_s"])) for row in rows if row["body"] == "light"]
        self.assertGreater(max(speed), 0.0)
        self.assertLess(max(speed), 2e-3)  # carried along by the other one, not faster than it

    def test_driven_sphere_turns_against_the_torque_of_kirchhoff(self):
        spin = [float(row["wz_rad_per_s"]) for row in self.rows_of("rotating_sphere")[-2:]]
        self.assertAlmostEqual(spin[0] / spin[1], 1, delta=1e-4)
        solid_fraction = 4 / 3 * math.pi / 6**3
        expected = 5e-14 * (1 - solid_fraction) / (8 * math.pi * DENSITY * VISCOSITY * 4e-5**3)
        self.assertAlmostEqual(spin[1] / expected, 1, delta=0.01)

    def test_taylor_green_vortex_decays_by_its_viscosity(self):
        self.rows_of("taylor_green")
        with h5py.File(self.directory / "fields.h5") as fields:
            energy = [np.sum(fields[f"step_{step:09d}/velocity_m_per_s"][...] ** 2) for step in (100, 200)]
        k = 2 * math.pi / (32 * CELL_M)
        viscosity = math.log(energy[0] / energy[1]) / (4 * k**2 * 100 * self.step_s)
        self.assertAlmostEqual(viscosity / VISCOSITY, 1, delta=0.005)


if __name__ == "__main__":
    unittest.main()
