"""The life of a run under `copepod run`, with components that have no physics: every way to end, and what is left."""

import json
import os
import signal
import subprocess
import time
import unittest

from copepod_session import COMMAND, FAKES, CommandTest

STOPPED_S = 0.7  # half of what the command tolerates
LONG = {"name": "tiny", "steps": 3000, "step_s": 0.01, "ranks": 2}


class RunLifecycle(CommandTest):
    def case(self, **changes):
        path = self.folder / "case.yaml"
        path.write_text(json.dumps({**LONG, **changes}))
        return path.name

    def start_long_run(self, *arguments, **changes):
        session = self.start("run", self.case(**changes), *arguments)
        session.wait_for("copepod: step 0 of")
        if "checkpoint_at" in changes:
            session.wait_for_file("**/checkpoints/*/manifest.json")
        return session

    def test_finished_run_prints_table_and_returns_zero(self):
        session = self.start("run", self.case(steps=5, summary={"mlups": 12.5}))
        self.assert_ends(session, 0)
        self.assertIn("12.5 MLUPS", "".join(session.stdout))
        self.assertIn("results in runs/tiny", "".join(session.stdout))
        self.assertTrue((self.folder / "runs/tiny/summary.json").exists())

    def test_bad_case_shows_every_error_and_leaves_nothing(self):
        session = self.start("run", self.case(errors=["radius is zero (…). Give one.", "unknown key «fluit» (…). …"]))
        self.assert_ends(session, 2)
        self.assertIn("case.yaml:1: error: radius", session.stderr[0])
        self.assertIn("case.yaml:2: error: unknown", session.stderr[1])
        self.assertFalse((self.folder / "runs").exists())

    def test_missing_replacement_is_found_before_anything_starts(self):
        session = self.start("run", self.case(), "--fluid", "no_such_solver --fast")
        self.assert_ends(session, 2)
        self.assertIn("no_such_solver", session.last_line)
        self.assertFalse((self.folder / "runs").exists())

    def test_empty_command_and_no_number_are_refused_on_the_command_line(self):
        for arguments, words in (
            (("--fluid", ""), "--fluid: the command is empty (a variable that is not set?). Name a program."),
            (("--body", " "), "--body: the command is empty"),
            (("--ranks", "abc"), "--ranks: «abc» is not a valid rank count (integer ≥ 1)"),
            (("--restarts", "-1"), "--restarts: «-1» is not a valid number (integer ≥ 0)"),
        ):
            session = self.start("run", self.case(), *arguments)
            self.assert_ends(session, 2)
            self.assertIn(words, session.last_line)
        self.assertFalse((self.folder / "runs").exists())

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

    def test_refused_resume_is_not_advised_to_resume(self):
        self.assert_ends(self.start("run", self.case(steps=1, checkpoint_at=1)), 0)
        session = self.start("run", self.case(fail=73), "--resume")
        self.assert_ends(session, 73)
        self.assertNotIn("--resume", session.last_line)

    def test_resume_that_fails_where_it_starts_is_not_advised_again(self):
        self.assert_ends(self.start("run", self.case(steps=1, checkpoint_at=1)), 0)
        script = self.component("exit 3")
        session = self.start("run", self.case(reports=False), "--body", script, "--resume")
        self.assert_ends(session, 69)
        self.assertIn("exited with code 3 without reporting an error. See its log runs/tiny/logs/", session.last_line)
        self.assertNotIn("--resume", session.last_line)

    def test_component_of_the_other_role_is_refused_before_the_run(self):
        session = self.start("run", self.case(), "--body", f"{FAKES}/fluid_service")
        self.assert_ends(session, 2)
        self.assertIn("cannot be used as body component (it is a fluid component). Use --fluid.", session.last_line)
        self.assertFalse((self.folder / "runs").exists())

    def test_component_estimates_its_memory_before_the_run(self):
        answer = '{"memory_bytes": 1048576000, "problem": "the table of its radii is coarse"}'
        component = self.estimating_component(f"cat > asked; echo '{answer}'")
        session = self.start("check", self.case(), "--body", component)
        self.assert_ends(session, 0)
        self.assertIn("memory           1000 MiB (body 1000)", "".join(session.stdout))
        self.assertIn("warning: body: the table of its radii is coarse", "".join(session.stdout))
        self.assertEqual((self.folder / "asked").read_text(), "setup of body\n")

    def test_component_refuses_a_setup_before_the_run(self):
        refusal = "7 ranks cannot divide 24 cells (a rank needs at least 4 layers). Use 6."
        component = self.estimating_component(f"echo 'error: {refusal}' >&2; exit 2")
        for command in ("check", "run"):
            session = self.start(command, self.case(), "--body", component)
            self.assert_ends(session, 2)
            self.assertIn(refusal, "".join([*session.stdout, *session.stderr]))
        self.assertFalse((self.folder / "runs").exists())

    def estimating_component(self, commands):
        """A body component that answers --capabilities, and --estimate with `commands` of bash."""
        announced = '{"name": "own", "role": "body", "features": ["estimate"]}'
        script = self.folder / "estimates.sh"
        script.write_text(f"#!/bin/bash\n[ $1 = --capabilities ] && echo '{announced}' && exit\n{commands}\n")
        script.chmod(0o755)
        return script

    def component(self, commands):
        """A body component that answers --capabilities, and otherwise carries out `commands` of bash."""
        script = self.folder / "body.sh"
        script.write_text(
            f'#!/bin/bash\n[ "$1" = --capabilities ] && exec {FAKES}/body_service --capabilities\n{commands}\n'
        )
        script.chmod(0o755)
        return script

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

    def test_next_run_waits_until_a_killed_command_is_cleaned_up_after(self):
        session = self.start_long_run("--body", f"{FAKES}/body_service --stubborn", "--out", "here", checkpoint_at=5)
        session.process.kill()
        second = self.start("run", self.case(steps=5), "--out", "here", "--resume")
        self.assert_ends(second, 0)
        session.end()
        self.assert_nothing_left(session)

    def test_ctrl_c_keeps_the_run_directory(self):
        session = self.start_long_run()
        os.killpg(session.process.pid, signal.SIGINT)
        self.assert_ends(session, 130)
        self.assertIn("stopped by Ctrl-C", session.last_line)
        provenance = json.loads((self.folder / "runs/tiny/provenance.json").read_text())
        self.assertEqual(provenance["exit_code"], 130)

    def test_ctrl_c_in_the_first_moment(self):
        """A Ctrl-C that comes before our first line must not end in a traceback of Python's."""
        self.case(steps=5)
        for milliseconds in (0, 5, 10, 20, 30, 40, 60, 80, 100, 150):
            session = self.start("check", "case.yaml")
            time.sleep(milliseconds * 1e-3)
            os.killpg(session.process.pid, signal.SIGINT)
            self.assertIn(session.end(), (0, 130, -signal.SIGINT), "".join(session.stderr))
            self.assertNotIn("Traceback", "".join(session.stderr))

    def test_sigterm(self):
        session = self.start_long_run()
        session.process.send_signal(signal.SIGTERM)
        self.assert_ends(session, 143)

    def test_killed_command_takes_everything_along(self):
        session = self.start_long_run("--body", f"{FAKES}/body_service --stubborn")
        session.process.kill()
        session.end()
        session.wait_until_clean()

    def test_second_run_gets_a_number(self):
        for expected in ("runs/tiny", "runs/tiny-2", "runs/tiny-3"):
            self.assert_ends(self.start("run", self.case(steps=1)), 0)
            self.assertTrue((self.folder / expected / "summary.json").exists())

    def test_existing_out_is_never_overwritten(self):
        self.assert_ends(self.start("run", self.case(steps=1), "--out", "here"), 0)
        session = self.start("run", self.case(steps=1), "--out", "here")
        self.assert_ends(session, 2)
        self.assertIn("--resume", session.last_line)

    def test_two_commands_cannot_share_a_directory(self):
        self.start_long_run("--out", "here")
        second = self.start("run", "case.yaml", "--out", "here", "--resume")
        self.assertEqual(second.end(), 2)
        self.assertIn("in use", second.last_line)

    def test_resume_goes_on_in_the_latest_directory(self):
        for _ in range(2):
            self.assert_ends(self.start("run", self.case(steps=1, checkpoint_at=1)), 0)
        self.assert_ends(self.start("run", self.case(steps=1), "--resume"), 0)
        self.assertTrue((self.folder / "runs/tiny-2/resumed").exists())
        self.assertFalse((self.folder / "runs/tiny-3").exists())

    def test_resume_of_nothing_is_an_error(self):
        session = self.start("run", self.case(), "--resume")
        self.assert_ends(session, 2)
        self.assertIn("does not hold a run", session.last_line)

    def test_resume_without_a_checkpoint_is_an_error_and_changes_nothing(self):
        self.assert_ends(self.start("run", self.case(steps=1)), 0)
        before = (self.folder / "runs/tiny/summary.json").stat().st_mtime_ns
        session = self.start("run", self.case(steps=1), "--resume")
        self.assert_ends(session, 2)
        self.assertIn("no checkpoint", session.last_line)
        self.assertEqual((self.folder / "runs/tiny/summary.json").stat().st_mtime_ns, before)

    def test_restart_goes_on_from_the_checkpoint(self):
        session = self.start_long_run("--restarts", "1", steps=100, checkpoint_at=5)
        session.kill(signal.SIGKILL, "body")
        session.wait_for("starting again from the last checkpoint")
        self.assertEqual(session.end(), 0, "".join(session.stderr))
        self.assertTrue((self.folder / "runs/tiny/resumed").exists())
        self.assert_nothing_left(session)

    def test_nothing_is_restarted_that_would_end_in_the_same_way_or_that_somebody_stopped(self):
        failing = f"{FAKES}/fluid_service --fail-with 70"
        session = self.start("run", self.case(reports=False, ranks=1), "--fluid", failing, "--restarts", "3")
        self.assertEqual(session.end(), 70)
        self.assertNotIn("starting again", "".join(session.stderr))
        session = self.start_long_run("--restarts", "3")
        session.process.send_signal(signal.SIGTERM)
        self.assert_ends(session, 143)
        self.assertNotIn("starting again", "".join(session.stderr))

    def events_of(self, session):
        """Everything on stderr, each line an object."""
        return [json.loads(line) for line in session.stderr]

    def test_for_programs_every_line_is_an_object(self):
        json_lines = ("--progress", "json")
        session = self.start("run", self.case(steps=5, warnings=["slow"]), *json_lines)
        self.assert_ends(session, 0)
        said = self.events_of(session)
        self.assertIn({"event": "notice", "text": "slow"}, said)
        self.assertEqual({event["event"] for event in said}, {"notice", "phase", "progress"})
        session = self.start(
            "run", self.case(reports=False), *json_lines, "--fluid", f"{FAKES}/fluid_service --fail-with 70"
        )
        self.assertEqual(session.end(), 70)
        self.assertIn("density is not a number", self.events_of(session)[-1]["text"])
        session = self.start("run", self.case(errors=["radius is zero (…). Give one."]), *json_lines)
        self.assertEqual(session.end(), 2)
        self.assertIn("case.yaml:1: error: radius", self.events_of(session)[0]["text"])

    def test_options_that_a_sweep_does_not_have_are_refused_by_name(self):
        sweep = {"key": "a.b", "members": [{"value": 1, "set": []}]}
        for words in (("--resume",), ("--restarts", "2"), ("--progress", "json")):
            session = self.start("run", self.case(sweep=sweep), *words)
            self.assert_ends(session, 2)
            self.assertIn(f"{words[0]} is not for sweeps", session.last_line)

    def test_restarts_come_to_an_end(self):
        session = self.start_long_run("--restarts", "1", checkpoint_at=5)
        session.kill(signal.SIGKILL, "body")
        session.wait_for("copepod: running", times=2)
        session.kill(signal.SIGKILL, "body")
        self.assert_ends(session, 69)
        self.assertEqual("".join(session.stderr).count("1 restart(s) left"), 1)

    def test_last_line_tells_how_to_go_on(self):
        session = self.start_long_run("--set", "extra=1", checkpoint_at=5)
        session.kill(signal.SIGKILL, "body")
        self.assert_ends(session, 69)
        self.assertIn("run case.yaml --out runs/tiny --set extra=1 --resume", session.last_line)

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

    def test_run_directory_whose_name_is_no_text_is_refused_before_it_is_made(self):
        out = os.fsdecode(os.fsencode(self.folder) + b"/m\xfcnchen")
        session = self.start("run", self.case(steps=2), "--out", out)
        self.assert_ends(session, 2)
        self.assertIn("m\\xfcnchen cannot be the folder of a run (its name is not UTF-8 text)", session.last_line)
        self.assertFalse(os.path.exists(out))

    def test_command_works_through_a_symbolic_link(self):
        (self.folder / "linked").symlink_to(COMMAND)
        environment = {**os.environ, "COPEPOD_BIN_DIR": str(FAKES)}
        answer = subprocess.run(
            ["./linked", "check", self.case()], cwd=self.folder, env=environment, stdout=subprocess.PIPE, text=True
        )
        self.assertEqual(answer.returncode, 0)
        self.assertIn("relaxation time", answer.stdout)

    def test_check_refuses_what_a_component_cannot_do(self):
        session = self.start("check", self.case(requires=["collision:bgk", "collision:cumulant"]))
        self.assertEqual(session.end(), 2)
        self.assertIn("collision:cumulant", "".join(session.stdout))
        self.assertNotIn("«collision:bgk»", "".join(session.stdout))

    def test_check_refuses_what_is_no_component_of_the_role(self):
        for arguments, words in (
            (
                ("--fluid", "/bin/true"),
                "error: /bin/true cannot be used as fluid component (it does not answer --capabilities",
            ),
            (
                ("--body", f"{FAKES}/fluid_service"),
                "error: fake fluid cannot be used as body component (it is a fluid component). Use --fluid.",
            ),
        ):
            session = self.start("check", self.case(), *arguments)
            self.assertEqual(session.end(), 2)
            self.assertIn(words, "".join(session.stdout))
            self.assertNotIn("ok\n", session.stdout)


if __name__ == "__main__":
    unittest.main()
