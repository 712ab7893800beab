"""Some of the random scenes of docs/results/engines.md: engines agree, or differ where the page lists it."""

import tempfile
import unittest

import engines

WITHIN_PERCENT = 2.0


class Scenes(unittest.TestCase):
    def deviations(self, number):
        with tempfile.TemporaryDirectory() as folder:
            return engines.compare(number, folder)[0]

    def test_engines_agree(self):
        for number, refused in ((5, ()), (20, ()), (4, ("bullet",)), (22, ("bullet",))):
            for engine, found in self.deviations(number).items():
                with self.subTest(scene=number, engine=engine):
                    if engine in refused:
                        self.assertIn("joint:", found)
                    else:
                        self.assertLess(max(found.values()), WITHIN_PERCENT, found)

    def test_friction_that_sticks_differs_as_the_page_has_it(self):
        found = self.deviations(0)
        self.assertEqual(found["mujoco"], "contact:friction")
        self.assertAlmostEqual(found["bullet"]["rebound"], 6.4, delta=1)


if __name__ == "__main__":
    unittest.main()
