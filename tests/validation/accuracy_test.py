"""References of `copepod validate`; its fast subset with the recommended scheme, and its command line."""

import os
import sys
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests" / "integration"))

from copepod_session import CommandTest  # noqa: E402
from copepod_validation import crossing_sphere, frames, oscillating_sphere, settling_sphere  # noqa: E402
from copepod_validation import shear, slow_bodies, sphere_array, sudden_start, wall  # noqa: E402
from copepod_validation.experiment import SCHEMES  # noqa: E402

SCHEME = "parabolic"


class References(unittest.TestCase):
    def test_sphere_towards_a_wall(self):
        for height, drag in ((1.1276, 9.2534), (1.5, 3.20539), (2.0, 2.12554), (3.0, 1.56921)):  # Brenner 1961
            self.assertAlmostEqual(wall.approach(height) / drag, 1, delta=1e-4)

    def test_images_of_a_force_in_a_periodic_cube(self):
        self.assertAlmostEqual(50 * slow_bodies.images(0.0, 50), -2.837297, places=5)  # Hasimoto 1959
        self.assertAlmostEqual(50 * slow_bodies.images(1e-4, 50), -2.837297, places=5)

    def test_drag_of_a_capsule_is_that_of_more_and_other_singularities(self):
        self.assertAlmostEqual(slow_bodies.capsule_drag(2), 1.31530, delta=1e-4)
        self.assertAlmostEqual(slow_bodies.capsule_drag(0), 1.48523, delta=5e-4)


class Accuracy(CommandTest):
    programs = Path(os.environ.get("COPEPOD_BUILT_PROGRAMS", ROOT / "build/bin"))

    def validate(self, *arguments):
        session = self.start("validate", "--fast", "--schemes", SCHEME, "--out", "out", *arguments)
        self.assertEqual(session.end(timeout_s=100), 0, "".join(session.stderr))
        return "".join(session.stderr)

    def measured(self, case):
        """(experiment, what the case makes of its run)"""
        experiments = case.experiments(SCHEME, SCHEMES[SCHEME], fast=True)
        return [(one, case.evaluate(self.folder / "runs/validation" / one.name, one)) for one in experiments]

    def test_drag_of_an_array_at_eight_cells_per_diameter(self):
        """Measured: −0.2 ± 0.15 % at every relaxation time. Central linear interpolation has −1.4 ± 0.8 %, bounce-back
        spreads by 3 %, and linear interpolation is 7 % lower at τ = 2 than at 0.6."""
        self.validate("--cases", "sphere_array")
        errors = {tau: [] for tau in (0.6, 2.0)}
        for experiment, drag in self.measured(sphere_array):
            self.assertLess(drag.change, 0.1)  # the runs are long enough
            errors[experiment.point.tau].append(drag.error)
        for values in errors.values():
            self.assertLess(abs(np.mean(values)), 0.5)
            self.assertLess(np.ptp(values), 0.5)
        self.assertLess(np.abs(np.subtract(*errors.values())).max(), 0.1)
        page = (self.folder / "out/accuracy.md").read_text()
        self.assertIn(f"| 0.125 | 8.1 | 2 | {np.mean(errors[2.0]):+.2f}", page)
        self.assertTrue((self.folder / "out/accuracy_array.png").exists())

    def test_noise_of_a_sphere_that_crosses_the_grid_and_nothing_is_computed_twice(self):
        """Measured: 0.4 % rms, peaks of 1.2 %. Bounce-back has 5 and 13 %, central linear 1.4 and 3.8 %."""
        self.assertIn("starts", self.validate("--cases", "crossing_sphere"))
        ((_, noise),) = self.measured(crossing_sphere)
        self.assertLess(noise.rms, 0.5)
        self.assertLess(noise.peak, 2.0)
        self.assertLess(noise.averaged, 0.4)
        self.assertGreater(noise.rms, 0.1)  # it is the load of a step
        again = self.validate("--cases", "crossing_sphere")
        self.assertIn("1 cases, 1 done already", again)
        self.assertNotIn("starts", again)

    def test_drag_towards_a_wall_with_a_film_of_a_quarter_cell_in_between(self):
        """Measured: −1.1 %; −57 % without lubrication."""
        self.validate("--cases", "wall")
        ((_, drag),) = self.measured(wall)
        self.assertLess(abs(drag.error), 3.0)
        self.assertLess(drag.change, 0.2)

    def test_oscillating_sphere_feels_the_force_of_stokes(self):
        """Measured: 0.2 %, 0.0°. Bounce-back is 1.7 % off, with bgk 10 %."""
        self.validate("--cases", "oscillating_sphere")
        ((_, ratio),) = self.measured(oscillating_sphere)
        self.assertLess(abs(ratio - 1), 0.01)

    def test_sphere_that_starts_suddenly_receives_the_impulse_of_basset(self):
        """Measured: −1.8 %; with bgk 14 %."""
        self.validate("--cases", "sudden_start")
        ((_, start),) = self.measured(sudden_start)
        self.assertLess(abs(start.error), 3.0)
        self.assertLess(start.alternating, 2.0)

    def test_free_sphere_in_shear_rotates_at_half_the_rate(self):
        self.validate("--cases", "shear")
        ((_, rotation),) = self.measured(shear)
        self.assertLess(abs(rotation.error), 0.3)
        self.assertLess(rotation.deviation, 0.3)

    def test_spheres_that_follow_each_other_have_the_drag_of_stimson_and_jeffery(self):
        """Measured: −0.2 %. Bounce-back is 1.7 % off."""
        self.validate("--cases", "slow_bodies")
        ((_, error),) = self.measured(slow_bodies)
        self.assertLess(abs(error), 0.5)

    def test_velocity_of_a_settling_sphere(self):
        """Measured at 9 cells per diameter: peak −0.4 %, curve within 2.7 %. Bounce-back has 5 % in both."""
        self.validate("--cases", "settling_sphere")
        ((experiment, fall),) = self.measured(settling_sphere)
        self.assertLess(abs(settling_sphere.peak_error(experiment.point.oil, fall)), 2.0)
        self.assertLess(settling_sphere.deviation_from_measured_curve(fall), 3.0)
        self.assertGreater(fall.gap[-1], 0.5)  # it does not touch the floor

    def test_the_force_is_the_same_in_every_frame(self):
        """Measured at τ = 0.6: 0.1 %. Bounce-back is off by 1 %."""
        self.validate("--cases", "frames")
        (_, passed), (_, moving) = self.measured(frames)
        self.assertAlmostEqual(moving / passed, 1, delta=0.004)

    def test_an_unknown_name_is_refused_with_those_that_exist(self):
        for option, name in (("--cases", "crossing_sphere"), ("--schemes", "central_linear")):
            session = self.start("validate", option, "unknown", "--out", "out")
            self.assertEqual(session.end(), 2)
            self.assertIn("unknown is not a", session.last_line)
            self.assertIn(name, session.last_line)


if __name__ == "__main__":
    unittest.main()
