"""What a command did not make, it never removes or replaces, whatever its name: it is left alone or refused by name."""

import os
import shutil
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

from copepod_session import CommandTest, ROOT, TinyRunTest
from synthetic_run import write_run

from copepod_run import cleanup, scratch
from copepod_run.errors import BadCase
from copepod_run.launcher import guarded_folder
from copepod_run.run_directory import Lock, take_lock

_HOURS_AGO = time.time() - 7200


class FilesTest(TinyRunTest):
    def write_campaign(self):
        """campaign.json with one case, which the stand-ins read from member.json."""
        (self.folder / "campaign.json").write_text('{"name": "fakes", "cases": ["member"]}')
        (self.folder / "member.json").write_text('{"name": "member", "steps": 5, "step_s": 0.01, "case": {}}')


class TemporaryFolders(FilesTest):
    def folder_of(self, where, name, mark=None, mode=0o700):
        """A folder with a file that has lain there for hours; claimed, as a run would, if `mark` is given."""
        folder = Path(where, name)
        folder.mkdir(mode=mode)
        self.addCleanup(shutil.rmtree, folder, ignore_errors=True)
        (folder / "precious").write_text("work of a year")
        if mark:
            cleanup.claim(folder, mark)
        os.utime(folder, (_HOURS_AGO, _HOURS_AGO))
        return folder

    def run_tiny(self):
        session = self.start("run", self.case(steps=5))
        self.assertEqual(session.end(60), 0, "".join(session.stderr))

    def test_folders_with_names_like_those_of_runs_stay(self):
        # Process 2026 is hardly alive, and 4194304 is more than any process id.
        number = os.getpid()
        names = [f"copepod-2026-11-25-{number}", f"copepod-4194304-{number}", f"copepod-4194305-run{number}"]
        folders = [self.folder_of(where, name) for where in ("/tmp", "/dev/shm") for name in names]
        copied = Path(f"/tmp/copepod-4194306-copy{number}")
        self.addCleanup(shutil.rmtree, copied, ignore_errors=True)
        shutil.copytree(self.folder_of("/tmp", f"copepod-4194307-{number}", mark="abandoned"), copied)
        os.utime(copied, (_HOURS_AGO, _HOURS_AGO))
        opened = self.folder_of("/tmp", f"copepod-4194308-{number}", mark="opened")
        opened.chmod(0o755)
        self.run_tiny()
        for folder in [*folders, copied, opened]:
            self.assertEqual((folder / "precious").read_text(), "work of a year", folder)

    def test_a_finished_run_and_a_campaign_in_the_temporary_folder_stay(self):
        for command in (("run", self.case(steps=5)), ("campaign", "campaign.json")):
            self.write_campaign()
            out = Path(tempfile.gettempdir(), f"copepod-4194304-{command[0]}{os.getpid()}")
            self.addCleanup(shutil.rmtree, out, ignore_errors=True)
            session = self.start(*command, "--out", out)
            self.assertEqual(session.end(60), 0, "".join(session.stderr))
            before = sorted(out.rglob("*"))
            os.utime(out, (_HOURS_AGO, _HOURS_AGO))
            self.run_tiny()
            self.assertEqual(sorted(out.rglob("*")), before)

    def test_the_folder_of_a_killed_run_goes_once_nothing_holds_it(self):
        folder = self.folder_of("/tmp", f"copepod-4194304-{os.getpid()}", mark="killed")
        lock = os.open(folder, os.O_RDONLY)
        self.assertIs(take_lock(lock), Lock.OURS)
        self.run_tiny()
        self.assertTrue(folder.exists())
        os.close(lock)
        self.run_tiny()
        self.assertFalse(folder.exists())

    def test_the_folder_of_a_command_without_a_run_stays_as_long_as_the_command(self):
        """Conformance and replays take longer than the minute in which a folder counts as young."""
        with guarded_folder() as folder:
            os.utime(folder.run_path, (_HOURS_AGO, _HOURS_AGO))
            self.run_tiny()
            self.assertTrue(folder.run_path.exists())
        self.assertFalse(folder.run_path.exists())


