"""Whole runs of bodies with joints: a pendulum, a swimmer of a given stroke, and links that overlap in the lattice."""

import csv
import json
import sys
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests" / "integration"), str(ROOT / "deploy")]

from copepod_session import WholeRunTest  # noqa: E402
from copepod_swimmers.theory import Stroke, small_stroke_velocity  # noqa: E402

SETTLING = """
case: settling
fluid: {solver: stokes, density_kg_per_m3: 1000, kinematic_viscosity_m2_per_s: 1.0e-6, cell_size_m: 1.0e-6}
step_s: 1.0e-7
body: {solver: mujoco, model: {file: bead.xml, length_m: 1.0e-6, mass_kg: 1.0e-15, time_s: 1.0e-6}}
gravity_m_per_s2: [0, 0, -9.81]
run: {steps: 2000}
output: {trajectory: {every_steps: 2000}}
"""

BEAD = (
    '<mujoco><option%s</option><worldbody><body pos="0 0 0"><freejoint/>'
    '<geom name="bead" type="sphere" size="4" density="2"/></body></worldbody></mujoco>'
)

PENDULUM = """
case: pendulum
fluid: {solver: vacuum}
step_s: 5.0e-5
bodies: [{name: bob, radius_m: 4.0e-3, mass_kg: 1.0e-3, position_m: [0.02, 0, 0]}]
joints: [{name: hook, kind: hinge, bodies: [bob, world], anchor_m: [0, 0, 0], axis: [0, 1, 0]}]
gravity_m_per_s2: [0, 0, -9.81]
run: {steps: 1000}
"""

HINGE = """
case: hinge
fluid:
  solver: lattice_boltzmann
  density_kg_per_m3: 1360
  kinematic_viscosity_m2_per_s: 7.36e-5
  cell_size_m: 1.0e-6
  relaxation_time: 1
  domain_cells: [56, 24, 24]
bodies:
  - &link
    name: body
    shape: capsule
    radius_m: 3.0e-6
    length_m: 10.0e-6
    mass_kg: 5.0e-13
    position_m: [28.0e-6, 12.0e-6, 12.0e-6]
    orientation_wxyz: [0.7071067811865476, 0, 0.7071067811865476, 0]
  - {<<: *link, name: rear, position_m: [18.0e-6, 12.0e-6, 12.0e-6]}
joints:
  - name: hinge
    kind: hinge
    bodies: [rear, body]
    anchor_m: [23.0e-6, 12.0e-6, 12.0e-6]
    axis: [0, 1, 0]
    signal: {kind: sinusoid, amplitude_rad: 0.3, period_steps: 100}
run: {steps: 150}
output: {trajectory: {every_steps: 50}, checkpoint: {every_steps: 100}}
services: {transport: in_process}
"""


def pendulum_rad(time_s, parts=20000):
    """Angle from the horizontal of a sphere on a massless rod, released there: φ̈ = g l cos φ / (l² + 2 r²/5)."""
    length_m, radius_m = 0.02, 4.0e-3
    rate = 9.81 * length_m / (length_m**2 + 0.4 * radius_m**2)
    step, y = time_s / parts, np.zeros(2)

    def slope(state):
        return np.array([state[1], rate * np.cos(state[0])])

    for _ in range(parts):
        k1 = slope(y)
        k2 = slope(y + step / 2 * k1)
        k3 = slope(y + step / 2 * k2)
        y = y + step / 6 * (k1 + 2 * k2 + 2 * k3 + slope(y + step * k3))
    return y[0]


