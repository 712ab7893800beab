"""Experiments of fluid and bodies together: each with its reference and tolerance."""

import csv
import json
import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests" / "integration"))

from copepod_session import WholeRunTest  # noqa: E402
from vacuum_deviation import deviation  # noqa: E402


class WholeRun(WholeRunTest):
    def test_swimmer_in_vacuum_has_ten_digits_at_every_step_of_the_reference(self):
        """Exact modal solution; ten significant digits as the paper claims [physics: vacuum]."""
        rows, position, velocity = deviation(self.run_of("paper/vacuum.yaml") / "trajectory.csv")
        self.assertEqual(rows, 3 * 197)
        self.assertLess(position, 1e-10)
        self.assertLess(velocity, 1e-10)

    def test_swimmer_in_stokes_flow_tends_to_the_theory_of_small_spheres_and_strokes(self):
        """u_GA is the leading order in a/l, here 1/16 and 1/32, and in d/l [Golestanian & Ajdari 2008]."""
        excess = []
        for gap_m in (56e-6, 120e-6):
            run = self.run_of(
                "quick/three_sphere.yaml",
                "fluid.solver=stokes",
                "swimmers.0.stroke.amplitude_N=7e-6",
                f"swimmers.0.rest_gap_m=[{gap_m}, {gap_m}]",
            )
            swimmer = json.loads((run / "summary.json").read_text())["swimmers"][0]
            excess.append(swimmer["u_swim_lattice"] / swimmer["u_GA_lattice"] - 1.0)
        self.assertLess(abs(excess[0]), 0.05, excess)
        self.assertAlmostEqual(excess[1] / excess[0], 0.5, delta=0.1)

    def test_quarter_of_the_domain_moves_like_the_whole(self):
        """Mirrors on cell faces are exact: 1e-9 cells over 3000 steps allow for rounding only."""
        case = ("quick/three_sphere.yaml", "run.steps=3000", "output.fields.mean_over_steps=[0, 0]")
        quarter, whole = self.run_of(*case), self.run_of(*case, "fluid.symmetry_planes=[]")
        moved = 0.0
        for ours, theirs in zip(rows_of(quarter), rows_of(whole), strict=True):
            for key in ("x_m", "y_m", "z_m"):
                self.assertLess(abs(float(ours[key]) - float(theirs[key])) / 1e-6, 1e-9)
            moved = max(moved, abs(float(ours["vz_m_per_s"])))
        self.assertGreater(moved, 1.0)


def rows_of(run):
    return csv.DictReader((run / "trajectory.csv").read_text().splitlines())


if __name__ == "__main__":
    unittest.main()
