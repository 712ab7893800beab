"""A few cells of the fault matrix (matrix.py has all), random faults, and what a resumed run must survive."""

import signal
import unittest
from concurrent.futures import ThreadPoolExecutor

import matrix
import random_faults
from hurt_run import PROMPT_S, hurt, signals_caught, slow_down, undisturbed_digest

CELLS = (
    ("coupler", "starting", "kill"),
    ("body", "configuring", "kill"),
    ("fluid 1", "exchanging", "kill"),
    ("command", "checkpointing", "kill"),
    ("mpirun", "between reply and bulk update", "kill"),
    ("coupler", "exchanging", "freeze"),
    ("fluid 1", "between reply and bulk update", "freeze"),
    ("mpirun", "finishing", "freeze"),
    ("command", "exchanging", "freeze"),
    ("body", "handshake", "hang"),
    ("fluid 1", "exchanging", "hang"),
)


class FaultMatrix(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.digest = undisturbed_digest()

    def test_every_fault_is_noticed_by_name_and_the_run_can_go_on(self):
        with ThreadPoolExecutor(3) as pool:
            for finding in pool.map(lambda cell: hurt(*cell), CELLS):
                with self.subTest(victim=finding.victim, phase=finding.phase, fault=finding.fault):
                    self.assertEqual(matrix.problems(finding, self.digest), [])
                    self.assertLess(finding.seconds, PROMPT_S)  # docs/results/faults.md has the figures

    def test_slow_step_that_shows_progress_is_never_taken_for_a_hang(self):
        for victim in ("body", "fluid 0", "fluid 1"):
            self.assertEqual(slow_down(victim, seconds=3.0, deadline_s=1.0), self.digest, victim)

    def test_a_rank_that_crashes_has_no_handler_that_could_wait_for_ever(self):
        """Open MPI's writes a stack trace, for which it allocates: it waits for a lock that the rank may have held."""
        crashes = {signal.SIGABRT, signal.SIGBUS, signal.SIGFPE, signal.SIGSEGV}
        self.assertEqual(signals_caught("fluid 1") & crashes, set())

    def test_random_faults_never_change_the_result(self):
        """random_faults.py draws as many as you like."""
        expected, latest_s = random_faults.undisturbed()
        self.assertEqual(expected[0], self.digest)
        faults = random_faults.draw(20, seed=1, jobs=2, latest_s=latest_s)
        self.assertEqual(random_faults.report(faults, expected), 0)


if __name__ == "__main__":
    unittest.main()
