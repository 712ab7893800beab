"""Bodies of other shapes than spheres that are far lighter than the fluid come to rest in it.

    light_shapes_test.py --all     all shapes, densities and relaxation times; else every fifth of these points
"""

import itertools
import json
import sys
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests" / "integration"), str(ROOT / "python")]

from copepod_session import WholeRunTest  # noqa: E402
from copepod import Run  # noqa: E402

SHAPES = {
    "prolate": {"shape": "ellipsoid", "semi_axes_m": [4, 4, 8]},
    "oblate": {"shape": "ellipsoid", "semi_axes_m": [6, 6, 2.5]},
    "plate": {"shape": "box", "edges_m": [10, 10, 3]},
    "rod": {"shape": "cylinder", "radius_m": 2, "length_m": 14},
    "cube": {"shape": "box", "edges_m": [7, 7, 7]},
    "dumbbell": {"shape": "compound", "parts": [{"radius_m": 3, "position_m": [0, 0, z]} for z in (-4, 4)]},
    "helix": {"shape": "mesh", "file": str(ROOT / "configs/examples/meshes/helix.obj"), "unit_m": 2.2},
}


POINTS = list(itertools.product(SHAPES, (0.1, 0.01), (0.6, 0.8, 1.5)))  # density of the fluid: 1
ARGUMENTS = []


def case_of(shape, density, tau):
    """In lattice units, with the default schemes, in a periodic cube."""
    fluid = {"solver": "lattice_boltzmann", "density_kg_per_m3": 1, "kinematic_viscosity_m2_per_s": (tau - 0.5) / 3}
    fluid |= {"cell_size_m": 1, "relaxation_time": tau, "domain_cells": [32, 32, 32]}
    body = {"name": "body", **SHAPES[shape], "density_kg_per_m3": density, "position_m": [16.2, 15.7, 16.4]}
    body |= {"orientation_wxyz": [0.8, 0.36, 0.48, 0], "velocity_m_per_s": [0.02, 0.01, -0.01]}
    return {
        "case": "light",
        "fluid": fluid | {"boundaries": dict.fromkeys("xyz", "periodic")},
        "bodies": [body | {"angular_velocity_rad_per_s": [0.003, -0.002, 0.001]}],
        "run": {"steps": 600},
        "output": {"trajectory": {"every_steps": 10}},
        "services": {"transport": "in_process"},
    }


class LightShapes(WholeRunTest):
    def test_come_to_rest_and_are_never_faster_than_at_the_start(self):
        for shape, density, tau in POINTS if "--all" in ARGUMENTS else POINTS[::5]:
            (self.folder / "case.json").write_text(json.dumps(case_of(shape, density, tau)))
            body = Run(self.run_of(self.folder / "case.json")).trajectory.loc["body"]
            for quantity in ("v{}_m_per_s", "w{}_rad_per_s"):
                speeds = np.linalg.norm(body[[quantity.format(axis) for axis in "xyz"]], axis=-1)
                with self.subTest(quantity, shape=shape, density=density, tau=tau):
                    self.assertLessEqual(speeds.max(), speeds[0])
                    self.assertLess(speeds[-1], 0.1 * speeds[0])


if __name__ == "__main__":
    ARGUMENTS, sys.argv[1:] = sys.argv[1:], [word for word in sys.argv[1:] if word != "--all"]
    unittest.main()
