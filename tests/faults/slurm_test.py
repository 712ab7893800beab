"""Jobs of deploy/slurm/copepod.sbatch in a Slurm cluster: whatever happens to one, it ends with the same digest."""

import re
import shutil
import signal
import tempfile
import time
import unittest
from pathlib import Path

import slurm_hosts
from hurt_hosts import CLEAN_WITHIN_S
from hurt_run import LONGEST_S, HurtRun, digest, wait_for
from slurm_hosts import PATIENCE_S, SILENCE_S, STEPS, Job, SlurmHosts, settings
from three_hosts import NAMES

MORE_STEPS = 300  # some seconds
SUSPENDED_S = SILENCE_S + 4  # longer than a host that is not suspended waits for the others


@unittest.skipIf(slurm_hosts.missing(), slurm_hosts.missing())
class SlurmJobs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="copepod_slurm_", dir="/var/tmp")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name).resolve()
        cls.digest = {steps: cls.digest_without_slurm(steps) for steps in (STEPS, MORE_STEPS)}
        cls.hosts = SlurmHosts(cls.folder)
        cls.addClassCleanup(cls.hosts.close)

    @classmethod
    def digest_without_slurm(cls, steps):
        with tempfile.TemporaryDirectory(dir=cls.folder) as folder:
            run = HurtRun(folder, "--out", "out", *settings(steps))
            assert run.end(LONGEST_S) == 0, "".join(run.stderr)
            return digest(Path(folder))

    def setUp(self):
        self.start = time.monotonic()
        self.addCleanup(lambda: print(f"{time.monotonic() - self.start:.1f} s"))

    def job(self, nodes, folder="", **arguments):
        job = Job(self.hosts, self.folder / (folder or f"{self._testMethodName}_{nodes}"), nodes, **arguments)
        self.addCleanup(job.cancel)
        return job

    def assert_completes(self, job, restarts=0):
        """A halted job ends well."""
        job.let_go()
        job.wait_for(JobState="COMPLETED", Restarts=str(restarts))
        self.assertEqual(job.summary["digest"], self.digest[job.steps])

    def assert_nothing_left(self):
        """On any node."""
        wait_for(lambda: not self.hosts.left(), CLEAN_WITHIN_S)
        self.assertEqual(self.hosts.left(), [])

    def test_one_node(self):
        job = self.job(1)
        job.wait_until_halted()
        self.assertEqual([job.ranks(name) for name in NAMES], [set(), {0, 1}, set()])
        self.assert_completes(job)
        self.assert_nothing_left()

    def test_two_nodes_have_a_rank_each(self):
        job = self.job(2)
        job.wait_until_halted()
        self.assertEqual([job.ranks(name) for name in NAMES], [set(), {0}, {1}])
        self.assert_completes(job)
        self.assert_nothing_left()

    def test_cancelled_job_stays_cancelled(self):
        job = self.job(2)
        job.wait_until_halted()
        job.cancel()
        job.wait_for(JobState="CANCELLED", Restarts="0")
        self.assert_nothing_left()
        self.assertEqual(job.record["JobState"], "CANCELLED")

    def test_job_writes_a_checkpoint_before_its_time_limit_and_is_queued_again(self):
        job = self.job(2, halt=("save", 20), steps=MORE_STEPS)
        job.wait_until_halted()
        job.set_time_limit(1)
        warning = rf"sent signal {signal.SIGUSR1} to pid \d+ StepId={job.number}\.batch"
        self.assertTrue(wait_for(lambda: re.search(warning, self.hosts.log("b")), PATIENCE_S), "no warning")
        job.set_time_limit(60)
        job.let_go()
        job.wait_until_halted(restarts=1)
        self.assert_completes(job, 1)
        self.assertGreaterEqual(job.summary["resumed_from_step"], 20)
        self.assert_nothing_left()

    def test_job_that_is_queued_again_before_its_first_checkpoint_starts_anew(self):
        job = self.job(2, halt=("construct", 0))
        job.wait_until_halted()
        job.control("requeue")
        job.wait_for(JobState="PENDING")
        job.let_go()
        job.wait_until_halted(restarts=1)
        self.assert_completes(job, 1)
        self.assertIsNone(job.summary["resumed_from_step"])
        self.assertEqual(len(list(job.folder.glob(f"runs/job-{job.number}-until-*"))), 1)
        self.assert_nothing_left()

    def test_node_that_fails_is_replaced(self):
        for lost, nodes_then in (("c", "a,b"), ("b", "a,c")):
            with self.subTest(lost=lost):
                job = self.job(2, folder=f"without_{lost}")
                job.wait_until_halted()
                self.hosts.crash(lost)
                self.addCleanup(self.hosts.restart, lost)
                if lost == "c":  # the run notices, and queues the job again; the first node takes the run with it
                    job.wait_for(Restarts="1")
                    self.assertIn("copepod: guard on host c, ", job.log)
                self.hosts.set_down(lost)
                job.let_go()
                job.wait_until_halted(restarts=1)
                self.assertEqual(job.record["NodeList"], nodes_then)
                self.assert_completes(job, 1)
                self.assertEqual(job.summary["resumed_from_step"], 40)
                self.doCleanups()
                self.assert_nothing_left()

    def test_node_that_refuses_the_first_steps_is_asked_again(self):
        programs = self.folder / "refusing"
        programs.mkdir()
        stand_in = programs / "srun"
        refusal = "echo 'srun: error: Application launch failed: Job credential revoked' >&2; exit 1"
        asked = f"echo >>{programs}/asked; [ $(wc -l <{programs}/asked) -gt 2 ]"
        stand_in.write_text(f'#!/bin/sh\n{asked} || {{ {refusal}; }}\nexec {shutil.which("srun")} "$@"\n')
        stand_in.chmod(0o755)
        job = self.job(2, programs=programs)
        job.wait_until_halted()
        self.assert_completes(job)
        self.assert_nothing_left()

    def test_suspended_jobs_continue(self):
        jobs = [self.job(1), self.job(2)]
        for job in jobs:
            job.wait_until_halted()
        for job in jobs:
            job.control("suspend")
        stopped = wait_for(lambda: all(job.states(name) <= {"T"} for job in jobs for name in NAMES), PATIENCE_S)
        self.assertTrue(stopped, [job.states(name) for job in jobs for name in NAMES])
        time.sleep(SUSPENDED_S)
        for job in jobs:
            job.control("resume")
        for job in jobs:
            job.wait_for(JobState="RUNNING")
            self.assert_completes(job)
        self.assert_nothing_left()


if __name__ == "__main__":
    unittest.main()
