"""`copepod check` predicts the memory of each process of a run within 10 % of its measured peak."""

import os
import tempfile
import unittest
from pathlib import Path

from memory_peaks import CHECKPOINTS, DOMAINS, MEAN, ROOT, measure

PROGRAMS = Path(os.environ.get("COPEPOD_BUILT_PROGRAMS", ROOT / "build/bin"))


class Memory(unittest.TestCase):
    def assert_predicted(self, *arguments, overrides=()):
        with tempfile.TemporaryDirectory() as folder:
            for component, (predicted, measured) in measure(PROGRAMS, folder, *arguments, overrides=overrides).items():
                with self.subTest(component):
                    if predicted == 0:
                        self.assertEqual(measured, 0)
                        continue
                    self.assertLess(abs(predicted / measured - 1.0), 0.1, f"{predicted} predicted, {measured} measured")

    def test_of_every_domain_precision_and_number_of_ranks(self):
        """The largest in double precision is among checkpoints."""
        small, middle, large = DOMAINS
        halves = ((small, "double", 1), (small, "single", 2), (middle, "double", 2), (middle, "single", 1))
        for cells, precision, ranks in (*halves, (large, "single", 2)):
            with self.subTest(f"{cells}, {precision}, {ranks}"):
                self.assert_predicted(cells, precision, ranks)

    def test_of_a_mean_field(self):
        self.assert_predicted(DOMAINS[1], "double", 2, MEAN)

    def test_of_checkpoints(self):
        self.assert_predicted(DOMAINS[2], "double", 1, CHECKPOINTS)

    def test_of_a_run_in_one_process(self):
        overrides = ["fluid.solver=stokes", "run.steps=200000", "services.transport=in_process"]
        self.assert_predicted(DOMAINS[0], "double", 1, overrides=overrides)
        for cells, ranks in zip(DOMAINS, (2, 1, 2)):
            with self.subTest(f"{cells}, {ranks}"):
                self.assert_predicted(cells, "double", ranks, overrides=["services.transport=in_process"])

    def test_of_bodies_by_engines(self):
        for engine in ("bullet", "mujoco"):
            with self.subTest(engine):
                if not (PROGRAMS / f"{engine}_body_service").exists():
                    self.skipTest(f"built without {engine}")
                self.assert_predicted(DOMAINS[0], "double", 1, overrides=[f"body.solver={engine}"])

    def test_of_a_fluid_without_cells(self):
        self.assert_predicted(DOMAINS[0], "double", 1, overrides=["fluid.solver=stokes", "run.steps=20000"])


if __name__ == "__main__":
    unittest.main()
