"""deploy/slurm/copepod.sbatch as Slurm would run it: time limit, cancellation, and a job that is queued again."""

import os
import re
import signal
import unittest

from copepod_session import COMMAND, ROOT, TinyRunTest

SCRIPT = ROOT / "deploy/slurm/copepod.sbatch"
BEFORE_TIME_LIMIT = getattr(signal, "SIG" + re.search(r"#SBATCH --signal=B:(\w+)@", SCRIPT.read_text())[1])
OUT = "runs/job-7"


class SlurmScript(TinyRunTest):
    def setUp(self):
        super().setUp()
        (self.folder / "bin").mkdir()
        self.install("scontrol", f'echo "$@" >> {self.folder}/scontrol_calls')
        self.install("srun", f'echo "$@" >> {self.folder}/srun_calls')

    def install(self, program, commands):
        """A program of Slurm as the job finds it: `commands` of sh."""
        path = self.folder / "bin" / program
        path.write_text(f"#!/bin/sh\n{commands}\n")
        path.chmod(0o755)

    def start_job(self, command=COMMAND, more_variables=(), **changes):
        variables = {
            "PATH": f"{self.folder}/bin:{os.environ['PATH']}",
            "COPEPOD": str(command),
            "SLURM_JOB_ID": "7",
            "SLURM_CPUS_PER_TASK": "1",
            **dict(more_variables),
        }
        return self.start(SCRIPT, self.case(**changes), environment=variables, program="/bin/bash")

    def start_long_job(self, **changes):
        job = self.start_job(**changes)
        job.wait_for("copepod: step 0 of")
        if "checkpoint_at" in changes:
            job.wait_for_file("**/checkpoints/*/manifest.json")
        return job

    def calls_of(self, program):
        calls = self.folder / f"{program}_calls"
        return calls.read_text().splitlines() if calls.exists() else []

    def requeued(self):
        return self.calls_of("scontrol")

    def test_job_is_queued_again_before_its_time_limit_and_continues(self):
        job = self.start_long_job(checkpoint_at=5)
        job.process.send_signal(BEFORE_TIME_LIMIT)
        self.assert_ends(job, 143)
        self.assertEqual(self.requeued(), ["requeue 7"])
        self.assert_ends(self.start_job(steps=5), 0)
        self.assertTrue((self.folder / OUT / "resumed").exists())

    def test_job_that_is_queued_again_before_its_first_checkpoint_starts_anew(self):
        job = self.start_long_job()
        job.process.send_signal(BEFORE_TIME_LIMIT)
        self.assert_ends(job, 143)
        self.assert_ends(self.start_job(steps=5), 0)
        self.assertTrue((self.folder / OUT / "summary.json").exists())
        self.assertEqual(len(list((self.folder / "runs").glob("job-7-until-*/provenance.json"))), 1)

    def test_cancelled_job_stays_cancelled(self):
        job = self.start_long_job(checkpoint_at=5)
        job.process.send_signal(signal.SIGTERM)
        self.assert_ends(job, 143)
        self.assertEqual(self.requeued(), [])

    def test_job_that_is_cancelled_while_it_ends_stays_cancelled(self):
        command = self.folder / "slow"
        command.write_text(  # bash loses a signal that comes while it handles another of the kind
            "#!/bin/bash\nsignals=0\ntrap 'signals=$((signals + 1))' TERM\ntouch started\n"
            "until [ $signals -ge 1 ]; do sleep 0.01; done\ntouch first_signal\n"
            "until [ $signals -ge 2 ]; do sleep 0.01; done\nexit 143\n"
        )
        command.chmod(0o755)
        job = self.start_job(command)
        job.wait_for_file("started")
        job.process.send_signal(BEFORE_TIME_LIMIT)
        job.wait_for_file("first_signal")
        job.process.send_signal(signal.SIGTERM)
        self.assert_ends(job, 143)
        self.assertEqual(self.requeued(), [])

    def test_several_nodes_are_hosts_with_a_rank_per_core(self):
        self.install("scontrol", '[ "$*" = "show hostnames n[1-2]" ] && printf "n1\\nn2\\n"')
        command = self.folder / "command"
        command.write_text('#!/bin/sh\necho "$@" > arguments\n')
        command.chmod(0o755)
        nodes = {"SLURM_JOB_NUM_NODES": "2", "SLURM_JOB_NODELIST": "n[1-2]", "SLURM_CPUS_PER_TASK": "4"}
        self.assert_ends(self.start_job(command, nodes), 0)
        self.assertIn("--hosts n1:4,n2:4 --out runs/job-7", (self.folder / "arguments").read_text())

    def test_nodes_that_refuse_a_step_are_asked_again(self):
        calls = self.folder / "srun_calls"
        self.install("srun", f'echo "$@" >> {calls}; [ "$(wc -l < {calls})" -ge 2 ]')
        self.lose_a_node(2, "true")
        self.assertEqual(len(self.calls_of("srun")), 2)

    def lose_a_node(self, nodes, commands):
        """Ends a job with what the command reports then, after `commands` of bash."""
        command = self.folder / "command"
        command.write_text(f"#!/bin/bash\n{commands}\nexit 69\n")
        command.chmod(0o755)
        variables = {"SLURM_JOB_NUM_NODES": str(nodes), "SLURM_JOB_NODELIST": "n"}
        self.assert_ends(self.start_job(command, variables), 69)

    def test_job_that_has_lost_a_node_is_queued_again_if_it_has_a_new_checkpoint(self):
        new_checkpoint = f"mkdir -p {OUT}/checkpoints/step_$$; touch {OUT}/checkpoints/step_$$/manifest.json"
        self.lose_a_node(2, new_checkpoint)
        self.assertEqual(self.requeued()[-1:], ["requeue 7"])
        (self.folder / "scontrol_calls").unlink()
        self.lose_a_node(1, new_checkpoint)
        self.lose_a_node(2, "true")
        cancelled = "trap 'exit 69' TERM; kill -TERM $PPID; while :; do sleep 0.01; done"
        self.lose_a_node(2, f"{new_checkpoint}; {cancelled}")
        self.assertNotIn("requeue 7", self.requeued())

    def test_exit_code_of_a_run_that_ends_by_itself_is_that_of_the_job(self):
        self.assert_ends(self.start_job(fail=73), 73)
        self.assertEqual(self.requeued(), [])


if __name__ == "__main__":
    unittest.main()
