"""Experiments that need all three services: each with its reference and tolerance."""

import csv
import json
import os
import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests" / "integration"))

from copepod_session import CommandTest  # noqa: E402
from vacuum_deviation import deviation  # noqa: E402


class WholeRun(CommandTest):
    programs = Path(os.environ.get("COPEPOD_BUILT_PROGRAMS", ROOT / "build/bin"))

    def trajectory_of(self, name, *arguments):
        session = self.start("run", *arguments, "--out", name)
        self.assertEqual(session.end(timeout_s=400), 0, "".join(session.stderr))
        return self.folder / name / "trajectory.csv"

    def test_swimmer_in_vacuum_has_ten_digits_at_every_step_of_the_reference(self):
        """Exact modal solution; ten significant digits as the paper claims [physics: vacuum]."""
        rows, position, velocity = deviation(self.trajectory_of("vacuum", ROOT / "configs/paper/vacuum.yaml"))
        self.assertEqual(rows, 3 * 197)
        self.assertLess(position, 1e-10)
        self.assertLess(velocity, 1e-10)

    def test_swimmer_in_stokes_flow_tends_to_the_theory_of_small_spheres_and_strokes(self):
        """u_GA is the leading order in a/l, here 1/16 and 1/32, and in d/l [Golestanian & Ajdari 2008]."""
        excess = []
        for name, gap_m in (("short", 56e-6), ("long", 120e-6)):
            self.trajectory_of(
                name,
                ROOT / "configs/quick/three_sphere.yaml",
                *(
                    word
                    for setting in (
                        "fluid.solver=stokes",
                        "services.transport=in_process",
                        "swimmers.0.stroke.amplitude_N=7e-6",
                        f"swimmers.0.rest_gap_m=[{gap_m}, {gap_m}]",
                    )
                    for word in ("--set", setting)
                ),
            )
            swimmer = json.loads((self.folder / name / "summary.json").read_text())["swimmers"][0]
            excess.append(swimmer["u_swim_lattice"] / swimmer["u_GA_lattice"] - 1.0)
        self.assertLess(abs(excess[0]), 0.05, excess)
        self.assertAlmostEqual(excess[1] / excess[0], 0.5, delta=0.1)

    def test_quarter_of_the_domain_moves_like_the_whole(self):
        """Mirrors on cell faces are exact: 1e-9 cells over 3000 steps allow for rounding only."""
        case = (
            ROOT / "configs/quick/three_sphere.yaml",
            "--set",
            "run.steps=3000",
            "--set",
            "output.fields.mean_over_steps=[0, 0]",
        )
        quarter = self.trajectory_of("quarter", *case)
        whole = self.trajectory_of("whole", *case, "--set", "fluid.symmetry_planes=[]")
        moved = 0.0
        for ours, theirs in zip(rows_of(quarter), rows_of(whole), strict=True):
            for key in ("x_m", "y_m", "z_m"):
                self.assertLess(abs(float(ours[key]) - float(theirs[key])) / 1e-6, 1e-9)
            moved = max(moved, abs(float(ours["vz_m_per_s"])))
        self.assertGreater(moved, 1.0)


def rows_of(trajectory):
    return csv.DictReader(trajectory.read_text().splitlines())


if __name__ == "__main__":
    unittest.main()
