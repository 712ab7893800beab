"""Properties of any swimmer at low Reynolds number: scallop theorem, reversal, amplitude squared, two balances."""

import json
import sys
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests" / "integration"))

from copepod_session import WholeRunTest  # noqa: E402
from copepod_report.cycles import read_cycles  # noqa: E402
from copepod_report.trajectory import Trajectory  # noqa: E402

BEADS = ("swimmer.B2", "swimmer.B1", "swimmer.B3")
PERIOD = 4000
MASS_KG = 5.44e-13
STIFFNESS_N_PER_M = 16.3
DAMPING_N_S_PER_M = 1.57237e-7
REST_M = 16e-6


class SwimmerTest(WholeRunTest):
    def swim(self, case, **stroke):
        """(speed in cells per step, run directory) of a case with another stroke."""
        settings = (f"swimmers.0.stroke.{key}={value}" for key, value in stroke.items())
        run = self.run_of(f"validation/{case}.yaml", *settings)
        return json.loads((run / "summary.json").read_text())["swimmers"][0]["u_swim_lattice"], run


class Ledger:
    """Impulse and work of the last cycle, from every step of it. Sums over a period are as exact as its periodicity."""

    def __init__(self, directory, first):
        trajectory = Trajectory(directory)
        window = (trajectory.steps >= first) & (trajectory.steps < first + PERIOD)
        steps = np.flatnonzero(window)
        beads = [trajectory.of(bead) for bead in BEADS]
        step_s = trajectory.time_s[steps[1]] - trajectory.time_s[steps[0]]
        v, z, fluid, drive = (
            np.array([bead[key][:, 2] for bead in beads])
            for key in ("velocity_m_per_s", "position_m", "force_N", "driving_N")
        )
        # Loads and drive of step n act between the states n and n + 1: the mean of both velocities makes the
        # work exact.
        mean_v = 0.5 * (v[:, steps] + v[:, steps + 1])
        mean_drive = 0.5 * (drive[:, steps] + drive[:, steps + 1])
        self.work_in = (mean_drive * mean_v).sum() * step_s
        self.work_on_fluid = -(fluid[:, steps] * mean_v).sum() * step_s
        self.work_in_dampers = DAMPING_N_S_PER_M * (np.diff(mean_v, axis=0) ** 2).sum() * step_s
        kinetic = 0.5 * MASS_KG * (v**2).sum(axis=0)
        stored = kinetic + 0.5 * STIFFNESS_N_PER_M * ((np.diff(z, axis=0) - REST_M) ** 2).sum(axis=0)
        self.work_stored = stored[steps[-1] + 1] - stored[steps[0]]
        self.impulse_of_drive = mean_drive.sum() * step_s
        self.impulse_of_fluid = fluid[:, steps].sum() * step_s
        self.momentum_gained = MASS_KG * (v[:, steps[-1] + 1] - v[:, steps[0]]).sum()
        self.impulse_scale = np.abs(fluid[:, steps]).sum() * step_s


class InStokesFlow(SwimmerTest):
    def test_a_stroke_that_is_its_own_reverse_leads_nowhere(self):
        """Scallop theorem: without a phase lag the swimmer passes through the same shapes back and forth."""
        swimming, _ = self.swim("stokes_swimmer")
        reciprocal, _ = self.swim("stokes_swimmer", phase_lag_steps=0)
        self.assertGreater(swimming, 1e-7)
        self.assertLess(abs(reciprocal), 1e-8 * swimming)

    def test_the_reversed_phase_swims_backwards_with_the_same_speed(self):
        forwards, _ = self.swim("stokes_swimmer")
        backwards, _ = self.swim("stokes_swimmer", phase_lag_steps=3000)
        self.assertAlmostEqual(backwards / forwards, -1, delta=1e-4)

    def test_speed_grows_with_the_square_of_a_small_amplitude(self):
        small, smaller, smallest = (self.swim("stokes_swimmer", amplitude_N=a)[0] for a in (1e-5, 5e-6, 2.5e-6))
        self.assertAlmostEqual(smaller / smallest, 4, delta=0.01)
        # What is missing at a finite amplitude shrinks with its square as well.
        missing = [abs(big / little - 4) for big, little in ((small, smaller), (smaller, smallest))]
        self.assertAlmostEqual(missing[0] / missing[1], 4, delta=0.4)

    def test_drive_pays_for_fluid_and_dampers_and_gives_no_momentum(self):
        _, directory = self.swim("stokes_swimmer")
        ledger = Ledger(directory, 16000)
        spent = ledger.work_on_fluid + ledger.work_in_dampers + ledger.work_stored
        self.assertGreater(ledger.work_in_dampers, 1e-3 * ledger.work_in)  # a term that the comparison sees
        self.assertAlmostEqual(spent / ledger.work_in, 1, delta=1e-5)
        self.assertLess(abs(ledger.work_stored), 1e-4 * ledger.work_in)  # periodic
        self.assertLess(abs(ledger.impulse_of_drive), 1e-12 * ledger.impulse_scale)
        self.assertLess(abs(ledger.impulse_of_fluid - ledger.momentum_gained), 1e-9 * ledger.impulse_scale)

    def test_in_every_cycle_the_drive_pays_for_fluid_and_springs(self):
        """Power that the run itself reports in cycles.csv, without dampers, against energies at the ends of cycles."""
        settings = (f"output.trajectory={{every_steps: {PERIOD}}}", "swimmers.0.spring.damping_N_s_per_m=0")
        run = self.run_of("validation/stokes_swimmer.yaml", *settings)
        trajectory, cycles = Trajectory(run), read_cycles(run / "cycles.csv")["swimmer"]
        beads = [trajectory.of(bead) for bead in BEADS]
        position, velocity = (np.array([bead[key] for bead in beads]) for key in ("position_m", "velocity_m_per_s"))
        stretch = np.linalg.norm(np.diff(position, axis=0), axis=2) - REST_M
        energy = 0.5 * MASS_KG * (velocity**2).sum(axis=(0, 2)) + 0.5 * STIFFNESS_N_PER_M * (stretch**2).sum(axis=0)
        stored_W = np.diff(energy) / np.diff(trajectory.time_s)
        missing = (cycles["power_W"] - cycles["dissipation_W"] - stored_W) / cycles["power_W"]
        self.assertGreater(stored_W[0], 0.05 * cycles["power_W"][0])  # a term that the comparison sees
        # Sampled at the start of each step: an error of order 1/T in the first cycle, of 1/T² where it repeats itself.
        self.assertLess(abs(missing[0]), 1e-3)
        self.assertLess(abs(missing[1:]).max(), 1e-5)


