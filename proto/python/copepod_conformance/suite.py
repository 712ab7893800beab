"""All checks of a component: chosen, run several at a time, and abandoned when the component does not answer at all;
their results as a table for people, and as JUnit XML for continuous integration."""

import signal
import threading
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from xml.etree import ElementTree

from copepod_conformance.checks import body_constraints, body_physics, fluid_physics
from copepod_conformance.checks import checkpoints, exactly_once, handshake, lifetime, limits, states
from copepod_conformance.component_process import signal_marked
from copepod_conformance.subject import Trial
from copepod_conformance.verdicts import NotApplicable, Result, Silence, Violation

SUITE = "COPEPOD_CONFORMANCE"  # in the environment of every process that the suite starts
_OF_ALL_ROLES = (handshake, states, exactly_once, limits, checkpoints, lifetime)
_OF_ROLE = {"fluid": (fluid_physics,), "body": (body_physics, body_constraints), "controller": ()}
GROUPS = (  # of checks, in the order of the report
    *("handshake", "versions", "states", "exactly once", "limits", "numbers", "checkpoints"),
    *("control lane", "ends", "processes", "physics"),
)
_MOST_SILENCES = 12  # each costs the whole patience


def all_checks(subject):
    return [check for module in (*_OF_ALL_ROLES, *_OF_ROLE[subject.role]) for check in module.checks(subject)]


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
                signal_marked(f"{SUITE}={self._subject.environment[SUITE]}", signal.SIGKILL)
                raise
        results += [self._run_check(check) for check in self._checks if check.alone]
        return sorted(results, key=lambda result: self._checks.index(result.check))

    def _run_check(self, check):
        start, sent = time.monotonic(), []
        outcome, came, is_silent = "passed", "", False
        try:
            if self._silences >= _MOST_SILENCES:
                raise Violation("not tried: the component was silent too often")
            self._subject.require(*check.needs)
            with Trial(self._subject, check.options) as trial:
                sent = trial.sent
                if check.steps is not None:
                    trial.configure(check.steps)
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


def counts(results):
    """How many of each outcome."""
    return Counter(result.outcome for result in results)


def table(subject, results, verbose=False):
    """One line per group, then everything that failed and why something was left out."""
    solver = f", solver {subject.case.solver}" if subject.case.solver else ""
    lines = [
        f"{subject.name} {subject.capabilities.get('version', '')}, {subject.role}{solver}: "
        f"{' '.join(subject.command)}",
        "",
        f"  {'':<16}{'passed':>8}{'failed':>8}{'skipped':>9}",
    ]
    for group in GROUPS:
        of_group = [result for result in results if result.check.group == group]
        if of_group:
            number = counts(of_group)
            lines.append(f"  {group:<16}{number['passed']:>8}{number['failed'] or '':>8}{number['skipped'] or '':>9}")
        for result in of_group if verbose else []:
            lines.append(f"    {result.outcome:<8} {result.check.name} ({result.seconds:.1f} s)")
    skips = Counter(result.came for result in results if result.outcome == "skipped")
    lines += ["", *(f"  skipped {number}: {reason}" for reason, number in skips.items())] if skips else []
    for result in results:
        if result.outcome == "failed":
            lines += ["", *failure_lines(result)]
    number = counts(results)
    verdict = "not conformant" if number["failed"] else "conformant"
    lines += ["", f"{verdict}: {number['passed']} passed, {number['failed']} failed, {number['skipped']} skipped"]
    return "\n".join(lines)


def failure_lines(result):
    """What was sent, what came, and what the rule demands."""
    rule = result.check.rule
    return [
        f"FAILED {result.check.group}: {result.check.name}",
        f"  sent  {result.sent or 'nothing'}",
        f"  came  {result.came}",
        f"  rule  {rule.text}",
        f"        docs/protocol.md, «{rule.section}»",
    ]


def junit(subject, results, seconds):
    """The results as JUnit XML, bytes."""
    number = counts(results)
    suite = ElementTree.Element(
        "testsuite",
        name=f"conformance of {subject.name} ({subject.role})",
        tests=str(len(results)),
        failures=str(number["failed"]),
        errors="0",
        skipped=str(number["skipped"]),
        time=f"{seconds:.3f}",
    )
    for result in results:
        about = {"classname": f"conformance.{result.check.group}", "name": result.check.name}
        case = ElementTree.SubElement(suite, "testcase", about, time=f"{result.seconds:.3f}")
        if result.outcome == "failed":
            failure = ElementTree.SubElement(case, "failure", message=_printable(result.came))
            failure.text = _printable("\n".join(failure_lines(result)))
        elif result.outcome == "skipped":
            ElementTree.SubElement(case, "skipped", message=result.came)
    ElementTree.indent(suite)
    return ElementTree.tostring(suite, encoding="utf-8", xml_declaration=True)


def _printable(text):
    """XML allows no control characters, but a component's last words may contain some."""
    return "".join(character if character.isprintable() or character in "\n\t" else "?" for character in text)
