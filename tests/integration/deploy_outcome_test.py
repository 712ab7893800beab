"""How the ending of a run is judged from the coupler's report and the exits of the processes."""

import resource
import unittest
from unittest import mock

import copepod_session  # noqa: F401  (makes the command's modules importable)
from copepod_run.outcome import Exit, Failure, describe_exit, failure_of_event, judge

KILLED_RANK = """--------------------------------------------------------------------------
Primary job  terminated normally, but 1 process returned
a non-zero exit code. Per user-direction, the job has been aborted.
--------------------------------------------------------------------------
--------------------------------------------------------------------------
mpirun noticed that process rank 3 with PID 4711 on node sea exited on signal 9 (Killed).
--------------------------------------------------------------------------
"""
FAILED_RANK = """[12:00:01] solver failed
--------------------------------------------------------------------------
mpirun detected that one or more processes exited with non-zero status, thus causing
the job to be terminated. The first process to do so was:

  Process name: [[24499,1],2]
  Exit code:    70
--------------------------------------------------------------------------
"""
LOST_FLUID = Failure(69, "fluid", "sea", "0", 123, "connection closed.")


class DescribeExit(unittest.TestCase):
    def test_mpirun_tells_rank_host_and_signal_of_a_killed_rank(self):
        exit = describe_exit("fluid", 137, KILLED_RANK, "here", ranks=4)
        self.assertEqual((exit.signal, exit.rank, exit.host), (9, "3", "sea"))

    def test_message_may_be_broken_over_lines_by_long_host_names(self):
        broken = KILLED_RANK.replace(" on node sea exited", " on node\n sea\n exited")
        self.assertEqual(describe_exit("fluid", 137, broken, "here", ranks=4).rank, "3")

    def test_mpirun_tells_rank_and_code_of_a_failed_rank(self):
        exit = describe_exit("fluid", 70, FAILED_RANK, "here", ranks=4)
        self.assertEqual((exit.signal, exit.code, exit.rank), (0, 70, "2"))

    def test_killed_mpirun_took_all_ranks_along(self):
        exit = describe_exit("fluid", -9, "", "here", ranks=4)
        self.assertEqual((exit.signal, exit.code, exit.rank, exit.host), (9, 0, "0-3", "here"))

    def test_mpirun_that_had_to_be_killed_is_taken_at_its_word(self):
        exit = describe_exit("fluid", -9, KILLED_RANK, "here", ranks=4)
        self.assertEqual((exit.signal, exit.rank, exit.host), (9, "3", "sea"))

    def test_mpirun_that_could_not_start_its_ranks_was_not_killed(self):
        exit = describe_exit("fluid", 243, "", "here", ranks=4)
        self.assertEqual((exit.signal, exit.code), (0, 243))

    def test_success_is_success_whatever_the_log_says(self):
        exit = describe_exit("fluid", 0, FAILED_RANK, "here", ranks=4)
        self.assertEqual((exit.signal, exit.code, exit.rank), (0, 0, "0-3"))


