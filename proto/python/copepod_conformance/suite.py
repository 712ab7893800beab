"""All checks of a component: chosen, run several at a time, and abandoned when the component does not answer at all."""

import threading
import time
from concurrent.futures import ThreadPoolExecutor

from copepod_conformance.checks import body_constraints, body_physics, fluid_physics
from copepod_conformance.checks import checkpoints, exactly_once, handshake, lifetime, limits, states
from copepod_conformance.component_process import end_marked
from copepod_conformance.trial import Trial
from copepod_conformance.verdicts import NotApplicable, Result, Silence, Violation

SUITE = "COPEPOD_CONFORMANCE"  # in the environment of every process that the suite starts
_OF_BOTH_ROLES = (handshake, states, exactly_once, limits, checkpoints, lifetime)
_OF_ROLE = {"fluid": (fluid_physics,), "body": (body_physics, body_constraints)}
GROUPS = (  # of checks, in the order of the report
    *("handshake", "versions", "states", "exactly once", "limits", "numbers", "checkpoints"),
    *("control lane", "ends", "processes", "physics"),
)
_MOST_SILENCES = 12  # each costs the whole patience


def all_checks(subject):
    return [check for module in (*_OF_BOTH_ROLES, *_OF_ROLE[subject.role]) for check in module.checks(subject)]


class Suite:
    """`progress(done, total)` is called after every check."""

    def __init__(self, subject, checks, jobs, progress):
        self._subject, self._checks, self._jobs, self._progress = subject, checks, jobs, progress
        self._lock, self._silences, self._done = threading.Lock(), 0, 0

    def run(self):
        """Results in the order of the checks."""
        with ThreadPoolExecutor(self._jobs) as pool:
            try:
                results = list(pool.map(self._run_check, (check for check in self._checks if not check.alone)))
            except BaseException:  # stopped by a signal: checks under way notice that their component is gone
                pool.shutdown(wait=False, cancel_futures=True)
                end_marked(f"{SUITE}={self._subject.environment[SUITE]}")
                raise
        results += [self._run_check(check) for check in self._checks if check.alone]
        return sorted(results, key=lambda result: self._checks.index(result.check))

    def _run_check(self, check):
        start, sent = time.monotonic(), []
        outcome, came, is_silent = "passed", "", False
        try:
            if self._silences >= _MOST_SILENCES:
                raise Violation("not tried: the component was silent too often")
            with Trial(self._subject, check.options) as trial:
                sent = trial.sent
                check.run(trial, *check.arguments)
        except NotApplicable as reason:
            outcome, came = "skipped", str(reason)
        except (Violation, OSError) as violation:
            outcome, came, is_silent = "failed", str(violation), isinstance(violation, Silence)
        with self._lock:
            self._silences += is_silent
            self._done += 1
            self._progress(self._done, len(self._checks))
        last = ", ".join((["…"] if len(sent) > 5 else []) + sent[-5:])  # short enough to read
        return Result(check, outcome, time.monotonic() - start, came, last)