class Joints(WholeRunTest):
    def rows_of(self, directory, body):
        rows = csv.DictReader((directory / "trajectory.csv").read_text().splitlines())
        return [row for row in rows if row["body"] == body]

    def summary_of(self, directory):
        return json.loads((directory / "summary.json").read_text())

    def test_pendulum_is_where_its_equation_has_it_however_the_parts_are_connected(self):
        case = self.folder / "pendulum.yaml"
        case.write_text(PENDULUM)
        runs = [self.run_of(case, f"services.transport={transport}") for transport in ("ipc", "in_process")]
        self.assertEqual(*(self.summary_of(run)["digest"] for run in runs))
        end, angle = self.rows_of(runs[0], "bob")[-1], pendulum_rad(0.05)
        # Runge-Kutta of fourth order with 3000 steps in a period.
        self.assertAlmostEqual(float(end["x_m"]), 0.02 * np.cos(angle), delta=1e-11)
        self.assertAlmostEqual(float(end["z_m"]), -0.02 * np.sin(angle), delta=1e-11)

    def test_swimmer_of_a_given_stroke_swims_as_theory_has_it(self):
        """Against the same stroke integrated with Rotne and Prager's mobility, and against the leading order."""
        radius, stroke, period = 4.0, 8.0, 20000
        phase = 2 * np.pi * np.arange(64) / 64
        for arm, of_leading_order in ((80.0, 0.05), (200.0, 0.03)):
            run = self.run_of(
                "examples/prescribed_stroke.yaml",
                f"bodies.rear.position_m=[0, 0, {-arm}e-6]",
                f"bodies.front.position_m=[0, 0, {arm - stroke}e-6]",
                f"run.steps={2 * period}",
            )
            found = self.summary_of(run)["groups"][0]["kinematics"]["u_along_cells_per_step"]
            arms = np.array([arm + stroke * np.sin(phase), arm - stroke * np.cos(phase)])
            places = np.array([[0, 0, -arm], [0, 0, 0], [0, 0, arm - stroke]])
            moved = Stroke(places, np.full(3, radius), ((0, 1), (1, 2)), arms).motion(parts=60)
            finite = (moved[1] - moved[0])[:, 2].mean() / period
            self.assertAlmostEqual(found / finite, 1, delta=1e-4)
            leading = small_stroke_velocity([radius] * 3, arms, period)
            self.assertAlmostEqual(found / leading, 1, delta=of_leading_order)

    def test_links_that_overlap_in_the_lattice_turn_as_they_are_told(self):
        case, steps = "examples/three_link_swimmer.yaml", 300
        runs = [
            self.run_of(
                case, f"run.steps={steps}", f"services.fluid.ranks={ranks}", "output.trajectory.every_steps=300"
            )
            for ranks in (1, 2)
        ]
        self.assertEqual(*(self.summary_of(run)["digest"] for run in runs))
        poses = {name: self.rows_of(runs[0], name)[-1] for name in ("front", "body", "rear")}
        axes, places = {}, {}
        for name, row in poses.items():
            w, x, y, z = (float(row[key]) for key in ("qw", "qx", "qy", "qz"))
            axes[name] = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
            places[name] = np.array([float(row[key]) for key in ("x_m", "y_m", "z_m")])
        turns = 2 * np.pi * steps / 2000
        for link, side, angle in (("front", 1, np.sin(turns - np.pi / 2)), ("rear", -1, np.sin(turns))):
            across = np.cross(axes["body"], axes[link])[1]
            self.assertAlmostEqual(np.arcsin(across), 0.7 * angle, delta=1e-9)
            gap = places["body"] - places[link] + side * 8e-6 * (axes["body"] + axes[link])
            self.assertLess(np.linalg.norm(gap), 1e-16)

    def test_links_that_overlap_go_on_from_a_checkpoint_as_if_they_had_not_stopped(self):
        case = self.folder / "hinge.yaml"
        case.write_text(HINGE)
        undisturbed = self.run_of(case)
        self.finish("run", case, "--branch-from", f"{undisturbed}:100", "--out", "branch", "--ranks", "3")
        self.assertEqual(self.summary_of(self.folder / "branch")["digest"], self.summary_of(undisturbed)["digest"])

    def test_a_model_of_mujoco_settles_in_the_fluid_and_the_gravity_of_the_case(self):
        case = self.folder / "settling.yaml"
        case.write_text(SETTLING)
        stokes_m_per_s = -2 / 9 * 1000 * 9.81 * 4e-6**2 / 1e-3
        for option in (">", ' density="1" viscosity="1">', '><flag gravity="disable"/>', ' wind="9 0 0" density="9">'):
            (self.folder / "bead.xml").write_text(BEAD % option)
            row = self.rows_of(self.run_of(case, "services.transport=ipc"), "bead")[-1]
            self.assertAlmostEqual(float(row["vz_m_per_s"]), stokes_m_per_s, delta=1e-9)
        (self.folder / "bead.xml").write_text(BEAD % ' integrator="RK4">')
        self.assertIn("the model's integrator is RK4", "".join(self.finish("check", case, code=2).stderr))

    def test_a_model_of_mujoco_moves_as_the_same_links_with_our_joints(self):
        places = {}
        for case in ("three_link_swimmer", "three_link_mjcf"):
            settings = ("run.steps=300", "output.trajectory.every_steps=300", "services.transport=ipc")
            run = self.run_of(f"examples/{case}.yaml", *settings)
            rows = [self.rows_of(run, name) for name in ("front", "body", "rear")]
            places[case] = np.array([[[float(row[f"{axis}_m"]) for axis in "xyz"] for row in each] for each in rows])
        ours, theirs = places["three_link_swimmer"], places["three_link_mjcf"]
        np.testing.assert_allclose(theirs[:, 0], ours[:, 0], atol=1e-15)
        moved = np.linalg.norm(ours[:, -1] - ours[:, 0], axis=1)
        off = np.linalg.norm(theirs[:, -1] - ours[:, -1], axis=1)
        self.assertLess(off.max(), 0.02 * moved.max())  # 0.34 %


if __name__ == "__main__":
    unittest.main()
