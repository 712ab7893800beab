"""Stokes flow without inertia: bodies whose mass is lost in drag within a step, against their own quasi-static motion.

    overdamped_test.py --table     prints the table of docs/results/stokes.md
"""

import csv
import json
import sys
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests" / "integration"), str(ROOT / "deploy")]

from copepod_session import WholeRunTest  # noqa: E402
from copepod_swimmers.theory import mobility  # noqa: E402

# Beads of 4 µm in water, on springs that yield in a twentieth of the period.
RADIUS_M, VISCOSITY_PA_S, PERIOD_S, LENGTH_M, AMPLITUDE_M, STEPS, CYCLES = 4e-6, 1e-3, 2e-2, 16e-6, 2e-6, 2000, 4
DRAG_KG_PER_S = 6 * np.pi * VISCOSITY_PA_S * RADIUS_M
STIFFNESS_N_PER_M = 20 * DRAG_KG_PER_S / PERIOD_S

SPRING = f"{{stiffness_N_per_m: {STIFFNESS_N_PER_M}, damping_N_s_per_m: 0, rest_gap_m: {LENGTH_M - 2 * RADIUS_M}}}"
SWIMMER = f"""
case: overdamped
fluid: {{solver: stokes, density_kg_per_m3: 1000, kinematic_viscosity_m2_per_s: 1.0e-6, cell_size_m: 1.0e-6}}
step_s: {PERIOD_S / STEPS}
swimmers:
  - name: swimmer
    center_m: [0, 0, 0]
    axis: [0, 0, 1]
    beads: [&bead {{name: a, radius_m: {RADIUS_M}, mass_kg: 2.7e-13}}, {{<<: *bead, name: b}}, {{<<: *bead, name: c}}]
    arms:
      - &arm
        beads: [a, b]
        spring: {SPRING}
        drive: {{kind: rest_length, signal: {{kind: sinusoid, amplitude_m: {AMPLITUDE_M}, period_steps: {STEPS}}}}}
      - beads: [b, c]
        spring: {SPRING}
        drive:
          kind: rest_length
          signal: {{kind: sinusoid, amplitude_m: {AMPLITUDE_M}, period_steps: {STEPS}, lag_deg: 90}}
run: {{steps: {CYCLES * STEPS}}}
output: {{trajectory: {{every_steps: 500}}, checkpoint: {{every_steps: 3000}}}}
"""

BALL = f"""
case: ball
fluid: {{solver: stokes, density_kg_per_m3: 1000, kinematic_viscosity_m2_per_s: 1.0e-6, cell_size_m: 1.0e-6}}
step_s: 1.0e-5
bodies: [{{name: ball, radius_m: {RADIUS_M}, mass_kg: 5.4e-13, position_m: [0, 0, 0]}}]
gravity_m_per_s2: [0, 0, -9.81]
actuators:
  - {{kind: world_torque, body: ball, direction: [0, 1, 0], signal: {{kind: constant, amplitude_N_m: 1.0e-18}}}}
run: {{steps: 50}}
output: {{trajectory: {{every_steps: 50}}}}
"""


def quasi_static_speed():
    """Along the swimmer, in its last cycle, where the forces of the springs move the beads at once [m/s]."""

    def velocity(time_s, place_m):
        phases = 2 * np.pi * time_s / PERIOD_S - np.array([0, np.pi / 2])
        tension_N = STIFFNESS_N_PER_M * (np.diff(place_m) - LENGTH_M - AMPLITUDE_M * np.sin(phases))
        places = np.zeros((3, 3))
        places[:, 2] = place_m
        along = mobility(places, np.full(3, RADIUS_M)).reshape(3, 3, 3, 3)[:, 2, :, 2] / VISCOSITY_PA_S
        return along @ np.array([tension_N[0], tension_N[1] - tension_N[0], -tension_N[1]])

    place_m, step_s, centres_m = LENGTH_M * np.array([-1.0, 0.0, 1.0]), PERIOD_S / STEPS, []
    for step in range(CYCLES * STEPS):  # Runge-Kutta, fourth order
        if step % STEPS == 0:
            centres_m.append(place_m.mean())
        time_s = step * step_s
        first = velocity(time_s, place_m)
        second = velocity(time_s + step_s / 2, place_m + step_s / 2 * first)
        third = velocity(time_s + step_s / 2, place_m + step_s / 2 * second)
        last = velocity(time_s + step_s, place_m + step_s * third)
        place_m = place_m + step_s / 6 * (first + 2 * second + 2 * third + last)
    return (place_m.mean() - centres_m[-1]) / PERIOD_S


def mass_kg(ratio):
    """Of a bead that loses its momentum in 1/ratio of a step."""
    return DRAG_KG_PER_S * PERIOD_S / STEPS / ratio


