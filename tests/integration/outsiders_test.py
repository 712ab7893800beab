"""First trials of people who bring a component of their own: each ends with a sentence about what is wrong, and where.

The trial of a build that another process holds is test_the_build_that_a_command_waits_for_is_named in
deploy_preparation_test.py.
"""

import json
import os
import shlex
import shutil
import subprocess
import unittest
from pathlib import Path

from copepod_session import ROOT, CommandTest

PROGRAMS = Path(os.environ.get("COPEPOD_BUILT_PROGRAMS", ROOT / "build/bin"))
SWIMMER = (ROOT / "configs/quick/vacuum.yaml", "--set", "run.steps=800")
STEP = 700
STOKES_DRAG = f"/usr/bin/python3 {ROOT}/examples/python/stokes_drag_fluid.py"

CAPSULE = """
case: capsule
fluid: {solver: external, density_kg_per_m3: 1000, kinematic_viscosity_m2_per_s: 1.0e-4}
step_s: 1.0e-9
bodies:
  - {name: pill, shape: capsule, radius_m: 4.0e-6, length_m: 8.0e-6, mass_kg: 5.0e-13, position_m: [0, 0, 0]}
coupling: {scheme: serial_explicit, load_averaging: none}
run: {steps: 10}
"""

# A body component in Python, the example's point masses; CHANGE is what this trial makes of it.
COMPONENT = f"""
import os, signal, sys
sys.path.insert(0, {str(ROOT / "examples/python")!r})
from copepod_component import Capabilities, run_body_component, server
from point_masses import PointMasses

FEATURES = ["motion:free", "shape:sphere", "springs", "actuator:pair_force", "checkpoint"]
FEATURES += ["neglects:torques", "neglects:periodic"]

def when_due(act):
    "Lets `act` happen in step {STEP}."
    take_step = PointMasses.step
    def step(solver, applied):
        if applied.step == {STEP}:
            act()
        return take_step(solver, applied)
    PointMasses.step = step

def change_message(change):
    "Lets `change` alter the reply to step {STEP} after all checks of the kit, as one without a kit would send it."
    to_frame = server.to_frame
    def changed(envelope):
        if envelope.WhichOneof("body") == "kinematics" and envelope.step == {STEP + 1}:
            change(envelope)
        return to_frame(envelope)
    server.to_frame = changed

CHANGE

sys.exit(run_body_component(PointMasses, Capabilities("An outsider's bodies", "1", FEATURES)))
"""


class Trial(CommandTest):
    programs = PROGRAMS

    def body(self, change):
        """Arguments for a run with a body component that is changed in this way."""
        script = self.folder / "body.py"
        script.write_text(COMPONENT.replace("CHANGE", change))
        return "--body", f"/usr/bin/python3 {script}"

    def refusal(self, code, *arguments):
        """Last line of a run that must end with `code`."""
        session = self.start("run", *arguments, "--out", "out")
        self.assert_ends(session, code, timeout_s=60)
        return session.last_line


class Features(Trial):
    """A component is asked for every feature that the case uses, before step 0."""

    def test_body_component_without_springs(self):
        said = self.refusal(2, *SWIMMER, *self.body('FEATURES.remove("springs")'))
        self.assertIn("the case needs «springs» (An outsider's bodies does not announce it)", said)

    def test_springs_that_are_neglected_on_purpose_are_reported(self):
        arguments = self.body('FEATURES[:] = [name.replace("springs", "neglects:springs") for name in FEATURES]')
        session = self.start("run", *SWIMMER, *arguments, "--out", "out")
        self.assert_ends(session, 0, timeout_s=60)
        self.assertRegex("".join(session.stderr), "neglects .*springs")

    def test_misspelt_feature(self):
        said = self.refusal(2, *SWIMMER, *self.body('FEATURES[FEATURES.index("springs")] = "springz"'))
        self.assertRegex(said, "needs «springs» .* but «springz»")

    def test_external_fluid_that_cannot_do_a_capsule(self):
        (self.folder / "case.yaml").write_text(CAPSULE)
        self.assertRegex(
            self.refusal(2, "case.yaml", "--fluid", STOKES_DRAG),
            "needs «shape:capsule» .Stokes drag in Python does not announce it",
        )


