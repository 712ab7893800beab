"""Guards the speed by ratios: fluid over streams, coupled over fluid. They hold on any machine and beside other work.

The limits are well below the figures in docs/results/performance.md, so that noise does not fail the test, but a lost
vectorisation, a copy of the ghost layer or a sleep in the exchange path does. The best of a few attempts counts.
Of many bodies they are half of what other machines need: where memory is fast, links take more of a step.
"""

import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "deploy"))
os.environ["COPEPOD_BIN_DIR"] = os.environ.get("COPEPOD_BUILT_PROGRAMS", str(ROOT / "build/bin"))

from copepod_bench.bench import PUBLISHED, Setup, measure_coupled, measure_fluid  # noqa: E402

ATTEMPTS = 5


class SpeedRatios(unittest.TestCase):
    def assert_reaches(self, ratio_of_attempt, limit):
        seen = []
        for _ in range(ATTEMPTS):
            seen.append(ratio_of_attempt())
            if seen[-1] >= limit:
                return
        self.fail(f"ratios {[f'{ratio:.2f}' for ratio in seen]}, none reaches {limit}")

    def test_fluid_runs_at_the_speed_of_its_streams(self):
        self.assert_reaches(lambda: max(shares(measure_fluid((60, 60, 120), 1, samples=3))), 0.65)

    def test_single_precision_is_faster(self):
        def ratio():
            single, double = (
                max(measure_fluid((60, 60, 120), 1, precision, samples=3)["fluid_mlups"])
                for precision in ("single", "double")
            )
            return single / double

        self.assert_reaches(ratio, 1.4)

    def test_coupling_costs_little(self):
        for keys, limit in (({}, 0.7), (PUBLISHED, 0.75)):
            with self.subTest(keys=keys):
                self.assert_reaches(lambda: ratio_of((64, 64, 64), 3, keys, steps=400), limit)

    def test_coupling_in_one_process_costs_little_of_a_small_domain(self):
        def ratios():
            with tempfile.TemporaryDirectory() as folder:
                out = Path(folder) / "bench.json"
                command = [str(ROOT / "deploy/copepod"), "bench", "--quick", "--samples", "1", "--out", str(out)]
                subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
                rows = json.loads(out.read_text())["coupled"]
            defaults, published = (row["median_ratio"] for row in rows if row["transport"] == "in_process")
            return min(defaults / 0.55, published / 0.75)

        self.assert_reaches(ratios, 1.0)

    def test_a_thousand_bodies_leave_part_of_the_speed(self):
        for keys, limit in (({}, 0.16), (PUBLISHED, 0.28)):
            with self.subTest(keys=keys):
                self.assert_reaches(lambda: ratio_of((100, 100, 200), 1000, keys, steps=60), limit)


def ratio_of(domain, beads, keys, steps):
    return measure_coupled(Setup(domain, beads, keys=keys), 1, steps, samples=1)["median_ratio"]


def shares(measured):
    return [fluid / limit for fluid, limit in zip(measured["fluid_mlups"], measured["streams_mcells_per_s"])]


if __name__ == "__main__":
    unittest.main()
