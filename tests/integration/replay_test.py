"""`copepod replay` starts what was recorded, refuses what it cannot play, and leaves nothing behind."""

import os
import shutil
import signal
import unittest
from pathlib import Path

from copepod_session import ROOT, CommandTest, wait_until

PROGRAMS = Path(os.environ.get("COPEPOD_BUILT_PROGRAMS", ROOT / "build/bin"))
RECORDED = (
    ROOT / "configs/quick/vacuum.yaml",
    "--out",
    "out",
    "--set",
    "run.steps=40",
    "--set",
    "output.wire=true",
    "--set",
    "output.checkpoint.every_steps=15",
)
PYTHON_BODIES = f"/usr/bin/python3 {ROOT}/examples/python/point_masses.py"
ASLEEP = ("--", "/usr/bin/python3", "-c", "import time; print('asleep', flush=True); time.sleep(600)")


class Replay(CommandTest):
    programs = PROGRAMS

    def finish(self, *arguments, code=0):
        """Standard output of a command that ends with `code` and leaves nothing behind."""
        session = self.start(*arguments)
        self.assert_ends(session, code, timeout_s=60)
        self.last_line = session.last_line if session.stderr else ""
        return "".join(session.stdout)

    def test_the_recorded_solver_is_started_and_not_our_own(self):
        for name, arguments in (
            ("bullet", ("--set", "body.solver=bullet")),
            ("mujoco", ("--set", "body.solver=mujoco")),
            ("python", ("--body", PYTHON_BODIES, "--set", "body.integrator=semi_implicit_euler")),
        ):
            if name != "python" and not (PROGRAMS / f"{name}_body_service").exists():
                continue
            self.finish("run", *RECORDED, *arguments)
            self.assertIn("replies agree bit by bit", self.finish("replay", "out", "--body"))
            (self.folder / "out").rename(self.folder / name)

    def test_attempt_that_was_resumed_is_replayed_as_long_as_its_checkpoint_is_there(self):
        self.finish("run", *RECORDED)
        self.finish("run", *RECORDED, "--resume")
        self.assertIn("replies agree", self.finish("replay", "out", "--body", "--attempt", "2"))
        shutil.rmtree(self.folder / "out/checkpoints")
        self.finish("replay", "out", "--body", "--attempt", "2", code=2)
        self.assertRegex(
            self.last_line, "attempt_002 cannot be replayed .*checkpoints/step_0*30, which no longer exists"
        )
        self.finish("replay", "out", "--as", "body", code=2)
        self.assertIn("Use --attempt 1", self.last_line)
        self.finish("replay", "out", "--as", "body", "--attempt", "1")

    def test_recording_that_ends_before_the_run_does_says_so(self):
        self.finish("run", *RECORDED)
        case = self.folder / "out/case.yaml"
        case.write_text(case.read_text().replace("steps: 40\n", "steps: 45\n"))
        session = self.start("replay", "out", "--as", "body", "--out", "again")
        self.assertEqual(session.end(timeout_s=60), 70, "".join(session.stderr))
        self.assertIn(
            "of step 40 is not in the recording (it ends before; all requests so far were as recorded)",
            session.last_line,
        )

    def test_program_that_is_not_there_leaves_nothing_behind(self):
        self.finish("run", *RECORDED)
        self.finish("replay", "out", "--body", "--", "nosuch", code=2)
        self.assertIn("nosuch cannot be started (no such program)", self.last_line)

    def test_command_that_is_killed_leaves_nothing_behind(self):
        self.finish("run", *RECORDED)
        for number in (signal.SIGKILL, signal.SIGHUP):
            session = self.start("replay", "out", "--body", *ASLEEP)
            wait_until(lambda: session.stdout, "the first word of the component")
            self.assertTrue(session.scratch_folders())
            session.process.send_signal(number)
            session.end()
            session.wait_until_clean()

    def test_logs_that_a_failed_run_names_are_still_there(self):
        self.finish("run", *RECORDED)
        case = self.folder / "out/case.yaml"
        case.write_text(case.read_text().replace("amplitude_N: ", "amplitude_N: 1"))
        session = self.start("replay", "out", "--as", "body")
        self.assertEqual(session.end(timeout_s=60), 70, "".join(session.stderr))
        logs = (self.folder / session.last_line.split("Logs: ")[1].split()[0].rstrip(".")).resolve()
        self.addCleanup(shutil.rmtree, logs.parents[1])
        self.assertTrue((logs / "coupler.log").exists(), session.last_line)


if __name__ == "__main__":
    unittest.main()
