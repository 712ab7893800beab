"""The life of a run under `copepod run`, with components that have no physics: every way to end, and what is left."""

import itertools
import json
import os
import re
import signal
import subprocess
import sys
import time
import unittest
from pathlib import Path

from copepod_session import COMMAND, FAKES, PROMPT_S, ROOT, TinyRunTest, wait_until


STOPPED_S = 0.7  # half of what the command tolerates


class RunLifecycle(TinyRunTest):
    def test_finished_run_prints_table_and_returns_zero(self):
        session = self.start("run", self.case(steps=5, summary={"mlups": 12.5}))
        self.assert_ends(session, 0)
        self.assertIn("12.5 MLUPS", "".join(session.stdout))
        self.assertIn("results in runs/tiny", "".join(session.stdout))
        self.assertTrue((self.folder / "runs/tiny/summary.json").exists())

    def test_component_that_cannot_be_started_is_named_without_the_token_of_the_run(self):
        (self.folder / "program").write_text("not an executable format")
        (self.folder / "program").chmod(0o755)
        session = self.start("run", self.case(), "--body", f"{self.folder}/program --fast")
        self.assert_ends(session, 2)
        self.assertTrue(
            session.last_line.endswith(f"Check this command: {self.folder}/program --fast"), session.last_line
        )

    def test_log_of_a_component_that_ended_is_quoted(self):
        words = "a fluid component already takes part (only one can). Start one component per role."
        error = f"2026-11-21 10:00:00 error [body rank 0] [step -1] {words}"
        script = self.component(f'echo "{error}" > runs/tiny/logs/body.log; exit 65')
        session = self.start("run", self.case(reports=False), "--body", script)
        self.assert_ends(session, 65)
        self.assertIn("already takes part", session.last_line)

    def assert_loss(self, session, component, rank):
        self.assert_ends(session, 69)
        place = rf"{component} on host {os.uname().nodename}, rank {rank}, (at|after) step \d+: "
        self.assertRegex(session.last_line, place)  # "at" if the coupler could report the step
        self.assertIn("signal 9, SIGKILL", session.last_line)
        provenance = json.loads((self.folder / "runs/tiny/provenance.json").read_text())
        self.assertEqual(provenance["exit_code"], 69)
        self.assertIn(f"rank {rank}", provenance["exit_reason"])

    def test_killed_coupler(self):
        session = self.start_long_run()
        session.kill(signal.SIGKILL, "coupler")
        self.assert_loss(session, "coupler", "0")

    def test_killed_body_service(self):
        session = self.start_long_run()
        session.kill(signal.SIGKILL, "body")
        self.assert_loss(session, "body service", "0")

    def test_killed_fluid_rank(self):
        session = self.start_long_run()
        session.kill(signal.SIGKILL, "fluid", rank="1")
        self.assert_loss(session, "fluid service", "1")

    def test_killed_fluid_rank_that_the_coupler_does_not_notice(self):
        session = self.start_long_run(reports=False)
        session.kill(signal.SIGKILL, "fluid", rank="1")
        self.assert_loss(session, "fluid service", "1")

    def test_killed_mpirun(self):
        session = self.start_long_run()
        session.kill(signal.SIGKILL, "fluid")
        self.assert_loss(session, "fluid service", "0-1")

    def test_mpirun_that_reports_a_killed_rank_and_does_not_end(self):
        session = self.start("run", self.case(reports=False), "--ranks", "1", "--fluid", f"{FAKES}/stuck_mpirun")
        self.assert_ends(session, 69)
        self.assertRegex(session.last_line, r"fluid service on host sea, rank 1, .*signal 9, SIGKILL")

    def test_mpirun_that_reports_a_killed_rank_long_after_the_coupler_lost_it(self):
        session = self.start_long_run("--ranks", "1", "--fluid", f"{FAKES}/stuck_mpirun --late")
        session.kill(signal.SIGKILL, "fluid", rank="1")
        self.assert_ends(session, 69)
        self.assertRegex(session.last_line, r"fluid service on host sea, rank 1, .*signal 9, SIGKILL")

    def test_rank_that_ended_unnoticed_by_mpirun(self):
        session = self.start_long_run("--ranks", "1", "--fluid", f"{FAKES}/stuck_mpirun --silent", reports=False)
        session.kill(signal.SIGKILL, "fluid", rank="1")
        self.assert_ends(session, 69)
        self.assertRegex(session.last_line, "fluid service on host .*, rank 1, .*ended, and mpirun did not notice")

    def test_request_for_a_checkpoint_at_the_very_start_ends_nothing(self):
        env = self.folder / "bin/env"  # by which the command starts Python
        env.parent.mkdir()
        env.write_text('#!/bin/sh\ntouch reached\nwhile [ ! -e go ]; do sleep 0.01; done\nexec /usr/bin/env "$@"\n')
        env.chmod(0o755)
        session = self.start("run", self.case(steps=100), environment={"PATH": f"{env.parent}:{os.environ['PATH']}"})
        session.wait_for_file("reached")
        session.process.send_signal(signal.SIGUSR1)
        (self.folder / "go").touch()
        self.assert_ends(session, 0)

    def test_request_for_a_checkpoint_before_the_run_has_begun_is_passed_on(self):
        session = self.start("run", self.case(steps=100))
        status = Path(f"/proc/{session.process.pid}/status")
        handled = re.compile(r"SigCgt:\s+(\w+)")
        bit = 1 << (signal.SIGUSR1 - 1)
        wait_until(lambda: int(handled.search(status.read_text())[1], 16) & bit, "a handler of SIGUSR1", PROMPT_S)
        session.process.send_signal(signal.SIGUSR1)
        self.assert_ends(session, 0)
        self.assertTrue((self.folder / "runs/tiny/asked").exists())

    def test_folders_of_a_run_whose_guard_was_killed_too_are_swept_by_a_later_run(self):
        session = self.start_long_run()
        processes = set(session.processes())
        running = self.start_long_run()
        guard = next(pid for pid in map(int, filter(str.isdigit, os.listdir("/proc"))) if session.is_guard(pid))
        os.kill(guard, signal.SIGKILL)
        session.process.kill()
        session.end()
        wait_until(lambda: not processes & set(session.processes()), "no process of the killed run", PROMPT_S)
        for folder in [*session.scratch_folders(), *running.scratch_folders()]:
            os.utime(folder, (0, 0))
        self.assertEqual({folder.parent.name for folder in session.scratch_folders()}, {"tmp", "shm"})
        self.assertEqual(self.start("run", self.case(steps=1)).end(), 0)
        self.assertEqual(session.scratch_folders(), [])
        self.assertTrue(running.scratch_folders())

    def test_frozen_component_is_named_once_the_coupler_reports_it(self):
        session = self.start_long_run("--fluid", f"{FAKES}/fluid_service", "--ranks", "1")
        session.kill(signal.SIGSTOP, "body")
        session.kill(signal.SIGKILL, "fluid")
        self.assert_ends(session, 69)

    def test_component_that_fails_by_itself_keeps_its_exit_code(self):
        session = self.start(
            "run", self.case(reports=False, ranks=1), "--fluid", f"{FAKES}/fluid_service --fail-with 70"
        )
        self.assertEqual(session.end(), 70)
        self.assertIn("fluid service", session.last_line)
        self.assertIn("density is not a number (diverged). Use a smaller step", session.last_line)
        self.assert_nothing_left(session)

    def test_rank_that_fails_by_itself_keeps_its_exit_code(self):
        session = self.start("run", self.case(reports=False), "--fluid", f"{FAKES}/fluid_service --fail-with 73")
        self.assertEqual(session.end(), 73)
        self.assert_nothing_left(session)

    def test_stubborn_component_is_killed(self):
        session = self.start_long_run("--body", f"{FAKES}/body_service --stubborn")
        session.kill(signal.SIGKILL, "coupler")
        self.assert_ends(session, 69)

    def test_frozen_process_is_named_with_its_rank(self):
        for component, rank, program in (
            ("coupler", None, "coupler"),
            ("fluid", "1", "fluid_service"),
            ("fluid", None, "mpirun"),
        ):
            session = self.start_long_run("--out", f"frozen_{component}_{rank}")
            session.kill(signal.SIGSTOP, component, rank)
            self.assert_ends(session, 69)
            name = "coupler" if component == "coupler" else "fluid service"
            self.assertRegex(
                session.last_line, rf"{name} on host .*, rank {rank or 0}, after step .*frozen.*\({program}\)"
            )

    def test_process_that_is_stopped_for_a_moment_is_forgiven(self):
        session = self.start_long_run(steps=200)
        session.kill(signal.SIGSTOP, "body")
        time.sleep(STOPPED_S)
        session.kill(signal.SIGCONT, "body")
        self.assert_ends(session, 0)

    def test_ctrl_c_keeps_the_run_directory(self):
        session = self.start_long_run()
        os.killpg(session.process.pid, signal.SIGINT)
        self.assert_ends(session, 130)
        self.assertIn("stopped by Ctrl-C", session.last_line)
        provenance = json.loads((self.folder / "runs/tiny/provenance.json").read_text())
        self.assertEqual(provenance["exit_code"], 130)

    def test_a_signal_in_the_first_moment(self):
        """One that comes before our first line must neither end in a traceback of Python's nor without a last line."""
        self.case(steps=5)
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            for milliseconds in (0, 5, 10, 20, 30, 40, 60, 80, 100, 150):
                session = self.start("check", "case.yaml")
                program = Path(f"/proc/{session.process.pid}/exe")
                wait_until(lambda: "python" in os.readlink(program), "Python, which the shell has become")
                time.sleep(milliseconds * 1e-3)
                os.killpg(session.process.pid, number)
                code = session.end()
                said = "".join(session.stderr)
                # Python ends itself by SIGINT if that had come while it made a class of a text (exec).
                self.assertIn(code, (0, 128 + number, *([-number] if number == signal.SIGINT else [])), said)
                self.assertNotIn("Traceback", said)
                if code != 0:
                    self.assertIn("copepod: stopped by", said)

    def test_a_signal_before_there_is_python(self):
        """The shell that finds Python is held by a program that it needs."""
        readlink = self.folder / "readlink"
        readlink.write_text('#!/bin/sh\ntouch held\nsleep 0.3\nexec /usr/bin/readlink "$@"\n')
        readlink.chmod(0o755)
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            session = self.start("--version", environment={"PATH": f"{self.folder}:{os.environ['PATH']}"})
            session.wait_for_file("held")
            session.process.send_signal(number)
            self.assert_ends(session, 128 + number)
            self.assertEqual(session.last_line, f"copepod: stopped by {signal.Signals(number).name}.")
            (self.folder / "held").unlink()

    def test_ctrl_c_while_an_import_defines_a_class(self):
        """Python 3.11 makes a RuntimeError of it."""
        interrupted = self.folder / "copepod_run" / "messages.py"
        interrupted.parent.mkdir()
        (interrupted.parent / "__init__.py").touch()
        interrupted.write_text(
            "class Interrupted:\n    def __set_name__(self, owner, name):\n        raise KeyboardInterrupt\n\n\n"
            "class Defined:\n    member = Interrupted()\n"
        )
        command = [sys.executable, "-P", "-m", "copepod_command"]
        paths = f"{self.folder}:{ROOT / 'deploy'}"
        ended = subprocess.run(command, env={**os.environ, "PYTHONPATH": paths}, capture_output=True, text=True)
        self.assertEqual((ended.returncode, ended.stderr), (130, "copepod: stopped by Ctrl-C.\n"))

    def test_a_signal_while_python_ends_changes_nothing(self):
        (self.folder / "sitecustomize.py").write_text(
            "import atexit, os, signal, sys\n"
            "atexit.register(lambda: os.kill(os.getpid(), int(os.environ['NUMBER'])))\n"
        )
        paths = f"{self.folder}:{ROOT / 'deploy'}"
        for arguments, code in (("--version", 0), ("check", 2), (f"check {self.folder}/no_case.yaml", 2)):
            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
                ended = subprocess.run(
                    [sys.executable, "-P", "-m", "copepod_command", *arguments.split()],
                    env={**os.environ, "PYTHONPATH": paths, "NUMBER": str(int(number))},
                    capture_output=True,
                    text=True,
                )
                self.assertEqual(ended.returncode, code, ended.stderr)
                self.assertNotIn("stopped by", ended.stderr)
                self.assertNotIn("Traceback", ended.stderr)

    def test_a_signal_while_an_object_is_destroyed_or_a_class_defined(self):
        """Python would drop, or wrap, what its handler raises."""
        action = self.folder / "destroying.py"
        action.write_text(
            "import os, time\n\n\n"
            "class Destroyed:\n    def __del__(self):\n        os.kill(os.getpid(), int(os.environ['NUMBER']))\n\n\n"
            "def destroy(options):\n    Destroyed()\n    time.sleep(20)\n\n\n"
            "class Member:\n    def __set_name__(self, owner, name):\n        Destroyed().__del__()\n\n\n"
            "def define(options):\n    class Defined:\n        member = Member()\n\n    time.sleep(20)\n"
        )
        script = (
            "import argparse, sys\nfrom copepod_command import main\n"
            "main.parse = lambda arguments: argparse.Namespace(action=sys.argv[1])\nsys.exit(main.main([]))"
        )
        numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
        for function, number in itertools.product(("destroying:destroy", "destroying:define"), numbers):
            ended = subprocess.run(
                [sys.executable, "-P", "-c", script, function],
                env={**os.environ, "PYTHONPATH": f"{self.folder}:{ROOT / 'deploy'}", "NUMBER": str(int(number))},
                capture_output=True,
                text=True,
                timeout=PROMPT_S / 2,
            )
            name = "Ctrl-C" if number == signal.SIGINT else number.name
            self.assertEqual((ended.returncode, ended.stderr), (128 + number, f"copepod: stopped by {name}.\n"))

    def test_the_token_of_a_run_is_on_no_command_line(self):
        session = self.start_long_run()
        processes = session.processes()
        tokens = {variables["COPEPOD_SESSION"] for variables in processes.values()}
        self.assertEqual([len(token) for token in tokens], [32])
        for pid in processes:
            self.assertNotIn(tokens.copy().pop(), Path(f"/proc/{pid}/cmdline").read_text())

    def test_signals_that_end_a_run(self):
        for number, name in ((signal.SIGTERM, "SIGTERM"), (signal.SIGHUP, "SIGHUP")):
            session = self.start_long_run("--out", name)
            session.process.send_signal(number)
            self.assert_ends(session, 128 + number)
            self.assertIn(f"stopped by {name}", session.last_line)

    def test_killed_command_takes_everything_along(self):
        session = self.start_long_run("--body", f"{FAKES}/body_service --stubborn")
        session.process.kill()
        session.end()
        session.wait_until_clean()

    def events_of(self, session):
        """Everything on stderr, each line an object."""
        return [json.loads(line) for line in session.stderr]

    def test_for_programs_every_line_is_an_object(self):
        json_lines = ("--progress", "json")
        session = self.start("run", self.case(steps=5, warnings=["slow"]), *json_lines)
        self.assert_ends(session, 0)
        said = self.events_of(session)
        self.assertIn({"event": "notice", "text": "slow"}, said)
        self.assertEqual({event["event"] for event in said}, {"directory", "notice", "phase", "progress"})
        session = self.start(
            "run", self.case(reports=False), *json_lines, "--fluid", f"{FAKES}/fluid_service --fail-with 70"
        )
        self.assertEqual(session.end(), 70)
        self.assertIn("density is not a number", self.events_of(session)[-1]["text"])
        session = self.start("run", self.case(errors=["radius is zero (…). Give one."]), *json_lines)
        self.assertEqual(session.end(), 2)
        self.assertIn("case.yaml:1: error: radius", self.events_of(session)[0]["text"])

    def test_run_goes_on_when_nobody_reads_its_progress_any_more(self):
        script = f"{COMMAND} run {self.case(steps=100)} --out here 2>&1 | head -1; echo ${{PIPESTATUS[0]}} > code"
        environment = {**os.environ, "COPEPOD_BIN_DIR": str(FAKES)}
        subprocess.run(["bash", "-c", script], cwd=self.folder, env=environment, stdout=subprocess.DEVNULL, timeout=30)
        self.assertTrue((self.folder / "here/summary.json").exists())

    def test_name_of_a_case_cannot_lead_out_of_the_runs_folder(self):
        self.assert_ends(self.start("run", self.case(name="../up/a b", steps=1)), 0)
        self.assertTrue((self.folder / "runs/_up_a_b/summary.json").exists())

    def test_run_directory_with_a_long_name(self):
        out = self.folder / ("long_" * 30)
        self.assert_ends(self.start("run", self.case(steps=2), "--out", out), 0)

    def test_command_works_through_a_symbolic_link(self):
        (self.folder / "linked").symlink_to(COMMAND)
        environment = {**os.environ, "COPEPOD_BIN_DIR": str(FAKES)}
        answer = subprocess.run(
            ["./linked", "check", self.case()], cwd=self.folder, env=environment, stdout=subprocess.PIPE, text=True
        )
        self.assertEqual(answer.returncode, 0)
        self.assertIn("relaxation time", answer.stdout)


if __name__ == "__main__":
    unittest.main()
