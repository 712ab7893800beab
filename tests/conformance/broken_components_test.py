#!/usr/bin/python3
"""`copepod conformance` finds the defect of each broken component: these checks fail, with these words, no other.

    broken_components_test.py BUILD      folder of a build that is complete
"""

import os
import re
import subprocess
import sys
import tempfile
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from xml.etree import ElementTree

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
BUILD = Path(sys.argv.pop()).resolve()
COMPONENTS = HERE / "broken_components.py"

REFUSED = "instead of Failure"
STAYS = "no end of the process within"
LEFT = "1 process(es) left behind: sleep 600"

# function: role, groups of checks, {check that must fail: what must have come}
BROKEN = {
    "announces_an_unknown_feature": (
        "body",
        ["handshake"],
        {"every feature is a known name": "feature 'springz', which is not a known name (did you mean springs?)"},
    ),
    "steps_twice_on_a_repeat": (
        "body",
        ["exactly once"],
        {
            "a step requested twice is done once": "another Kinematics than the first time",
            "a step requested four times is done once": "another Kinematics than the first time",
            "a step requested again while it is done is done once": "another Kinematics than the first time",
        },
    ),
    "ignores_the_version": (
        "fluid",
        ["versions"],
        {
            "a Welcome of protocol 1.0 is refused": STAYS,
            "a Welcome of protocol 3.0 is refused": STAYS,
            "a Welcome of a minor version that it does not support is refused": STAYS,
            "a request of protocol 1.0 is refused": f"Loads #2 of step 0 {REFUSED}",
            "a request of protocol 3.0 is refused": f"Loads #2 of step 0 {REFUSED}",
        },
    ),
    "accepts_nan": (
        "fluid",
        ["numbers"],
        {
            f"Kinematics.{field} = nan": f"Loads #2 of step 0 {REFUSED}"
            for field in ("position_m", "orientation_wxyz", "velocity_m_per_s", "angular_velocity_rad_per_s")
        },
    ),
    "restores_another_state": (
        "body",
        ["checkpoints"],
        {"a restored run equals the undisturbed one": "after Restore, but"},
    ),
    "starts_where_it_was": (
        "body",
        ["checkpoints"],
        {"a run that returns equals the undisturbed one": "a reply to step 0 that differs"},
    ),
    "survives_its_coupler": (
        "fluid",
        ["ends"],
        {
            "coupler gone when greeted: exit code 69": STAYS,
            "coupler gone when ready: exit code 69": STAYS,
            "coupler gone when stepping: exit code 69": STAYS,
            "coupler silent: exit code 69": STAYS,
        },
    ),
    "takes_its_suspension_for_a_loss": (
        "fluid",
        ["ends"],
        {"suspended for 3.5 s: continues": "exit code 69"},
    ),
    "ends_as_if_all_were_well": (
        "fluid",
        ["handshake"],
        {
            "ends when it is refused": "exit code 0 instead of 65",
            "ends without an answer": "exit code 0 instead of 74",
        },
    ),
    "leaves_a_child": (
        "body",
        ["processes"],
        {
            "nothing is left after Finish": LEFT,
            "nothing is left after a Failure": LEFT,
            "nothing is left after an Abort": LEFT,
            "nothing is left after the loss of the coupler": LEFT,
        },
    ),
    "drives_what_moves": (
        "fluid",
        ["physics"],
        {"a force against the motion": "on a body that moves along (0.5, -1, 0.25)"},
    ),
    "pulls_at_an_obstacle": (
        "fluid",
        ["physics"],
        {
            "a force against the motion of other shapes": "on a box along its motion",
            "a torque against the rotation of other shapes": "on an obstacle ten cells from all motion",
        },
    ),
    "turns_a_box_as_a_sphere": (
        "body",
        ["physics"],
        {"a box under force and torque": "angular velocity [rad/s] of body 0"},
    ),
    "freezes_its_drive": (
        "body",
        ["physics"],
        {
            "a pair force follows the arm": "relative velocity [m/s] gained from the pair force",
            "a pair force has no net force and torque": "angular momentum changed by 0.0005",
            "a body force turns with its body": "velocity [m/s] of body 0",
        },
    ),
    "drives_with_a_net_torque": (
        "body",
        ["physics"],
        {"a pair force has no net force and torque": "angular momentum changed by 1e-09"},
    ),
    "turns_a_world_force": (
        "body",
        ["physics"],
        {"a world force keeps its direction": "velocity [m/s] of body 0"},
    ),
    "bends_without_reaction": ("body", ["physics"], {"a bend turns its arms": "velocity [m/s] of body 0"}),
    "lets_its_rods_drift": ("body", ["physics"], {"a distance joint stays closed": "length off by"}),
    "passes_exits": (
        "body",
        ["physics"],
        {"a body that reaches an exit leaves": "after step 3 it is on the wrong side"},
    ),
    "moves_on_behind_exits": (
        "body",
        ["physics"],
        {"a body that reaches an exit leaves": "a body behind an exit moves"},
    ),
    "ignores_an_abort": (
        "body",
        ["ends"],
        {
            "Abort (code 70) when greeted: exit code 70": STAYS,
            "Abort (code 69) when configured: exit code 69": STAYS,
            "Abort (code 74) when ready: exit code 74": STAYS,
            "Abort (code 70) when stepping: exit code 70": STAYS,
            "Abort with code 0: an exit code that is not 0": STAYS,
        },
    ),
    "busy_while_it_waits": (
        "fluid",
        ["processes"],
        {"waiting costs no time": "of a core used by a process that waits"},
    ),
}