class InAnyDirection(SwimmerTest):
    """A swimmer is force-free and torque-free: which way it points, and how it came to, does not matter."""

    def last_cycle(self, *settings):
        """(speed along the arms, speed across, angle between arms and z axis in degrees): last of twelve cycles."""
        run = self.run_of("validation/turned_swimmer.yaml", *settings)
        trajectory = Trajectory(run)
        z = np.array([trajectory.of(bead)["position_m"] for bead in BEADS])
        start, end = (int(np.flatnonzero(trajectory.steps == step)[0]) for step in (11 * PERIOD, 12 * PERIOD))
        axis = z[2, start] - z[0, start]
        axis /= np.linalg.norm(axis)
        moved = (z[:, end] - z[:, start]).mean(axis=0) / 1e-6 / PERIOD
        along = float(moved @ axis)
        swimmer = json.loads((run / "summary.json").read_text())["swimmers"][0]
        self.assertAlmostEqual(swimmer["u_swim_lattice"] / along, 1, delta=1e-3)  # of the middle bead
        self.assertAlmostEqual(swimmer["kinematics"]["u_along_cells_per_step"] / along, 1, delta=1e-6)
        return along, float(np.linalg.norm(moved - along * axis)), float(np.degrees(np.arccos(axis[2])))

    def test_a_swimmer_that_was_turned_swims_on_along_its_own_axis(self):
        undisturbed, sideways, _ = self.last_cycle("actuators=[]")
        self.assertGreater(undisturbed, 6e-6)
        self.assertEqual(sideways, 0.0)
        along, across, tilt = self.last_cycle()
        self.assertGreater(tilt, 45)
        self.assertAlmostEqual(along / undisturbed, 1, delta=1e-3)
        self.assertLess(across, 1e-3 * undisturbed)

    def test_an_oblique_swimmer_swims_like_an_aligned_one(self):
        aligned, _, _ = self.last_cycle("actuators=[]")
        for axis in ("[1, 1, 1]", "[1, 2, 3]"):
            along, across, _ = self.last_cycle("actuators=[]", f"swimmers.0.axis={axis}")
            self.assertAlmostEqual(along / aligned, 1, delta=1e-3)
            self.assertLess(across, 1e-3 * aligned)


class OnTheLattice(SwimmerTest):
    def test_no_lag_no_motion_and_reversed_lag_swims_backwards(self):
        forwards, directory = self.swim("lattice_swimmer")
        backwards, _ = self.swim("lattice_swimmer", phase_lag_steps=3000)
        reciprocal, _ = self.swim("lattice_swimmer", phase_lag_steps=0)
        self.assertGreater(forwards, 1e-6)
        self.assertLess(abs(reciprocal), 1e-6 * forwards)
        self.assertAlmostEqual(
            backwards / forwards, -1, delta=0.02
        )  # four cycles: hardly anything of the start is left
        ledger = Ledger(directory, 12000)
        spent = ledger.work_on_fluid + ledger.work_in_dampers + ledger.work_stored
        self.assertAlmostEqual(spent / ledger.work_in, 1, delta=1e-5)
        self.assertLess(abs(ledger.impulse_of_fluid - ledger.momentum_gained), 1e-9 * ledger.impulse_scale)


if __name__ == "__main__":
    unittest.main()
