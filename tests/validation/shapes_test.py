"""Bodies and obstacles of other shapes than spheres: as meshes of spheres, as compounds, light, chiral, tumbling.

    shapes_test.py --all     all light bodies, and longer runs; half an hour
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

HELIX = ROOT / "configs/examples/meshes/helix.obj"
SHAPES = {
    "prolate": {"shape": "ellipsoid", "semi_axes_m": [4, 4, 8]},
    "oblate": {"shape": "ellipsoid", "semi_axes_m": [6, 6, 2.5]},
    "plate": {"shape": "box", "edges_m": [10, 10, 3]},
    "rod": {"shape": "cylinder", "radius_m": 2, "length_m": 14},
    "cube": {"shape": "box", "edges_m": [7, 7, 7]},
    "dumbbell": {"shape": "compound", "parts": [{"radius_m": 3, "position_m": [0, 0, z]} for z in (-4, 4)]},
    "helix": {"shape": "mesh", "file": str(HELIX), "unit_m": 2.2},
}
TUMBLING = {  # of one volume
    "sphere": {"radius_m": 4.857},
    "ellipsoid": {"shape": "ellipsoid", "semi_axes_m": [4.963, 6.204, 3.722]},
    "box": {"shape": "box", "edges_m": [8, 10, 6]},
    "cylinder": {"shape": "cylinder", "radius_m": 3.909, "length_m": 10},
}
TURNED = [0.8, 0.36, 0.48, 0]  # unit quaternion
LIGHT = list(itertools.product(SHAPES, (0.1, 0.01), (0.6, 0.8, 1.5)))  # density of the fluid: 1; relaxation time
ARGUMENTS = []


def sphere_mesh(divisions):
    """Vertices and triangles of an icosahedron whose triangles are cut into four, projected on the unit sphere."""
    golden = (1 + 5**0.5) / 2
    corners = [(0, s, t * golden) for s in (-1, 1) for t in (-1, 1)]
    vertices = [np.roll(corner, turn) for turn in range(3) for corner in np.array(corners)]
    near = [[0 < np.linalg.norm(a - b) < 2.1 for b in vertices] for a in vertices]
    triangles = [
        t for t in itertools.combinations(range(12), 3) if all(near[a][b] for a, b in itertools.pairwise(t + t[:1]))
    ]
    triangles = [t if np.linalg.det([vertices[i] for i in t]) > 0 else t[::-1] for t in triangles]
    vertices = [vertex / np.linalg.norm(vertex) for vertex in vertices]
    for _ in range(divisions):
        middles, cut = {}, []
        for a, b, c in triangles:
            ab, bc, ca = (_middle(vertices, middles, *edge) for edge in ((a, b), (b, c), (c, a)))
            cut += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        triangles = cut
    return np.array(vertices), np.array(triangles)


def _middle(vertices, known, a, b):
    key = min(a, b), max(a, b)
    if key not in known:
        known[key] = len(vertices)
        vertices.append((vertices[a] + vertices[b]) / np.linalg.norm(vertices[a] + vertices[b]))
    return known[key]


def obj(vertices, triangles):
    lines = ["v {!r} {!r} {!r}".format(*map(float, vertex)) for vertex in vertices]
    return "\n".join([*lines, *("f {} {} {}".format(*corners) for corners in np.array(triangles) + 1)]) + "\n"


def mirrored(text):
    """The OBJ of a mesh at z → −z."""
    words = [line.split() for line in text.splitlines()]
    turn = {"v": lambda x, y, z: f"v {x} {y} {-float(z)!r}", "f": lambda a, b, c: f"f {a} {c} {b}"}
    return "\n".join(turn[kind](*rest) for kind, *rest in words) + "\n"


class Shapes(WholeRunTest):
    def run_in(self, domain, tau, steps, boundaries="periodic", every=1, fluid=None, **keys):
        """A case in lattice units with the default schemes."""
        number = len(list(self.folder.glob("*.json")))
        fluid = {"kinematic_viscosity_m2_per_s": (tau - 0.5) / 3, "relaxation_time": tau} | (fluid or {})
        fluid |= {"solver": "lattice_boltzmann", "density_kg_per_m3": 1, "cell_size_m": 1, "domain_cells": domain}
        boundaries = dict.fromkeys("xyz", boundaries) if isinstance(boundaries, str) else boundaries
        case = {"case": "shapes", "fluid": fluid | {"boundaries": boundaries}, **keys}
        case |= {"run": {"steps": steps}, "services": {"transport": "in_process"}}
        case.setdefault("output", {"trajectory": {"every_steps": every}})
        file = self.folder / f"case{number}.json"
        file.write_text(json.dumps(case))
        return Run(self.run_of(file))

    def test_light_bodies_come_to_rest_and_are_never_faster_than_at_the_start(self):
        motion = {"velocity_m_per_s": [0.02, 0.01, -0.01], "angular_velocity_rad_per_s": [0.003, -0.002, 0.001]}
        for shape, density, tau in LIGHT if "--all" in ARGUMENTS else LIGHT[::5]:
            body = {"name": "body", **SHAPES[shape], "density_kg_per_m3": density, "position_m": [16.2, 15.7, 16.4]}
            body |= {"orientation_wxyz": TURNED, **motion}
            found = self.run_in([32, 32, 32], tau, 600, every=10, bodies=[body]).trajectory.loc["body"]
            for quantity in ("v{}_m_per_s", "w{}_rad_per_s"):
                speeds = np.linalg.norm(found[[quantity.format(axis) for axis in "xyz"]], axis=-1)
                with self.subTest(quantity, shape=shape, density=density, tau=tau):
                    self.assertLessEqual(speeds.max(), speeds[0])
                    self.assertLess(speeds[-1], 0.1 * speeds[0])

    def test_a_sphere_of_triangles_has_the_drag_of_the_sphere_to_the_second_order_of_their_edges(self):
        """Measured: −3.0, −0.82 and −0.20 %, of triangles whose corners are on the sphere."""

        def drag(**shape):
            body = {"name": "body", **shape, "position_m": [12.3, 11.9, 12.1], "mass_kg": 1, "motion": "prescribed"}
            body |= {"velocity_m_per_s": [0, 0, 1e-6]}
            run = self.run_in([24, 24, 24], 1.0, 400, "no_slip", bodies=[body], coupling={"load_averaging": "none"})
            return run.trajectory.loc["body"]["fz_N"].iloc[-1]

        exact = drag(radius_m=5.2)
        text = [obj(*sphere_mesh(divisions)) for divisions in (2, 3, 4)]  # 320, 1280, 5120 triangles
        errors = [100 * (drag(shape="mesh", text=mesh, unit_m=5.2) / exact - 1) for mesh in text]
        self.assertLess(abs(errors[2]), 0.2)
        for coarse, fine in itertools.pairwise(errors):
            self.assertAlmostEqual(coarse / fine, 4, delta=1)

    def test_a_compound_of_one_sphere_is_that_sphere(self):
        place = {"name": "body", "position_m": [8.3, 7.9, 8.1], "mass_kg": 400, "velocity_m_per_s": [0.01, 0, 0.003]}
        digests = {
            self.run_in([16, 16, 16], 0.8, 200, bodies=[place | shape]).summary["digest"]
            for shape in ({"radius_m": 3.3}, {"shape": "compound", "parts": [{"radius_m": 3.3}]})
        }
        self.assertEqual(len(digests), 1)

    def test_a_packing_lets_as_much_fluid_through_as_one_mesh_as_it_does_as_spheres(self):
        """Measured: −0.001 %; +0.29 % of meshes with their corners on the spheres."""
        random, centres = np.random.default_rng(2), []
        while len(centres) < 12:
            centre = 32 * random.random(3)
            apart = [np.linalg.norm((centre - other + 16) % 32 - 16) for other in centres]
            if min(apart, default=32) > 11.5:
                centres.append(centre)
        vertices, triangles = sphere_mesh(4)
        vertices *= np.cbrt(4 / 3 * np.pi / (np.linalg.det(vertices[triangles]).sum() / 6))  # the sphere's volume
        packing = obj(
            np.concatenate([5 * vertices + centre for centre in centres]),
            np.concatenate([triangles + i * len(vertices) for i in range(len(centres))]),
        )
        spheres = [
            {"name": f"s{i}", "radius_m": 5, "position_m": centre.tolist(), "mass_kg": 1, "motion": "fixed"}
            for i, centre in enumerate(centres)
        ]
        mesh = {"name": "packing", "shape": "mesh", "text": packing, "position_m": [0, 0, 0], "unit_m": 1}

        def velocity(**keys):
            keys |= {"output": {"fields": {"every_steps": 600}}, "lubrication": {"cut_off_cells": 0}}
            flow = {"body_force_N_per_m3": [0, 0, 1e-7]}
            run = self.run_in([32, 32, 32], 1.0, 600, fluid=flow, **keys)
            fields = run.fields.isel(time=-1)
            momentum = fields["density_kg_per_m3"] * fields["velocity_m_per_s"][..., 2]
            return float(momentum.where(fields["body"] == 0).sum())

        error = 100 * (velocity(obstacles=[mesh]) / velocity(bodies=spheres) - 1)
        self.assertLess(abs(error), 0.05)

    def test_an_obstacle_is_the_same_wherever_the_origin_of_its_frame_is(self):
        """And although it reaches through faces, further than half of the domain from there."""
        vertices, triangles = sphere_mesh(1)
        fields, flow = {"fields": {"every_steps": 200}}, {"body_force_N_per_m3": [1e-6, 0, 2e-6]}
        digests = set()
        for shift in ([0, 0, 0], [13, 0, -9], [0, 16, 64]):
            text = obj(6.3 * vertices + shift, triangles)
            place = (np.array([4.1, 8.3, 2.7]) - shift).tolist()
            obstacle = {"name": "rock", "shape": "mesh", "text": text, "position_m": place, "unit_m": 1}
            run = self.run_in([16, 18, 20], 0.8, 200, fluid=flow, obstacles=[obstacle], output=fields)
            digests.add(run.summary["digest"])
        self.assertEqual(len(digests), 1)

    def test_obstacles_feel_what_bodies_in_their_place_feel(self):
        """And altogether what drives the fluid, once it is steady."""
        places = {"one": [5.3, 8.1, 9.2], "two": [11.2, 2.4, 3.1]}
        flow, still = {"body_force_N_per_m3": [1e-6, 0, 2e-6]}, {"load_averaging": "none"}
        still = {"coupling": still, "lubrication": {"cut_off_cells": 0}}
        balls = [{"name": name, "radius_m": 3, "position_m": place} for name, place in places.items()]
        bodies = [ball | {"mass_kg": 1, "motion": "fixed"} for ball in balls]
        as_bodies = self.run_in([16, 16, 16], 1.0, 600, fluid=flow, bodies=bodies, **still)
        as_obstacles = self.run_in(
            [16, 16, 16], 1.0, 600, fluid=flow, obstacles=[balls[0], balls[1] | {"loads": True}], **still
        )
        np.testing.assert_array_equal(as_obstacles.obstacles.loc["two"], as_bodies.trajectory.loc["two"])
        obstacles = [ball | {"loads": True} for ball in balls]
        both = self.run_in([16, 16, 16], 1.0, 600, fluid=flow, obstacles=obstacles, **still).obstacles
        force = sum(both.loc[name][["fx_N", "fy_N", "fz_N"]].iloc[-1].to_numpy() for name in places)
        solid = 2 * 4 / 3 * np.pi * 27
        np.testing.assert_allclose(force, [(16**3 - solid) * f for f in (1e-6, 0, 2e-6)], rtol=0.01, atol=2e-5)

    def test_films_of_ellipsoids_exert_what_finer_cells_do_without_films(self):
        """Semi-axes of 1, 1, 2 at a gap of 0.2 from a wall: 0.8 of a cell, or two of the finer ones. Drag towards and
        along the wall over 6πμV, and the torque of both over the drag, by tilt; of the finer cells as --all finds."""
        finer = {0.0: (4.6203, 0.0, -2.4219, 0.2233), 0.7: (6.3425, 0.3773, -2.3609, 0.1970)}
        finer |= {np.pi / 2: (15.2349, 0.0, -2.5499, -0.1769)}

        def loads(cells, tilt, cut_off):
            height = 0.2 + np.hypot(np.sin(tilt), 2 * np.cos(tilt))
            body = {"name": "body", "shape": "ellipsoid", "semi_axes_m": [cells, cells, 2 * cells], "mass_kg": 1}
            body |= {"position_m": [5 * cells, 5 * cells, height * cells], "motion": "prescribed"}
            body |= {"orientation_wxyz": [np.cos(tilt / 2), 0, np.sin(tilt / 2), 0]}
            domain, steps = [10 * cells, 10 * cells, 6 * cells], int(3000 * (cells / 4) ** 1.5)
            walls = ({"x": "periodic", "y": "free_slip", "z": "no_slip"},)
            found = []
            for component, velocity in ((2, [0, 0, -1e-9]), (0, [1e-9, 0, 0])):
                bodies = [body | {"velocity_m_per_s": velocity}]
                rest = {
                    "bodies": bodies,
                    "lubrication": {"cut_off_cells": cut_off},
                    "fluid": {"symmetry_planes": ["y"]},
                }
                run = self.run_in(domain, 1.0, steps, *walls, every=steps // 2, **rest).trajectory.loc["body"].iloc[-1]
                drag = run[f"f{'xyz'[component]}_N"] / (np.pi * cells * 1e-9)  # 6 μ = 1
                found += [drag, run["ty_N_m"] / (np.pi * cells**2 * 1e-9) / abs(drag)]
            return np.array(found)

        for tilt, expected in finer.items():
            with self.subTest(tilt=tilt):
                if "--all" in ARGUMENTS:
                    np.testing.assert_allclose(loads(10, tilt, "none"), expected, rtol=0.001, atol=0.001)
                errors = loads(4, tilt, "auto") - expected
                np.testing.assert_array_less(np.abs(errors[::2] / np.array(expected)[::2]), 0.03)
                np.testing.assert_array_less(np.abs(errors[1::2]), 0.04)

    def test_a_helix_swims_by_its_handedness(self):
        """Mirrored along its axis, it swims as fast the other way."""
        helix = HELIX.read_text()
        torque = {"kind": "body_torque", "body": "screw", "direction": [0, 0, 1]}
        torque["signal"] = {"kind": "constant", "amplitude_N_m": 0.05}
        velocities = []
        for text in (helix, mirrored(helix)):
            body = {"name": "screw", "shape": "mesh", "text": text, "unit_m": 2, "density_kg_per_m3": 1}
            body["position_m"] = [16, 16, 24]
            run = self.run_in([32, 32, 48], 0.8, 500, every=10, bodies=[body], actuators=[torque])
            velocities.append(run.trajectory.loc["screw"]["vz_m_per_s"].to_numpy())
        self.assertGreater(velocities[0][-1], 1e-6)
        np.testing.assert_allclose(velocities[1], -velocities[0], atol=1e-9 * velocities[0][-1])

    def drift_of_a_tumbling(self, shape, position, orientation=(1, 0, 0, 0), steps=1000):
        """Momentum from no body, by the impulses of a body that is thrown into a periodic box, in per cent."""
        body = {"name": "body", **shape, "density_kg_per_m3": 2, "position_m": list(position)}
        body |= {"velocity_m_per_s": [0.01, 0.004, -0.007], "angular_velocity_rad_per_s": [0.003, -0.004, 0.002]}
        body["orientation_wxyz"] = list(orientation)
        return 100 * self.run_in([24, 24, 24], 0.8, steps, every=100, bodies=[body]).summary["momentum_drift"]

    def test_momentum_drifts_as_for_spheres_unless_faces_are_along_the_lattice(self):
        """Median (root mean square) of 24 places and orientations, of shapes of one volume: sphere 0.39 (0.44),
        ellipsoid 0.37 (0.55), box 0.45 (0.58), cylinder 0.37 (0.52) %; along the lattice 1.5 (1.8), 1.1 (1.4) %."""
        random, drifts = np.random.default_rng(1), {}
        for _ in range(24 if "--all" in ARGUMENTS else 6):
            orientation, position = random.normal(size=4), 12 + random.random(3)
            for name, shape in TUMBLING.items():
                start = position, orientation / np.linalg.norm(orientation)
                drifts.setdefault(name, []).append(self.drift_of_a_tumbling(shape, *start))
                if name in ("box", "cylinder"):
                    drifts.setdefault(name + " along the lattice", []).append(self.drift_of_a_tumbling(shape, position))
        means = {name: np.sqrt(np.mean(np.square(found))) for name, found in drifts.items()}
        if "--all" in ARGUMENTS:
            print({name: (round(np.median(found), 2), round(means[name], 2)) for name, found in drifts.items()})
        for name, mean in means.items():
            with self.subTest(name):
                self.assertLess(mean, 2.5 if "lattice" in name else 1)
                self.assertGreater(mean, 0.2)

    def test_all_drift_of_momentum_is_from_the_time_in_which_a_body_comes_to_rest(self):
        """Beside the fluid, with which it then moves on: measured 1.32 and 1.33 % after 10³ and 10⁵ steps."""
        start, steps = (12.2, 11.7, 12.4), 100_000 if "--all" in ARGUMENTS else 10_000
        drifts = [self.drift_of_a_tumbling(TUMBLING["box"], start, steps=n) for n in (1000, steps)]
        self.assertAlmostEqual(*drifts, delta=0.05)
        self.assertGreater(drifts[0], 1)


if __name__ == "__main__":
    ARGUMENTS, sys.argv[1:] = sys.argv[1:], [word for word in sys.argv[1:] if word != "--all"]
    unittest.main()
