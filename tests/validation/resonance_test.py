"""The paper's resonance curve: a million steps in vacuum against the exact solution, to ten digits."""

import csv
import json
import os
import sys
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests" / "integration"))

from copepod_session import PROGRAMS, WholeRunTest  # noqa: E402
from copepod_swimmers.vacuum import VacuumSwimmer  # noqa: E402

os.environ["COPEPOD_BIN_DIR"] = str(PROGRAMS)
sys.path.insert(0, str(ROOT / "python"))
from resonance import main, points_of  # noqa: E402

REFERENCE = ROOT / "tests/reference"
STEP_S = 7.548309999899218e-10
MASS_KG = 5.44e-13


def rows_of(path):
    return list(csv.DictReader(path.read_text().splitlines()))


class ModalSolution(unittest.TestCase):
    """Our own evaluation against numbers that were computed independently."""

    def test_is_the_reference_trajectory(self):
        swimmer = VacuumSwimmer(MASS_KG, 1.72965, 1.57237e-7, 1e-5, 28116, 7029, 5, STEP_S)
        rows = rows_of(REFERENCE / "vacuum_trajectory.csv")
        ours = swimmer.displacements_m([int(row["step"]) for row in rows]) / 1e-6
        theirs = [
            [float(row[f"z_{bead}_cells"]) - rest for row in rows]
            for bead, rest in (("B2", 25), ("B1", 50), ("B3", 75))
        ]
        self.assertLess(np.abs(ours - theirs).max(), 1e-12)

    def test_has_the_reference_amplitudes_when_it_is_steady(self):
        for row in rows_of(REFERENCE / "vacuum_resonance.csv"):
            swimmer = VacuumSwimmer(
                MASS_KG, float(row["stiffness_N_per_m"]), float(row["damping_N_s_per_m"]), 1.0, 28116, 7029, 36, STEP_S
            )
            self.assertAlmostEqual(swimmer.frequency_ratio, float(row["omega0_over_omega"]), delta=1e-8)
            expected = float(row["amplitude_B2_over_force_m_per_N"])
            self.assertAlmostEqual(swimmer.steady_amplitude_m(0) / expected, 1, delta=1e-12)


class Resonance(WholeRunTest):
    def test_softest_resonant_and_stiffest_swimmer_have_ten_digits_after_a_million_steps(self):
        reference = rows_of(REFERENCE / "vacuum_resonance.csv")
        chosen = [reference[0], reference[18], reference[37]]
        values = ", ".join(row["stiffness_N_per_m"] for row in chosen)
        sweep = self.run_of(
            "paper/resonance.yaml", f"sweep.parameters={{swimmers.0.spring.stiffness_N_per_m: [{values}]}}"
        )
        points = points_of(sweep)
        self.assertEqual(len(points), 3)
        for point, row in zip(points, chosen):
            self.assertLess(point.deviation, 1e-10)
            left = float(row["transient_left_after_1e6_steps"])
            self.assertLess(point.steady_deviation, 10 * left + 1e-10)
        self.assertGreater(points[0].steady_deviation, 0.01)  # the comparison sees transients
        main(sweep, self.folder / "resonance.png")
        self.assertTrue((self.folder / "resonance.png").exists())

    def test_one_process_computes_the_same_bits_as_three(self):
        digests = set()
        for transport in ("ipc", "in_process"):
            run = self.run_of("quick/vacuum.yaml", f"services.transport={transport}")
            digests.add(json.loads((run / "summary.json").read_text())["digest"])
        self.assertEqual(len(digests), 1, digests)


if __name__ == "__main__":
    unittest.main()