class Ends(Trial):
    """A component that ends in the middle of a run is named with its step and how it ended."""

    def assert_lost(self, act, how):
        said = self.refusal(69, *SWIMMER, *self.body(f"when_due(lambda: {act})"))
        self.assertRegex(said, rf"body service on host \S+, rank 0, at step {STEP}: .*{how}")

    def test_segmentation_fault(self):
        self.assert_lost("os.kill(os.getpid(), signal.SIGSEGV)", "signal 11, SIGSEGV")

    def test_exit_in_the_middle(self):
        self.assert_lost("os._exit(3)", "exited with code 3")


class Messages(Trial):
    """A component without our kit sends what the kit would have refused: the component is blamed, with the step."""

    def assert_blamed(self, code, change, why):
        said = self.refusal(code, *SWIMMER, *self.body(f"change_message(lambda envelope: {change})"))
        self.assertRegex(said, rf"body service on host \S+, .*at step {STEP}: .*{why}")
        self.assertNotIn("coupler on host", said)

    def test_number_that_is_not_finite(self):
        self.assert_blamed(
            70, "envelope.kinematics.position_m.__setitem__(4, float('nan'))", "position_m of body 1 is nan"
        )

    def test_eight_of_nine_numbers(self):
        self.assert_blamed(65, "envelope.kinematics.position_m.pop()", "position_m.* 8 .*9")

    def test_wrong_sequence_number(self):
        for change in ("+ 5", "- 1"):
            with self.subTest(change):
                change = f"setattr(envelope, 'sequence', envelope.sequence {change})"
                self.assert_blamed(65, change, "with sequence number [0-9]+, that of the request is [0-9]+")
                shutil.rmtree(self.folder / "out")


class Plausibility(Trial):
    def test_force_of_1000_N_on_every_bead(self):
        force = "kind: world_force, direction: [0, 0, 1], signal: {kind: constant, amplitude_N: 1000}"
        forces = ", ".join(f"{{body: swimmer.{name}, {force}}}" for name in ("B1", "B2", "B3"))
        case = (
            ROOT / "configs/quick/three_sphere.yaml",
            "--set",
            "fluid.solver=external",
            "--set",
            f"actuators=[{forces}]",
        )
        shorter = ("--set", "run.steps=100", "--set", "output.fields.mean_over_steps=[0, 0]")
        said = self.refusal(70, *case, *shorter, "--fluid", STOKES_DRAG)
        self.assertRegex(said, "at step [0-9]+: .*(radius|domain)")


class InstalledKit(Trial):
    def setUp(self):
        super().setUp()
        prefix = self.folder / "prefix"
        install = ["cmake", "--install", PROGRAMS.parent, "--component", "kit", "--prefix", prefix]
        subprocess.run(install, check=True, stdout=subprocess.DEVNULL)
        self.packages = prefix / "share/copepod/python"
        self.script = self.folder / "bodies.py"
        lines = (ROOT / "examples/python/point_masses.py").read_text().splitlines()
        self.script.write_text("\n".join(line for line in lines if "sys.path" not in line))

    def test_component_runs_on_the_kit_in_the_users_path_and_not_on_the_one_of_the_checkout(self):
        with open(self.packages / "copepod_component/__init__.py", "a") as file:
            file.write(f"\nimport pathlib\npathlib.Path({str(self.folder)!r}, 'of the user').touch()\n")
        with open(self.packages / "copepod_conformance/__init__.py", "a") as file:
            file.write("\nraise SystemExit('the tool of another kit')\n")
        command = ("/usr/bin/python3", self.script)
        for arguments in (
            ("run", *SWIMMER, "--out", "out", "--body", shlex.join(map(str, command))),
            ("conformance", "--role", "body", "--only", "handshake", "--quick", "--", *command),
        ):
            session = self.start(*arguments, environment={"PYTHONPATH": str(self.packages)})
            self.assert_ends(session, 0, timeout_s=100)
            (self.folder / "of the user").unlink()

    def test_component_needs_no_checkout(self):
        command = f"/usr/bin/env PYTHONPATH={self.packages} /usr/bin/python3 {shlex.quote(str(self.script))}"
        session = self.start("run", *SWIMMER, "--body", command, "--out", "out")
        self.assert_ends(session, 0, timeout_s=60)
        self.assertEqual(json.loads((self.folder / "out/summary.json").read_text())["status"], "finished")


if __name__ == "__main__":
    unittest.main()
