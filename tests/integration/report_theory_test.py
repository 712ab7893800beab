"""Hydrodynamic radii and the theory with them."""

import sys
import unittest

import numpy as np

from copepod_session import ROOT

sys.path[:0] = [str(ROOT / "python"), str(ROOT / "tests/validation")]

from copepod_swimmers.theory import geometrical_factor  # noqa: E402
from hydrodynamic_radii import error_percent, is_drag_case, predicted, radii_of  # noqa: E402

ACROSS = [0.5**0.5, 0, 0.5**0.5, 0]
ALONG = [1, 0, 0, 0]


def drag_in_channel(radius):
    """Drag of a sphere in a channel: Stokes' law and what the walls add [arbitrary units]."""
    return radius / (1 - 0.02 * radius / 1e-6)


def drag_on(shape, radius, drag, length=0.0, orientation=ALONG):
    body = {"shape": shape, "radius_m": radius, "length_m": length, "orientation_wxyz": orientation, "motion": "fixed"}
    return body, drag


class HydrodynamicRadii(unittest.TestCase):
    def setUp(self):
        self.drags = [drag_on("sphere", r * 1e-6, drag_in_channel(r * 1e-6)) for r in (4, 6, 8)]
        self.drags.append(drag_on("capsule", 4e-6, drag_in_channel(5.2e-6), 8e-6))
        self.drags.append(drag_on("capsule", 4e-6, drag_in_channel(5.9e-6), 8e-6, ACROSS))

    def test_a_capsule_has_the_radius_of_the_sphere_with_its_drag(self):
        radii = radii_of(self.drags)
        self.assertAlmostEqual(radii[(4e-6, 8e-6, "parallel")] / 5.2e-6, 1, delta=1e-3)
        self.assertAlmostEqual(radii[(4e-6, 8e-6, "perpendicular")] / 5.9e-6, 1, delta=1e-3)

    def test_without_spheres_to_compare_with_there_are_no_radii(self):
        self.assertEqual(radii_of(self.drags[3:]), {})

    def test_only_a_lone_fixed_body_is_a_drag_case(self):
        self.assertTrue(is_drag_case({"bodies": [self.drags[0][0]], "swimmers": []}))
        self.assertFalse(is_drag_case({"bodies": [], "swimmers": [{}]}))
        self.assertFalse(is_drag_case({"bodies": [{"motion": "fixed"}, {"motion": "free"}], "swimmers": []}))

    def test_prediction_scales_with_the_factor_of_the_measured_radii(self):
        """Against (29) by hand: paper's K of three spheres of radius 6, then of 5.2, 4, 4, arms 16."""
        bead = {"shape": "sphere", "radius_m": 4e-6, "length_m": 0.0, "orientation": "parallel"}
        capsule = {"shape": "capsule", "radius_m": 4e-6, "length_m": 8e-6, "orientation": "parallel"}
        self.assertAlmostEqual(geometrical_factor((4, 4, 4), (16, 16)), 4 / 6 * 1.75 / 256, delta=1e-15)
        figures = {
            "u_GA_lattice": 9e-6,
            "u_swim_lattice": 8e-6,
            "mean_arm_cells": [16, 16],
            "K": geometrical_factor((6, 4, 4), (16, 16)),
        }
        radii = radii_of(self.drags)
        cells, u_GA_measured = predicted([capsule, bead, bead], figures, 1e-6, radii)
        self.assertIsNone(predicted([{**capsule, "length_m": 7e-6}, bead, bead], figures, 1e-6, radii))
        np.testing.assert_allclose(cells, [5.2, 4, 4], rtol=1e-3)
        by_hand = 9e-6 * (5.2 * 16 / 13.2**2) / (6 * 16 / 14**2)
        self.assertAlmostEqual(u_GA_measured / by_hand, 1, delta=1e-3)
        self.assertAlmostEqual(error_percent(figures["u_GA_lattice"], figures["u_swim_lattice"]), 100 / 9, delta=1e-9)


if __name__ == "__main__":
    unittest.main()
