"""Bodies much lighter than the fluid move as theory and heavier bodies do, whatever component moves them."""

import os
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
os.environ.setdefault("COPEPOD_BIN_DIR", os.environ.get("COPEPOD_BUILT_PROGRAMS", str(ROOT / "build/bin")))

import light_bodies  # noqa: E402


class LightBodies(unittest.TestCase):
    def test_accelerate_from_rest_as_stokes_added_mass_and_history_make_them(self):
        for tau in (0.55, 2.0):
            for boundary in ("central_linear", "parabolic"):
                more = ("--set", f"fluid.moving_boundary={boundary}")
                deviation = light_bodies.deviation_of_start(0.01, 4.0, tau, 150, more=more)
                self.assertIsNotNone(deviation, (tau, boundary))
                self.assertLess(deviation, 0.03, (tau, boundary))

    def test_tend_to_the_velocity_of_a_body_of_the_fluids_density(self):
        neutral = self.last_velocity(1.0)
        for body in ("own", "Bullet", "Python"):
            self.assertAlmostEqual(self.last_velocity(0.01, body) / neutral, 1.0, delta=0.005, msg=body)

    def test_would_diverge_without_virtual_mass(self):
        values = light_bodies.settings(0.01, 4.0, 2 / 3, 32, 1e-4)
        self.assertIsNone(light_bodies.velocities({**values, "coupling.virtual_mass": "none"}, 2000))

    def last_velocity(self, ratio, body="own"):
        return light_bodies.velocities(light_bodies.settings(ratio, 4.0, 2 / 3, 32, 1e-4), 2000, body=body)[-1]


if __name__ == "__main__":
    unittest.main()
