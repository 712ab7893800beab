"""Runs over three hosts: the same digest as here, every fault named, nothing left on any host, and resumable."""

import os
import signal
import tempfile
import time
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import three_hosts as lab
from hurt_hosts import CLEAN_WITHIN_S, VICTIMS, HostsRun, cut, finish, hurt, outcome_of, start_halted, three_hosts
from hurt_run import LONGEST_S, digest

AT_ONCE = 3
SILENCE_S = 5
ALL = os.environ.get("COPEPOD_ALL_HOST_FAULTS")  # minutes more: every process, every direction, cuts of 30 s
KILLED = [
    *(("a", kind) for kind in ("command", "mpirun", "agent", "connection", "rank")),
    *(("b", kind) for kind in ("rank", "orted", "guard", "starter")),
    ("c", "sshd"),
]
FROZEN = {("a", "rank"): "host a, rank 0, .*frozen", ("b", "rank"): "host b, rank 1, .*frozen"}
FROZEN_TOO = {("b", "guard"): "host b.* is stopped", ("c", "orted"): "host c.*frozen.*orted"}
SHORT = [("both", 1), ("both", 5), ("out", 5)]
SHORT_TOO = [("out", 1), ("in", 1), ("in", 5)]


@unittest.skipIf(lab.missing(), lab.missing())
class ThreeHosts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with three_hosts() as (hosts, folder):
            run = HostsRun(hosts, folder, "--out", "out")
            assert run.end(LONGEST_S) == 0, "".join(run.stderr)
            cls.digest = digest(folder)

    def check(self, outcomes, expected):
        """`expected`: (what, words of the last line, exit code) of each."""
        for outcome, (what, words, code) in zip(outcomes, expected):
            with self.subTest(what=what):
                print(f"{what}: {outcome.seconds:.1f} s, clean after {outcome.clean_s:.1f} s: {outcome.message}")
                self.assertEqual(outcome.problems(words, self.digest), [])
                self.assertEqual(outcome.code, code, outcome.message)

    def test_digest_is_that_of_one_host_wherever_rank_0_is(self):
        for placement in ("a,b,c", "a:0,b:2,c"):
            with three_hosts() as (hosts, folder):
                self.assertEqual(finish(hosts, folder, placement=placement), self.digest)
                self.assertEqual(hosts.left(), [])

    def test_every_killed_process_is_named_and_takes_all_others_with_it(self):
        victims = list(VICTIMS) if ALL else KILLED
        with ThreadPoolExecutor(AT_ONCE) as pool:
            outcomes = list(pool.map(lambda victim: hurt(*victim), victims))
        codes = [-signal.SIGKILL if kind == "command" else 69 for _, kind in victims]
        self.check(outcomes, [(victim, VICTIMS[victim], code) for victim, code in zip(victims, codes)])

    def test_frozen_processes_are_named_and_ended(self):
        victims = {**FROZEN, **(FROZEN_TOO if ALL else {})}
        with ThreadPoolExecutor(AT_ONCE) as pool:
            outcomes = list(pool.map(lambda victim: hurt(*victim, signal.SIGSTOP), victims))
        self.check(outcomes, [(victim, words, 69) for victim, words in victims.items()])

    def test_end_of_ranks_that_mpirun_does_not_notice_is_named(self):
        limit = ("--set", f"services.silence_s={SILENCE_S}")
        outcome = hurt("a", "agent", signal.SIGKILL, *limit, unaware="mpirun")
        self.check([outcome], [("agent", "host b, rank 1.* mpirun did not notice", 69)])

    def test_guard_that_is_frozen_while_the_run_finishes_leaves_nothing(self):
        with three_hosts() as (hosts, folder):
            run = start_halted(hosts, folder)
            start = time.monotonic()
            os.kill(run.victims("c", "guard")[0], signal.SIGSTOP)
            (folder / "halted").unlink()
            outcome = outcome_of(run, start)  # finished, unless that takes longer than noticing the guard
            outcome.digest = digest(folder) if outcome.code == 0 else finish(hosts, folder)
        self.assertEqual(outcome.problems("host c.* is stopped", self.digest), [])

    def test_cuts_that_are_shorter_than_the_case_allows_change_nothing(self):
        cuts = SHORT + (SHORT_TOO if ALL else [])
        with ThreadPoolExecutor(AT_ONCE) as pool:
            outcomes = list(pool.map(lambda what: cut("b", *what), cuts))
        self.check(outcomes, [(what, "", 0) for what in cuts])

    def test_longer_cuts_are_named_and_nothing_is_left_beyond_them(self):
        directions = ("both", "out", "in") if ALL else ("both", "in")
        with ThreadPoolExecutor(AT_ONCE) as pool:
            limit = ("--set", f"services.silence_s={SILENCE_S}")
            outcomes = list(pool.map(lambda direction: cut("b", direction, 40, *limit), directions))
        self.check(outcomes, [(direction, "guard on host b", 69) for direction in directions])
        for outcome in outcomes:
            self.assertLess(outcome.seconds, SILENCE_S + 3 * CLEAN_WITHIN_S)

    def test_host_that_is_cut_off_sees_on_the_shared_disk_that_the_run_is_over(self):
        victims = ("command", "body")
        with ThreadPoolExecutor(AT_ONCE) as pool:
            outcomes = list(pool.map(lambda kind: hurt("a", kind, cut_off="b"), victims))
        self.check(outcomes, zip(victims, ("", VICTIMS["a", "body"]), (-signal.SIGKILL, 69)))

    @unittest.skipUnless(ALL, "takes minutes: set COPEPOD_ALL_HOST_FAULTS=1")
    def test_cuts_of_thirty_seconds(self):
        self.check([cut("b", "both", 30, "--set", "services.silence_s=90")], [("30 s, 90 s allowed", "", 0)])
        limit = ("--set", "services.silence_s=20")
        self.check([cut("b", "both", 30, *limit)], [("30 s, 20 s allowed", "host b does not answer", 69)])

    def test_host_that_cannot_take_part_is_refused_before_the_first_step(self):
        with three_hosts() as (hosts, folder), tempfile.TemporaryDirectory(dir="/var/tmp") as own:
            for arguments, words in (
                (("--out", "out", "--hosts", "a,nowhere"), "host nowhere cannot be reached"),
                (("--out", "/tmp/own", "--hosts", "a,b"), "host b: /tmp/own is not there (no shared file system)"),
                (("--out", "out", "--hosts", "b,a"), "the first of the hosts is b, but this is a"),
            ):
                run = HostsRun(hosts, folder, *arguments)
                self.assertEqual(run.end(LONGEST_S), 2)
                self.assertIn(words, run.last_line)
                self.assertEqual(hosts.left(), [])
                (folder / "out").rename(Path(own) / words[:9]) if (folder / "out").exists() else None


if __name__ == "__main__":
    unittest.main()
