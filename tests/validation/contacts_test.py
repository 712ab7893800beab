"""Bodies in a fluid that meet: they rebound, settle, and come to rest."""

import csv
import json
import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests" / "integration"))

from copepod_session import WholeRunTest  # noqa: E402

RADIUS_M = 7.5e-3


class Contacts(WholeRunTest):
    def rows_of(self, *settings):
        self.directory = self.run_of("examples/sphere_in_a_box.yaml", *settings)
        return list(csv.DictReader((self.directory / "trajectory.csv").read_text().splitlines()))

    def digest(self):
        return json.loads((self.directory / "summary.json").read_text())["digest"]

    def test_settling_sphere_comes_to_rest_on_the_floor(self):
        """The sphere of ten Cate's experiment E1, with films and without."""
        for lubrication in ("auto", "none"):
            rows = self.rows_of(f"lubrication.cut_off_cells={lubrication}")
            gaps = [float(row["z_m"]) / RADIUS_M - 1 for row in rows]
            self.assertGreater(gaps[0], 1)
            self.assertLess(abs(gaps[-1]), 0.01)
            self.assertGreater(min(gaps), -0.02)
            fastest = max(abs(float(row["vz_m_per_s"])) for row in rows)
            self.assertGreater(fastest, 0.01)
            self.assertLess(abs(float(rows[-1]["vz_m_per_s"])), 0.01 * fastest)
            self.assertLess(max(float(row["vz_m_per_s"]) for row in rows), 0.5 * fastest)

    def test_a_sphere_beside_the_floor_is_refused_without_contacts(self):
        """As before: the run ends with the error of the fluid."""
        self.run_of("examples/sphere_in_a_box.yaml", "contact=null", "lubrication.cut_off_cells=none", code=70)


if __name__ == "__main__":
    unittest.main()