def run_conformance(script, role, *options):
    """Exit code, output and {failed check: what came}."""
    with tempfile.TemporaryDirectory() as folder:
        junit = Path(folder) / "junit.xml"
        ended = subprocess.run(
            [
                ROOT / "deploy" / "copepod",
                "conformance",
                "--role",
                role,
                "--quick",
                "--patience",
                "8",
                "--jobs",
                "2",
                "--junit",
                junit,
                *options,
                "--",
                "/usr/bin/python3",
                *(script if isinstance(script, list) else [COMPONENTS, script]),
            ],
            env={**os.environ, "COPEPOD_BIN_DIR": str(BUILD / "bin")},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
        cases = ElementTree.parse(junit).getroot() if junit.exists() else []
        failed = {
            case.get("name"): case.find("failure").get("message") for case in cases if case.find("failure") is not None
        }
    return ended.returncode, ended.stdout + ended.stderr, failed


class BrokenComponents(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with ThreadPoolExecutor(2) as pool:
            started = {
                script: pool.submit(run_conformance, script, role, *(f"--only={group}" for group in groups))
                for script, (role, groups, _) in BROKEN.items()
            }
            cls.ended = {script: future.result() for script, future in started.items()}

    def test_each_fails_with_the_right_words_and_in_nothing_else(self):
        for script, (_, _, expected) in BROKEN.items():
            with self.subTest(script):
                code, output, failed = self.ended[script]
                self.assertEqual(code, 1, output)
                self.assertEqual(set(failed), set(expected), output)
                for check, words in expected.items():
                    self.assertIn(words, failed[check], output)

    def test_the_output_says_what_was_sent_what_came_and_what_the_rule_demands(self):
        _, output, _ = self.ended["drives_what_moves"]
        self.assertIn(
            "FAILED physics: a force against the motion\n"
            "  sent  Welcome on both lanes, FluidSetup #1 of step 0, Kinematics #2 of step 0\n"
            "  came  at step 0 a force of (",
            output,
        )
        self.assertIn(
            "  rule  in a fluid that was at rest the load on a moving body is against its motion\n"
            "        docs/protocol.md, «What a role implies»",
            output,
        )
        self.assertIn("not conformant: 2 passed, 1 failed, 1 skipped", output)
        _, output, _ = self.ended["steps_twice_on_a_repeat"]
        self.assertRegex(
            output, r"  sent  .*AppliedLoads #4 of step 2, AppliedLoads #4 of step 2 again\n  came  another"
        )
        _, output, _ = self.ended["ignores_the_version"]
        self.assertIn("  sent  Welcome on both lanes of protocol 1.0\n", output)
        self.assertIn(", Kinematics #2 of step 0 of protocol 3.0\n", output)

    def test_every_broken_component_is_tried(self):
        functions = set(re.findall(r"^def (\w+)\(\)", COMPONENTS.read_text(), re.MULTILINE))
        self.assertEqual(functions - {"is_no_component", "saves_nothing"}, set(BROKEN))

    def test_a_component_without_checkpoints_is_not_asked_for_any_but_refuses_a_save(self):
        groups = [f"--only={group}" for group in ("states", "exactly once", "checkpoints", "limits")]
        code, output, failed = run_conformance("saves_nothing", "body", *groups)
        self.assertEqual((code, failed), (0, {}), output)

    def test_a_component_that_is_silent_is_given_up_soon(self):
        code, output, failed = run_conformance(
            [HERE / "silent_component.py"], "fluid", "--patience=0.3", "--only=states"
        )
        self.assertEqual(code, 1, output)
        self.assertIn("nothing within 0.3 s instead of a Hello on both lanes", failed["connected: Hello"])
        self.assertIn("not tried: the component was silent too often", failed.values())

    def test_a_program_that_is_no_component_is_told_so(self):
        code, output, _ = run_conformance("is_no_component", "fluid")
        self.assertEqual(code, 2, output)
        self.assertIn("does not print what the component can do as JSON", output)

    def test_a_component_that_cannot_start_is_quoted(self):
        code, output, _ = run_conformance("no_such_component", "fluid")
        self.assertEqual(code, 2, output)
        self.assertRegex(output, "its exit code is 1; its last words: KeyError: 'no_such_component'")


if __name__ == "__main__":
    unittest.main()