class RunDirectory(TinyRunTest):
    def setUp(self):
        super().setUp()
        self.scratch = scratch.Scratch(self.folder, "mark")
        self.addCleanup(self.scratch.close)
        self.addCleanup(lambda: cleanup.remove_folders(self.scratch.folders))
        self.path = self.folder / ".keys"

    def test_a_folder_in_place_of_the_keys_is_refused_and_stays(self):
        (self.folder / "elsewhere").mkdir()
        for make in (lambda: self.path.symlink_to(self.folder / "elsewhere"), self.path.mkdir):
            make()
            (self.path / "precious").write_text("work of a year")
            with self.assertRaisesRegex(BadCase, r"\.keys is in the way \(not made by a run\)\. Move it away"):
                self.scratch.keys("tcp://127.0.0.1:1", ["fluid", "body"])
            self.assertEqual((self.path / "precious").read_text(), "work of a year")
            if self.path.is_symlink():
                self.path.unlink()

    def test_an_empty_folder_of_a_killed_run_is_no_obstacle(self):
        self.path.mkdir()
        keys = self.scratch.keys("tcp://127.0.0.1:1", ["fluid", "body"])
        self.assertEqual({file.parent for file in keys.values()}, {self.path})
        cleanup.remove_folders(self.scratch.folders)
        self.assertFalse(self.path.exists())


class WithoutLocks(FilesTest):
    """On a file system that has no locks, as some network disks."""

    def setUp(self):
        super().setUp()
        source, self.library = self.folder / "no_locks.c", self.folder / "no_locks.so"
        source.write_text("#include <errno.h>\nint flock(int f, int o) { errno = ENOLCK; return -1; }\n")
        subprocess.run(["cc", "-shared", "-fPIC", "-o", self.library, source], check=True)

    def start_without_locks(self, *arguments):
        return self.start(*arguments, environment={"LD_PRELOAD": str(self.library)}.items())

    def test_runs_and_campaigns_finish_and_say_so(self):
        self.write_campaign()
        for arguments in (("run", self.case(steps=5)), ("campaign", "campaign.json", "--out", "out")):
            for again in range(2):
                session = self.start_without_locks(*arguments)
                self.assertEqual(session.end(60), 0, "".join(session.stderr))
            if arguments[0] == "run":
                self.assertIn("cannot be locked (its file system has no locks)", "".join(session.stderr))

    def test_an_interrupted_run_is_no_longer_shown_as_running_after_a_minute(self):
        script = (
            "from pathlib import Path; from copepod_report import run_status as s; print(s.state_of(Path('run'))[0])"
        )
        progress = self.folder / "run/logs/progress.json"
        progress.parent.mkdir(parents=True)
        progress.write_text("{}")
        variables = {**os.environ, "LD_PRELOAD": str(self.library), "PYTHONPATH": str(ROOT / "deploy")}
        for age_s, state in ((0, "running"), (100, "interrupted")):
            os.utime(progress, (time.time() - age_s,) * 2)
            words = ["/usr/bin/python3", "-c", script]
            found = subprocess.run(words, cwd=self.folder, env=variables, capture_output=True, text=True, check=True)
            self.assertEqual(found.stdout.strip(), state)


class Campaign(FilesTest):
    def test_files_in_the_folders_of_its_cases_and_programs_stay(self):
        self.write_campaign()
        precious = [self.folder / "out" / name / "precious" for name in ("programs", "programs/new", "member/logs")]
        for path in precious:
            path.parent.mkdir(parents=True)
            path.write_text("work of a year")
        session = self.start("campaign", "campaign.json", "--out", "out")
        self.assertEqual(session.end(60), 0, "".join(session.stderr))
        precious[2] = self.folder / "out/member.before-1/logs/precious"
        for path in precious:
            self.assertEqual(path.read_text(), "work of a year")


class Report(CommandTest):
    def test_files_of_others_are_refused_and_those_of_a_report_replaced(self):
        write_run(self.folder / "run", mean_flow=False)
        for name in ("report.html", "design_a_swimmer_arms.png"):
            folder = self.folder / f"for_{name}"
            folder.mkdir()
            (folder / name).write_text("work of a year")
            session = self.start("report", "run", "--out", folder)
            self.assertEqual(session.end(100), 2, "".join(session.stderr))
            self.assertIn(f"{name} is in the way (not written by a report)", session.last_line)
            self.assertEqual((folder / name).read_text(), "work of a year")
        for _ in range(2):
            session = self.start("report", "run")
            self.assertEqual(session.end(100), 0, "".join(session.stderr))


if __name__ == "__main__":
    unittest.main()
