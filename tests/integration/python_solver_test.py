"""Solvers that users write in Python: slow, mistaken, asked to stop."""

import io
import json
import logging
import os
import time
import unittest
from contextlib import redirect_stdout
from pathlib import Path
from unittest import mock

from copepod_component import Capabilities, SolverContext, Summary, control_lane, run_fluid_component
from copepod_component.messages import Envelope, to_frame
from copepod_component.solvers import ServedFluid
from copepod_session import ROOT, CommandTest

PROGRAMS = Path(os.environ.get("COPEPOD_BUILT_PROGRAMS", ROOT / "build/bin"))
CASE = (ROOT / "configs/quick/vacuum.yaml", "--set", "run.steps=3", "--out", "out")

FLUID = """
import sys, time
import numpy as np
from copepod_component import CaseError, Capabilities, Summary, run_fluid_component

class Fluid:
    def __init__(self, setup, context):
        self.context = context
        self.nothing = np.zeros((len(setup.bodies), 3))
    def exchange(self, kinematics):
        EXCHANGE
        return self.nothing, self.nothing
    def advance(self):
        pass
    def summarise(self):
        return Summary()

sys.exit(run_fluid_component(Fluid, Capabilities("A user's fluid", "1", ["solver:external"])))
"""


class PythonSolver(CommandTest):
    programs = PROGRAMS

    def start_with(self, exchange, *arguments):
        """A run whose fluid does this in `exchange`."""
        script = self.folder / "fluid.py"
        script.write_text(FLUID.replace("EXCHANGE", exchange))
        return self.start("run", *CASE, "--fluid", f"/usr/bin/python3 {script}", *arguments)

    def log(self):
        return (self.folder / "out/logs/fluid.log").read_text()

    def test_long_step_that_reports_its_progress_is_not_taken_for_hung(self):
        deadline = ("--set", "services.progress_deadline_s=1.5")
        slow = "for _ in range(30 * (kinematics.step == 1)): time.sleep(0.1); {}"
        session = self.start_with(slow.format("self.context.report_progress()"), *deadline)
        self.assert_ends(session, 0)
        session = self.start_with(slow.format("pass"), *deadline, "--out", "again")
        self.assert_ends(session, 69)

    def test_mistake_is_named_by_file_and_line(self):
        session = self.start_with("kinematics.velocity")
        self.assert_ends(session, 70)
        line = FLUID[: FLUID.index("EXCHANGE")].count("\n") + 1
        self.assertRegex(session.last_line, rf"no attribute 'velocity'.* in {self.folder}/fluid.py, line {line} ")
        self.assertIn("Traceback (most recent call last)", self.log())

    def test_problem_that_the_solver_foresaw_has_its_exit_code_and_no_traceback(self):
        session = self.start_with('raise CaseError("The bodies are cubes (spheres are known). Use spheres.")')
        self.assert_ends(session, 2)
        self.assertIn("The bodies are cubes (spheres are known). Use spheres.", session.last_line)
        self.assertNotIn("Traceback", self.log())


class CommandLine(unittest.TestCase):
    def test_of_a_component_with_options_of_its_own_is_given_without_them(self):
        with redirect_stdout(io.StringIO()) as output:
            code = run_fluid_component(None, Capabilities("Mine", "1", ["gravity"]), arguments=["--capabilities"])
        self.assertEqual((code, json.loads(output.getvalue())["name"]), (0, "Mine"))


class StopRequest(unittest.TestCase):
    def test_says_with_which_code_the_coupler_aborted_the_run(self):
        context = SolverContext()
        lane = control_lane.ControlLane(None, "", b"", context, 10.0, logging.getLogger("quiet"))
        lane._handle(None, to_frame(Envelope(protocol_major=1, welcome={"session_id": 1, "epoch": 2})))
        self.assertEqual(context.stop_requested(), 0)
        lane._handle(None, to_frame(Envelope(session_id=1, epoch=2, abort={"failure": {"code": 74}})))
        self.assertEqual(context.stop_requested(), 74)


class Summaries(unittest.TestCase):
    def summary_of(self, **fields):
        served, reply = ServedFluid(None, None), Envelope()
        served.solver = mock.Mock(summarise=lambda: Summary(**fields))
        served._timed("exchange", time.sleep, 0.001)
        served.perform(Envelope(summarise={}), reply)
        return reply.summary

    def test_have_the_times_that_the_kit_measured_unless_the_solver_has_its_own(self):
        self.assertGreaterEqual(self.summary_of().seconds["exchange"], 0.001)
        self.assertEqual(self.summary_of(seconds={"bulk": 0.5}).seconds, {"bulk": 0.5})

    def test_have_only_the_drifts_that_the_solver_reports(self):
        summary = self.summary_of(mass_drift=0.0, digest=7, body_phases=("map",))
        self.assertEqual((summary.digest, list(summary.body_phases), summary.ranks), (7, ["map"], 1))
        self.assertTrue(summary.HasField("mass_drift"))
        self.assertFalse(summary.HasField("momentum_drift"))


if __name__ == "__main__":
    unittest.main()
