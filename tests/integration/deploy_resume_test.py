"""Run directories in several attempts: numbers, locks, `--resume`, `--restarts`."""

import signal
import unittest

from copepod_session import FAKES, TinyRunTest


class Attempts(TinyRunTest):
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

    def test_next_run_waits_until_a_killed_command_is_cleaned_up_after(self):
        session = self.start_long_run("--body", f"{FAKES}/body_service --stubborn", "--out", "here", checkpoint_at=5)
        session.process.kill()
        second = self.start("run", self.case(steps=5), "--out", "here", "--resume")
        self.assert_ends(second, 0)
        session.end()
        self.assert_nothing_left(session)

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


if __name__ == "__main__":
    unittest.main()
