"""Places that cannot be written to: one sentence with a remedy, and exit code 73."""

import fcntl
import json
import os
import signal
import subprocess
import unittest

from copepod_session import COMMAND, FAKES, CommandTest, wait_until


class Storage(CommandTest):
    def setUp(self):
        super().setUp()
        (self.folder / "case.yaml").write_text(json.dumps({"name": "tiny", "steps": 5, "ranks": 1}))
        (self.folder / "file").touch()

    def assert_refused(self, *arguments, words, code=73):
        session = self.start(*arguments)
        self.assert_ends(session, code)
        self.assertNotIn("Traceback", "".join(session.stderr))
        self.assertIn(words, session.last_line)

    def as_nobody(self, *arguments):
        """Exit code and last line of a command of another user, who may write nowhere here."""
        self.folder.chmod(0o755)
        answer = subprocess.run(
            [COMMAND, *arguments],
            cwd=self.folder,
            env={**os.environ, "COPEPOD_BIN_DIR": str(FAKES), "HOME": "/"},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            user="nobody",
        )
        return answer.returncode, answer.stderr.splitlines()[-1]

    def test_name_that_is_too_long(self):
        self.assert_refused("run", "case.yaml", "--out", "x" * 256, words="File name too long). Choose another --out.")
        self.assert_refused("run", "case.yaml", "--resume", "--out", "x" * 256, words="Choose another --out.")

    @unittest.skipIf(os.geteuid() != 0, "changes to another user")
    def test_folder_of_somebody_else(self):
        (self.folder / "there").mkdir()
        code, said = self.as_nobody("run", "case.yaml", "--out", "there")
        self.assertEqual(code, 73, said)
        self.assertIn("there cannot be written to (Permission denied). Choose another --out", said)
        (self.folder / "there/case.yaml").touch()
        code, said = self.as_nobody("run", "case.yaml", "--resume", "--out", "there")
        self.assertEqual(code, 73, said)
        self.assertIn("copy its folder first", said)

    def test_file_where_a_folder_is_to_be(self):
        (self.folder / "campaign.json").write_text(json.dumps({"name": "c", "cases": []}))
        self.assert_refused("campaign", "campaign.json", "--out", "file", words="file cannot be made (File exists)")

    def test_report_into_a_file(self):
        from synthetic_run import write_run

        write_run(self.folder / "run", mean_flow=False)
        self.assert_refused("report", "run", "--out", "file", words="file cannot be made (File exists)")

    def test_table_of_a_conformance_test_is_to_go_nowhere(self):
        words = "nosuch/j.xml cannot be written (its folder is missing or read-only). Choose another --junit."
        self.assert_refused("conformance", "--role", "body", "--junit", "nosuch/j.xml", "--", "sleep", words=words)

    def test_standard_output_on_a_full_disk(self):
        with open("/dev/full", "w") as full:
            answer = subprocess.run(
                [COMMAND, "check", "case.yaml"],
                cwd=self.folder,
                env={**os.environ, "COPEPOD_BIN_DIR": str(FAKES)},
                stdin=subprocess.DEVNULL,
                stdout=full,
                stderr=subprocess.PIPE,
                text=True,
            )
        self.assertEqual(answer.returncode, 73, answer.stderr)
        self.assertEqual(
            answer.stderr,
            "copepod: the output cannot be used (No space left on device). Free space on that disk and run again.\n",
        )

    def test_standard_error_on_a_full_disk_ends_no_run(self):
        script = f"{COMMAND} run case.yaml --out here 2>/dev/full"
        environment = {**os.environ, "COPEPOD_BIN_DIR": str(FAKES)}
        code = subprocess.run(
            ["bash", "-c", script], cwd=self.folder, env=environment, stdout=subprocess.DEVNULL
        ).returncode
        self.assertEqual(code, 0)
        self.assertTrue((self.folder / "here/summary.json").exists())

    def test_closed_outputs_end_no_command(self):
        environment = {**os.environ, "COPEPOD_BIN_DIR": str(FAKES)}
        for number, closed in enumerate(("1>&-", "2>&-", "0<&- 1>&- 2>&-")):
            for command in (f"run case.yaml --out here{number}", "check case.yaml"):
                script = f"{COMMAND} {command} {closed}"
                answer = subprocess.run(
                    ["bash", "-c", script], cwd=self.folder, env=environment, capture_output=True, text=True
                )
                self.assertEqual(answer.returncode, 0, script + answer.stderr)
                self.assertNotIn("Traceback", answer.stderr)
            self.assertTrue((self.folder / f"here{number}/summary.json").exists())

    def test_any_locale_will_do(self):
        (self.folder / "case.yaml").write_text(json.dumps({"name": "µ-tiny", "steps": 5, "ranks": 1}))
        for variables in ({"LC_ALL": "C"}, {"PYTHONIOENCODING": "ascii"}, {"LC_ALL": "en_US.ISO-8859-1"}):
            for command in ("check", "run"):
                session = self.start(command, "case.yaml", environment=variables)
                self.assert_ends(session, 0)
                self.assertIn("-tiny", "".join(session.stdout))

    def test_path_need_not_be_set(self):
        environment = {name: value for name, value in os.environ.items() if name != "PATH"}
        answer = subprocess.run(
            [COMMAND, "run", "case.yaml"],
            cwd=self.folder,
            env={**environment, "COPEPOD_BIN_DIR": str(FAKES)},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
        )
        self.assertEqual(answer.returncode, 0, answer.stderr)

    def test_control_characters_of_a_case_reach_no_terminal(self):
        name = "tiny\x1b[2J\x9b2J\u202e"
        (self.folder / "case.yaml").write_text(json.dumps({"name": name, "steps": 5, "warnings": [f"warning: {name}"]}))
        for command in ("check", "run"):
            session = self.start(command, "case.yaml")
            self.assert_ends(session, 0)
            said = "".join([*session.stdout, *session.stderr])
            self.assertIn("tiny\\x1b[2J\\x9b2J\\u202e", said)
            self.assertTrue(all(character == "\n" or character.isprintable() for character in said), said)

    def test_provenance_that_cannot_be_replaced_does_not_hide_how_the_run_ended(self):
        (self.folder / "case.yaml").write_text(json.dumps({"name": "tiny", "steps": 3000, "step_s": 0.01, "ranks": 1}))
        session = self.start("run", "case.yaml")
        session.wait_for("copepod: step 0 of")
        (self.folder / "runs/tiny/provenance.json.new").mkdir()
        session.kill(signal.SIGKILL, "body")
        self.assert_ends(session, 69)
        self.assertIn("body service on host", session.last_line)
        self.assertEqual(json.loads((self.folder / "runs/tiny/provenance.json").read_text())["exit_code"], 69)

    def test_folder_that_another_run_used_while_this_one_waited_is_not_overwritten(self):
        there = self.folder / "there"
        there.mkdir()
        lock = os.open(there, os.O_RDONLY)
        self.addCleanup(os.close, lock)
        fcntl.flock(lock, fcntl.LOCK_EX)
        session = self.start("run", "case.yaml", "--out", "there")
        wait_until(lambda: session.has_open(there), "the command has the folder open")
        (there / "summary.json").write_text("{}")
        fcntl.flock(lock, fcntl.LOCK_UN)
        self.assert_ends(session, 2)
        self.assertIn("there exists already", session.last_line)
        self.assertEqual([path.name for path in there.iterdir()], ["summary.json"])
        fcntl.flock(lock, fcntl.LOCK_EX)  # as a run that has not ended
        second = self.start("run", "case.yaml", "--out", "there")
        self.assert_ends(second, 2)
        self.assertIn("there is in use (another copepod runs there). Wait for it", second.last_line)


if __name__ == "__main__":
    unittest.main()
