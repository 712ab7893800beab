"""Checkpoints of whole runs: on other numbers of ranks, by signals and by the clock, on a full disk, and damaged."""

import os
import resource
import shlex
import shutil
import signal
import subprocess
import tempfile
import unittest
from pathlib import Path

from hurt_run import CASE, PROGRAMS, HurtRun, digest, undisturbed_digest, wait_for
from copepod_session import COMMAND

SECOND_HALF = 500
NEVER = ("--set", "output.checkpoint.every_steps=0")


class Checkpoint(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.digest = undisturbed_digest()

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="copepod_faults_")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name).resolve()

    def start(self, *arguments):
        run = HurtRun(self.folder, "--out", "out", *arguments)
        self.addCleanup(lambda: run.process.poll() is None and (run.process.terminate(), run.end()))
        return run

    def start_halted(self, place, step, *arguments):
        """A run whose fluid stands still at a step until the file `halted` is removed."""
        self.halted = self.folder / "halted"
        words = [PROGRAMS / "halting_fluid", "--halt-in", place, "--halt-at-step", step, "--halt-file", self.halted]
        run = self.start("--fluid", shlex.join(map(str, words)), *arguments)
        self.assertTrue(wait_for(self.halted.exists, 20), "".join(run.stderr))
        return run

    def assert_finishes(self, run):
        self.assertEqual(run.end(60), 0, "".join(run.stderr))
        self.assertEqual(digest(self.folder), self.digest)

    def checkpoints(self):
        return sorted(path.name for path in (self.folder / "out/checkpoints").iterdir())

    def half_a_run(self):
        """A run of two ranks that ended half-way, with checkpoints of steps 300 and 400."""
        run = self.start("--set", f"run.steps={SECOND_HALF}", "--ranks", "2")
        self.assertEqual(run.end(60), 0, "".join(run.stderr))
        self.assertEqual(self.checkpoints(), ["step_000000300", "step_000000400"])

    def test_checkpoint_of_two_ranks_gives_the_same_bits_on_one_two_and_three(self):
        self.half_a_run()
        (self.folder / "out").rename(self.folder / "half")
        for ranks in (1, 2, 3):
            shutil.copytree(self.folder / "half", self.folder / "out")
            self.assert_finishes(self.start("--ranks", ranks, "--resume"))
            shutil.rmtree(self.folder / "out")

    def test_damaged_checkpoint_is_told_and_the_one_before_is_used(self):
        self.half_a_run()
        (self.folder / "out").rename(self.folder / "half")
        newest = self.folder / "out/checkpoints/step_000000400"
        damages = {
            "has changed": lambda: _flip_a_bit(newest / "fluid.h5"),
            "has the wrong size": lambda: os.truncate(newest / "fluid.h5", 1000),
            "has no manifest": lambda: (newest / "manifest.json").unlink(),
        }
        for words, damage in damages.items():
            shutil.copytree(self.folder / "half", self.folder / "out")
            damage()
            run = self.start("--resume")
            self.assert_finishes(run)
            self.assertIn("step_000000400 is left out", "".join(run.stderr))
            self.assertIn(words, "".join(run.stderr))
            shutil.rmtree(self.folder / "out")

    def test_a_file_in_the_place_of_a_checkpoint_costs_no_more_than_that_checkpoint(self):
        self.half_a_run()
        for step in (450, 500):
            (self.folder / f"out/checkpoints/step_{step:09}").write_text("notes")
        run = self.start("--resume")
        self.assert_finishes(run)
        self.assertIn("step_000000450 is left out", "".join(run.stderr))
        self.assertEqual((self.folder / "out/checkpoints/step_000000450").read_text(), "notes")

    def test_links_in_a_run_directory_that_is_resumed_lead_to_no_change_elsewhere(self):
        self.half_a_run()
        notes = self.folder / "notes"
        notes.write_text("not of the run")
        for name in ("case.yaml.unfinished", "summary.json.unfinished", "logs/coupler.log", "logs/body.log"):
            (self.folder / "out" / name).unlink(missing_ok=True)
            (self.folder / "out" / name).symlink_to(notes)
        refused = self.start("--resume")
        self.assertEqual(refused.end(60), 73, "".join(refused.stderr))
        self.assertIn("case.yaml cannot be written (Too many levels of symbolic links)", refused.last_line)
        (self.folder / "out/case.yaml.unfinished").unlink()
        (self.folder / "out/summary.json.unfinished").unlink()
        self.assert_finishes(self.start("--resume"))
        self.assertEqual(notes.read_text(), "not of the run")

    def test_sigusr1_writes_a_checkpoint_and_the_run_goes_on(self):
        run = self.start_halted("advance", 250, *NEVER)
        run.process.send_signal(signal.SIGUSR1)
        self.halted.unlink()
        self.assert_finishes(run)
        self.assertEqual(len(self.checkpoints()), 1)

    def test_a_signal_that_ends_the_run_writes_a_checkpoint_first(self):
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            run = self.start_halted("advance", 250, *NEVER)
            run.process.send_signal(number)
            self.halted.unlink()
            self.assertEqual(run.end(60), 128 + number, "".join(run.stderr))
            self.assertEqual(len(self.checkpoints()), 1)
            self.assert_finishes(self.start("--resume"))
            shutil.rmtree(self.folder / "out")

    def test_wall_time_makes_checkpoints(self):
        run = self.start(*NEVER, "--set", "output.checkpoint.every_wall_s=0.1")
        self.assert_finishes(run)
        self.assertEqual(len(self.checkpoints()), 2)

    def test_disk_that_fills_up_during_a_checkpoint_costs_that_checkpoint_only(self):
        run = self.start_halted("save", 250)
        self.limit_files_of_the_fluid(run, 1 << 20)
        self.halted.unlink()
        run.wait_for("No checkpoint of step 300")
        self.limit_files_of_the_fluid(run, resource.RLIM_INFINITY)
        self.assert_finishes(run)
        self.assertIn("File too large", "".join(run.stderr))
        self.assertEqual(self.checkpoints(), ["step_000000800", "step_000000900"])

    def test_disk_that_stays_full_leaves_the_older_checkpoints(self):
        run = self.start_halted("save", 250)
        self.limit_files_of_the_fluid(run, 1 << 20)
        self.halted.unlink()
        self.assert_finishes(run)
        self.assertEqual(self.checkpoints(), ["step_000000100", "step_000000200"])

    @unittest.skipUnless(os.geteuid() == 0 and shutil.which("unshare"), "mounts a file system")
    def test_disk_without_inodes_is_named_whatever_file_is_the_first_to_lack_one(self):
        codes = set()
        for inodes in range(2, 36):
            mount = f"mount -t tmpfs -o nr_inodes={inodes},size=50m none {self.folder}"
            run = [COMMAND, "run", CASE, "--out", self.folder / "out", "--ranks", "1", "--set", "run.steps=30", *NEVER]
            run += ["--set", "output.bodies.every_steps=10"]
            answer = subprocess.run(
                ["unshare", "--mount", "sh", "-c", f"{mount} && exec {shlex.join(map(str, run))}"],
                env={**os.environ, "COPEPOD_BIN_DIR": str(PROGRAMS)},
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
            )
            codes.add(answer.returncode)
            if answer.returncode == 0:
                break
            self.assertEqual(answer.returncode, 73, f"{inodes}: {answer.stderr}")
            self.assertIn("No space left on device", answer.stderr.splitlines()[-1])
        self.assertEqual(codes, {0, 73})

    def test_ranks_without_shared_memory_report_it(self):
        fluid = self.folder / "fluid"
        own = f'case " $* " in *" --endpoint "*) ulimit -f 0;; esac\nexec {PROGRAMS}/fluid_service "$@"\n'
        fluid.write_text(f"#!/bin/bash\n{own}")
        fluid.chmod(0o755)
        run = self.start("--fluid", str(fluid))
        self.assertEqual(run.end(60), 73, "".join(run.stderr))
        self.assertRegex(run.last_line, "fluid service on host .*the ranks' shared memory cannot be made")

    @staticmethod
    def limit_files_of_the_fluid(run, size):
        """As a quota: no file of rank 0, which lays the checkpoint out, may grow beyond `size` bytes."""
        resource.prlimit(run.pid("fluid 0"), resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))


def _flip_a_bit(path):
    with open(path, "r+b") as file:
        file.seek(-1000, os.SEEK_END)
        byte = file.read(1)[0]
        file.seek(-1000, os.SEEK_END)
        file.write(bytes([byte ^ 4]))


if __name__ == "__main__":
    unittest.main()
