"""Which host has which ranks, how others are reached, and what mpirun's reports of lost hosts mean."""

import dataclasses
import os
import signal
import subprocess
import unittest
from unittest import mock

from copepod_session import ROOT, WholeRunTest  # sets the path of our modules

from copepod_run import components, hosts
from copepod_run.errors import ExitCode
from copepod_run.outcome import describe_exit, judge
from copepod_run.plan import Plan
from copepod_run.processes import end_with_parent, family_of

DAEMON_LOST = """
ORTE has lost communication with a remote daemon.

  HNP daemon   : [[24181,0],0] on node a
  Remote daemon: [[24181,0],2] on node c
"""
RANK_KILLED = "mpirun noticed that process rank 1 with PID 7 on node b exited on signal 9 (Killed)."


def plan(*words, ranks=None):
    values = {field.name: None for field in dataclasses.fields(Plan)}
    total = sum(int(word.partition(":")[2] or 1) for word in words) if ranks is None else ranks
    return Plan(**{**values, "hosts": list(words), "fluid_ranks": total, "transport": "ipc"})


class Placement(unittest.TestCase):
    def test_ranks_fill_the_hosts_in_order(self):
        three = plan("here", "b:8", "c")
        self.assertEqual(hosts.placement(three), {"here": 1, "b": 8, "c": 1})
        self.assertIsNone(hosts.host_of_rank_0(three))
        self.assertIn("b slots=8\nc slots=1\n", hosts.hostfile_text(three))
        self.assertEqual(hosts.table(three)[1], ("b", "fluid ranks 1 to 8"))

    def test_host_without_ranks_is_left_alone(self):
        self.assertEqual(hosts.host_of_rank_0(plan("here:0", "b")), "b")
        self.assertEqual(hosts.hostfile_text(plan("here:0", "b")), "b slots=1\n")
        self.assertEqual(hosts.others(plan("here", "b", ranks=1)), [])  # a solver that has one rank
        self.assertEqual(hosts.others(plan()), [])

    @mock.patch.dict(os.environ)
    def test_open_mpi_chooses_its_transport_on_several_hosts_only(self):
        def options(chosen):
            return components.with_ranks(dataclasses.replace(chosen, commands={}), "fluid", ["solver"])[3:-1]

        os.environ.pop("OMPI_MCA_pml", None)
        self.assertEqual(options(plan("here", "b")), [])
        self.assertEqual(options(plan(ranks=2)), ["--oversubscribe", "--mca", "pml", "ob1"])
        os.environ["OMPI_MCA_pml"] = "ucx"
        self.assertEqual(options(plan(ranks=2))[-1], "ucx")

    def test_hosts_that_cannot_be_reached_are_named_with_the_reason(self):
        for way, words in (
            ("/bin/false", "host b cannot be reached (the command ended with 1). This command must"),
            ("ls", "host b cannot be reached (ls: cannot access 'true'"),
            ("/no/program", "host b cannot be reached ([Errno 2] No such file or directory: '/no/program')"),
        ):
            with self.subTest(way=way), mock.patch.dict(os.environ, {"COPEPOD_SSH": way}):
                problems = hosts.problems_of_hosts(plan("here:0", "b", "c"))
                self.assertEqual(len(problems), 2)
                self.assertIn(words, problems[0])
        with mock.patch.dict(os.environ, {"COPEPOD_SSH": "/bin/true"}):
            self.assertEqual(hosts.problems_of_hosts(plan("here:0", "b")), [])


class Processes(unittest.TestCase):
    def test_family_of_a_process_that_ends_while_it_is_looked_at_is_the_process_itself(self):
        with mock.patch("os.scandir", side_effect=FileNotFoundError):
            self.assertEqual(family_of(os.getpid()), [os.getpid()])

    def test_family_has_children_and_their_children(self):
        with subprocess.Popen(["sh", "-c", "sleep 60 & echo $!; wait"], stdout=subprocess.PIPE, text=True) as shell:
            grandchild = int(shell.stdout.readline())
            try:
                self.assertEqual(family_of(shell.pid), [shell.pid, grandchild])
            finally:
                os.kill(grandchild, signal.SIGKILL)

    def test_request_for_a_checkpoint_ends_no_process_that_cannot_answer_it_yet(self):
        with subprocess.Popen(["sleep", "60"], preexec_fn=lambda: end_with_parent(os.getppid())) as process:
            try:
                process.send_signal(signal.SIGUSR1)
                with self.assertRaises(subprocess.TimeoutExpired):
                    process.wait(0.2)
            finally:
                process.kill()


class Connecting(unittest.TestCase):
    def test_ssh_unless_the_user_or_a_slurm_job_has_another_way(self):
        with mock.patch.dict(os.environ, clear=True), mock.patch("shutil.which", return_value="/bin/srun"):
            self.assertEqual(hosts.connecting_command("b", ["echo", "a b"])[-2:], ["b", "echo 'a b'"])
            os.environ["SLURM_JOB_ID"] = "7"
            in_job = hosts.connecting_command("b", ["echo", "a b"])
            self.assertEqual((in_job[0], in_job[-4:]), ("srun", ["--nodelist=b", "/bin/sh", "-c", "echo 'a b'"]))
            os.environ["COPEPOD_SSH"] = "ssh -p 2222"
            self.assertEqual(hosts.connecting_command("b", ["true"]), ["ssh", "-p", "2222", "b", "true"])


class ReplacedFluid(unittest.TestCase):
    def test_it_is_started_once_unless_it_announces_mpi_or_ranks_are_chosen(self):
        values = {"commands": {"fluid": ["true"]}, "body_solver": "own", "unasked": frozenset()}
        replaced = dataclasses.replace(plan(), fluid_ranks=2, **values)
        for features, chosen, ranks in (((), None, 1), (("mpi",), None, 2), ((), 2, 2)):
            with mock.patch.object(components, "announces", lambda _, feature: feature in features):
                self.assertEqual(components.settled(replaced, chosen).fluid_ranks, ranks)


class LostHosts(unittest.TestCase):
    def sentence(self, output):
        exit = describe_exit("fluid", 1, output, "a", 3)
        failure = judge(None, [exit], 120, "a")
        self.assertEqual(failure.code, ExitCode.COMPONENT_LOST)
        return failure.sentence()

    def test_host_that_mpirun_lost_is_named(self):
        self.assertEqual(
            self.sentence(DAEMON_LOST), "guard on host c, after step 120: mpirun lost the connection to it."
        )

    def test_first_report_is_the_cause(self):
        guard = "copepod: host b: orted was killed by signal 9.\n"
        self.assertIn("guard on host b, after step 120: orted was killed", self.sentence(guard + RANK_KILLED))
        self.assertIn("fluid service on host b, rank 1, after step 120", self.sentence(RANK_KILLED + "\n" + guard))


class Check(WholeRunTest):
    def test_says_what_runs_where_and_which_hosts_cannot_be_reached(self):
        arguments = ("check", ROOT / "configs/quick/three_sphere.yaml", "--hosts", f"{os.uname().nodename},nowhere:2")
        for way, code, words in (
            ("/bin/true", 0, r"\nok$"),
            ("/bin/false", 2, r"error: host nowhere cannot be reached"),
        ):
            session = self.start(*arguments, environment=[("COPEPOD_SSH", way)])
            self.assert_ends(session, code, timeout_s=None)
            shown = "".join(session.stdout).strip()
            self.assertRegex(shown, r"on nowhere +fluid ranks 1 to 2")
            self.assertRegex(shown, words)


if __name__ == "__main__":
    unittest.main()
