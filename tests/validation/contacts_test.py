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

    def test_sphere_rolls_down_an_incline_in_oil_and_slides_where_there_is_no_friction(self):
        """6πμr V [F_v − F_ω + 4/3 (T_ω − T_v)] is the weight along the incline if it rolls, and T_v V = T_ω ω r if it
        slides, with the resistances of a sphere at a gap of r/100 [Goldman, Cox, Brenner 1967]."""
        F_v, F_w, T_v, T_w = 3.4225, 0.3687, 0.2765, 2.2408
        far = 32 * 4.905 * 4.0e-3**2 * 4 / 3 / (6 * 970 * 1.0e-4)
        slides = far / (F_v - F_w * T_v / T_w)
        rolls = far / (F_v - F_w + 4 / 3 * (T_w - T_v))
        for friction, velocity, turning in ((0.5, rolls, rolls), (0, slides, slides * T_v / T_w)):
            directory = self.run_of("examples/rolling_sphere.yaml", f"contact.friction={friction}")
            last = list(csv.DictReader((directory / "trajectory.csv").read_text().splitlines()))[-1]
            self.assertAlmostEqual(float(last["vx_m_per_s"]) / velocity, 1, delta=0.03)
            self.assertAlmostEqual(float(last["wy_rad_per_s"]) * 4.0e-3 / turning, 1, delta=0.1)

    def test_a_sphere_beside_the_floor_is_refused_without_contacts(self):
        """As before: the run ends with the error of the fluid."""
        self.run_of("examples/sphere_in_a_box.yaml", "contact=null", "lubrication.cut_off_cells=none", code=70)


if __name__ == "__main__":
    unittest.main()