class Judge(unittest.TestCase):
    def test_report_of_a_failed_solver_is_taken_as_it_is(self):
        reported = Failure(70, "fluid", "sea", "2", 55, "diverged at cell (1, 2, 3).")
        verdict = judge(reported, [Exit("fluid", code=70, rank="2")], 54, "here")
        self.assertEqual(verdict, reported)

    def test_exit_by_a_signal_is_more_precise_than_a_lost_connection(self):
        verdict = judge(
            LOST_FLUID, [Exit("coupler", code=69), Exit("fluid", signal=9, rank="1", host="sea")], 120, "here"
        )
        self.assertEqual((verdict.code, verdict.component, verdict.rank, verdict.step), (69, "fluid", "1", 123))
        self.assertIn("SIGKILL", verdict.reason)

    def test_lost_connection_stands_when_nobody_was_killed(self):
        self.assertEqual(judge(LOST_FLUID, [Exit("coupler", code=69)], 120, "here"), LOST_FLUID)

    def test_exit_code_is_more_precise_than_a_lost_connection(self):
        lost = Failure(69, "body", "sea", "0", 700, "is gone (its connection broke).")
        own = Exit("body", code=3, host="sea", log="10:00 10:01 info [body rank 0] ready\n", log_file="logs/body.log")
        verdict = judge(lost, [own, Exit("coupler", code=69)], 699, "here")
        self.assertEqual(verdict.code, 69)
        self.assertEqual(
            verdict.sentence(),
            "body service on host sea, rank 0, at step 700: exited with code 3 without reporting an error. "
            "See its log logs/body.log.",
        )

    def test_service_that_lost_the_coupler_is_not_the_cause_of_its_own_loss(self):
        lost = Failure(69, "body", "sea", "0", 700, "is frozen.")
        self.assertEqual(judge(lost, [Exit("coupler", code=69), Exit("body", code=69)], 699, "here"), lost)

    def test_segmentation_fault_is_named_with_the_reported_step(self):
        lost = Failure(69, "body", "sea", "0", 700, "is gone (its connection broke).")
        verdict = judge(lost, [Exit("body", signal=11, host="sea", log_file="logs/body.log")], 697, "here")
        self.assertIn("at step 700: killed by signal 11, SIGSEGV (a defect in the program).", verdict.sentence())
        self.assertIn("See its log logs/body.log.", verdict.sentence())

    def test_lack_of_memory_may_be_the_cause_where_memory_is_limited(self):
        with mock.patch("resource.getrlimit", lambda kind: (3 << 30 if kind == resource.RLIMIT_AS else -1, -1)):
            verdict = judge(None, [Exit("fluid", signal=11, host="sea")], 697, "here")
        self.assertIn(
            "a defect in the program, or a library that does not expect the limit: ulimit -v is 3145728)",
            verdict.reason,
        )

    def test_the_words_of_an_mpirun_that_cannot_start_are_the_reason(self):
        frame = "-" * 74
        outputs = (
            f"{frame}\nAn ORTE daemon has failed\nafter launch.\n{frame}\n{frame}\nMore.\n{frame}\n",
            f"{'*' * 60}\n{frame}\nAn ORTE daemon has failed\nafter launch.\n{frame}\n",
        )
        for output in outputs:
            verdict = judge(None, [Exit("fluid", code=1, host="sea", output=output)], -1, "here")
            self.assertIn("the last it wrote: «An ORTE daemon has failed after launch».", verdict.reason)

    def test_report_without_a_step_gets_the_last_known_one(self):
        verdict = judge(Failure(70, "body", "sea", "0", -1, "overlap."), [], 17, "here")
        self.assertEqual(verdict.step, 17)
        self.assertIn("after step 17: overlap.", verdict.sentence())

    def test_services_that_gave_up_mean_a_frozen_coupler(self):
        verdict = judge(None, [Exit("body", code=69), Exit("fluid", code=69)], 17, "here")
        self.assertEqual((verdict.code, verdict.component), (69, "coupler"))

    def test_killed_coupler_is_to_blame_although_services_gave_up_too(self):
        verdict = judge(None, [Exit("coupler", signal=9, host="sea"), Exit("body", code=69)], 17, "here")
        self.assertEqual((verdict.code, verdict.component, verdict.rank), (69, "coupler", "0"))

    def test_first_failure_counts_and_not_the_killing_that_followed(self):
        verdict = judge(None, [Exit("body", code=70, output="overlap of a and b"), Exit("fluid", signal=9)], 17, "here")
        self.assertEqual((verdict.code, verdict.component), (70, "body"))
        self.assertIn("overlap of a and b", verdict.reason)

    def test_unknown_exit_code_means_a_lost_component(self):
        verdict = judge(None, [Exit("fluid", code=1, output="Traceback\nImportError: no such thing")], -1, "here")
        self.assertEqual(verdict.code, 69)
        self.assertIn("ImportError", verdict.reason)
        self.assertIn("before the first step", verdict.sentence())

    def test_component_that_ends_quietly_before_the_run_is_lost(self):
        verdict = judge(None, [Exit("body", code=0)], 17, "here")
        self.assertEqual((verdict.code, verdict.component), (69, "body"))

    def test_mpiruns_own_words_are_not_the_last_words_of_a_component(self):
        verdict = judge(None, [describe_exit("fluid", 70, FAILED_RANK, "here", 4)], 17, "here")
        self.assertIn("solver failed", verdict.reason)
        self.assertNotIn("----", verdict.reason)

    def test_an_error_that_could_not_be_sent_is_quoted_before_what_mpirun_adds(self):
        output = "error: no shared memory. Free some.\n[sea:16985] ORTE_ERROR_LOG: Data unpack would read past end\n"
        failure = judge(None, [Exit("fluid", code=73, host="sea", output=output)], -1, "here")
        self.assertIn("exited with code 73; the last it wrote: «no shared memory. Free some».", failure.reason)

    def test_last_error_of_the_log_is_quoted_where_there_is_one(self):
        for log in (
            "2026-11-21 10:00:00.1 error [body rank 0] [step -1] a fluid component already takes part. Start one.\n"
            "2026-11-21 10:00:00.2 info [body rank 0] [step -1] Ending with exit code 65.\n",
            "2026-11-21 10:00:00,1 ERROR [body rank 0] a fluid component already takes part. Start one.\nTraceback\n",
        ):
            for output in ("", "a warning on stderr"):
                verdict = judge(None, [describe_exit("body", 65, output, "here", 1, log)], -1, "here")
                self.assertIn("; the last it wrote: «a fluid component already takes part. Start one».", verdict.reason)
        verdict = judge(None, [describe_exit("body", 1, "", "here", 1, "no such licence\n")], -1, "here")
        self.assertIn("no such licence", verdict.reason)

    def test_event_becomes_a_failure_with_our_host_if_it_names_none(self):
        failure = failure_of_event({"event": "failure", "code": 65, "component": "body", "reason": "no."}, "here")
        self.assertEqual((failure.code, failure.host, failure.rank, failure.step), (65, "here", "0", -1))


if __name__ == "__main__":
    unittest.main()