class Overdamped(WholeRunTest):
    def case(self, text):
        path = self.folder / "case.yaml"
        path.write_text(text)
        return path

    def speed_of(self, ratio, *settings):
        masses = [f"swimmers.0.beads.{bead}.mass_kg={mass_kg(ratio)}" for bead in range(3)]
        out = self.run_of(self.case(SWIMMER), *masses, *settings)
        with open(out / "cycles.csv") as file:
            return float(list(csv.DictReader(file))[-1]["u_along_m_per_s"])

    def digest_of(self, out):
        return json.loads((out / "summary.json").read_text())["digest"]

    def test_swimmer_has_the_speed_of_its_limit_however_light_its_beads_are(self):
        limit = quasi_static_speed()
        for ratio in (0.3, 2.8, 1e2, 1e4):
            with self.subTest(ratio=ratio):
                speed = self.speed_of(ratio)
                self.assertAlmostEqual(speed / limit, 1.0, delta=0.005)

    def test_error_is_that_of_the_step(self):
        limit = quasi_static_speed()
        errors = []
        for steps in (STEPS, 2 * STEPS):
            signals = [f"swimmers.0.arms.{arm}.drive.signal.period_steps={steps}" for arm in (0, 1)]
            length = [f"step_s={PERIOD_S / steps}", f"run.steps={CYCLES * steps}", "output.checkpoint.every_steps=0"]
            errors.append(self.speed_of(1e3, *signals, *length) / limit - 1.0)
        self.assertAlmostEqual(errors[1] / errors[0], 0.5, delta=0.05)

    def test_ball_sinks_and_turns_as_stokes_and_kirchhoff_have_it(self):
        out = self.run_of(self.case(BALL), f"bodies.0.mass_kg={mass_kg(50)}")
        with open(out / "trajectory.csv") as file:
            end = list(csv.DictReader(file))[-1]
        displaced_kg = 1000 * 4 / 3 * np.pi * RADIUS_M**3
        sinking = (mass_kg(50) - displaced_kg) * -9.81 / DRAG_KG_PER_S
        self.assertAlmostEqual(float(end["vz_m_per_s"]) / sinking, 1.0, delta=1e-7)
        turning = 1e-18 / (8 * np.pi * VISCOSITY_PA_S * RADIUS_M**3)
        self.assertAlmostEqual(float(end["wy_rad_per_s"]) / turning, 1.0, delta=1e-7)

    def test_services_and_a_resumed_run_have_the_same_digest(self):
        case = self.case(SWIMMER)
        whole, other = self.run_of(case), self.run_of(case, "services.transport=ipc")
        self.assertEqual(self.digest_of(whole), self.digest_of(other))
        (other / "summary.json").unlink()
        self.finish("run", case, "--out", other, "--resume")
        self.assertEqual(self.digest_of(whole), self.digest_of(other))

    def test_a_run_may_end_once_its_swimmer_repeats_its_cycle_resumed_or_not(self):
        case, more = self.case(SWIMMER), ("run.steps=40000", "run.until_periodic={}")
        out = self.run_of(case, *more)
        summary = json.loads((out / "summary.json").read_text())
        self.assertEqual((summary["steps"], summary["periodic"]), (3 * STEPS + 1, True))
        self.assertLess(summary["swimmers"][0]["kinematics"]["change_from_last_cycle"]["velocity"], 1e-3)
        (out / "summary.json").unlink()
        self.finish("run", case, "--out", out, "--resume", *(word for each in more for word in ("--set", each)))
        self.assertEqual(self.digest_of(out), summary["digest"])
        never = self.run_of(case, "run={until_periodic: {tolerance: 1e-20, cycles: 3}}")
        summary = json.loads((never / "summary.json").read_text())
        self.assertEqual((summary["steps"], summary["periodic"]), (3 * STEPS, False))

    def test_without_a_virtual_mass_the_longest_step_is_named_and_stable(self):
        case = self.case(BALL)
        session = self.finish("check", case, "--set", "coupling.virtual_mass=none", code=2)
        self.assertRegex(
            session.last_line, r"step_s is 1e-05 s .* diverge above 4\.297e-06 s\)\. Use coupling\.virtual_mass: auto"
        )
        self.run_of(case, "coupling.virtual_mass=none", "step_s=4.2e-6", "run.steps=2000")


def print_table():
    """The swimmer's speed over that of the limit, by the step over the time in which a bead loses its momentum."""
    limit = quasi_static_speed()
    Overdamped.setUpClass()
    runs = Overdamped()
    runs.setUp()
    print("| step over m/γ | speed over its limit |\n|---|---|")
    for ratio in (0.1, 0.3, 1, 3, 10, 1e2, 1e3, 1e4):
        speed = runs.speed_of(ratio)
        print(f"| {ratio:g} | {speed / limit:.5f} |")
    runs.doCleanups()


if __name__ == "__main__":
    print_table() if "--table" in sys.argv else unittest.main()
