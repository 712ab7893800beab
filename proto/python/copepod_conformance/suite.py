"""All checks of a component: chosen, run several at a time, and abandoned when the component does not answer at all."""

import threading
import time
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module

from copepod_conformance.component_process import end_marked
from copepod_conformance.trial import Trial
from copepod_conformance.verdicts import NotApplicable, Result, Silence, Violation

SUITE = "COPEPOD_CONFORMANCE"  # in the environment of every process that the suite starts
_OF_BOTH_ROLES = ("handshake", "states", "exactly_once", "limits", "checkpoints", "lifetime")
_OF_ROLE = {"fluid": ("fluid_physics",), "body": ("body_physics", "body_contacts", "body_joints")}
GROUPS = (  # of checks, in the order of the report
    *("handshake", "versions", "states", "exactly once", "limits", "numbers", "checkpoints"),
    *("control lane", "ends", "processes", "physics"),
)
_MOST_SILENCES = 12  # each costs the whole patience


def all_checks(subject):
    names = _OF_BOTH_ROLES + _OF_ROLE[subject.role]
    modules = [import_module(f"copepod_conformance.checks.{name}") for name in names]
    return [check for module in modules for check in module.checks(subject)]


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
        start = time.monotonic()
        if self._silences >= _MOST_SILENCES:
            result = Result(check, "failed", 0.0, "not tried: the component was silent too often")
        else:
            result = self._try(check, start)
        with self._lock:
            self._done += 1
            self._progress(self._done, len(self._checks))
        return result

    def _try(self, check, start):
        sent = []
        try:
            with Trial(self._subject, check.options) as trial:
                sent = trial.sent
                check.run(trial, *check.arguments)
            return Result(check, "passed", time.monotonic() - start)
        except NotApplicable as reason:
            return Result(check, "skipped", time.monotonic() - start, str(reason))
        except (Violation, OSError) as violation:
            with self._lock:
                self._silences += isinstance(violation, Silence)
            last = ", ".join((["…"] if len(sent) > 5 else []) + sent[-5:])  # short enough to read
            return Result(check, "failed", time.monotonic() - start, str(violation), last)
