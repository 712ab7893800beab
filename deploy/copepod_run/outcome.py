"""How a run ended: weighs what the coupler said against how the processes died. No processes in here, only judgement."""

import re
import signal
from dataclasses import dataclass, replace

from copepod_run import exit_codes

COMPONENTS = {"coupler": "coupler", "fluid": "fluid service", "body": "body service"}


@dataclass(frozen=True)
class Failure:
    """Where and why a run ended early; the same fields as proto/contract/errors.hpp FailureReport."""

    code: int
    component: str
    host: str
    rank: str  # "0", or "0-3" where all ranks went together
    step: int  # -1: before the first, or unknown
    reason: str

    def sentence(self):
        """Component, host, rank, step and reason on one line."""
        name = COMPONENTS.get(self.component, self.component)
        place = f"at step {self.step}" if self.step >= 0 else "before the first step"
        return f"{name} on host {self.host}, rank {self.rank}, {place}: {self.reason}"


@dataclass(frozen=True)
class Exit:
    """End of a component's process; `output` and `log` are what it wrote last on stdout and stderr, and to its log."""

    component: str
    code: int = 0  # exit code, if no signal ended it
    signal: int = 0  # signal that ended it, or 0
    rank: str = "0"
    host: str = ""
    output: str = ""
    log: str = ""


_RANK_KILLED = re.compile(r"process rank (\d+) with PID \d+ on node\s+(\S+)\s+exited on\s+signal (\d+)", re.DOTALL)
_LOGGED_ERROR = re.compile(
    r"^\S+ \S+ (?:error|critical) \[.*?\](?: \[step -?\d+\])? (.+)$", re.MULTILINE | re.IGNORECASE
)
_RANK_FAILED = re.compile(r"Process name: \[\[\d+,\d+\],(\d+)\]\s+Exit code:\s+(\d+)", re.DOTALL)


def told_by_mpirun(output, host):
    """Exit of the rank that ended the fluid as mpirun tells it, or None if it has not told."""
    words = re.sub(r"\s+", " ", output)
    killed = _RANK_KILLED.search(words)
    if killed:
        return Exit("fluid", signal=int(killed[3]), rank=killed[1], host=killed[2], output=output)
    failed = _RANK_FAILED.search(words)
    return Exit("fluid", code=int(failed[2]), rank=failed[1], host=host, output=output) if failed else None


def describe_exit(component, returncode, output, host, ranks, log=""):
    """Exit from subprocess' return code; for mpirun its message tells which rank went how."""
    if component == "fluid" and returncode != 0:
        told = told_by_mpirun(output, host)
        if told is not None:
            return replace(told, log=log)
        if returncode > 128:  # a rank that was killed before it knew MPI
            returncode = 128 - returncode
    rank = f"0-{ranks - 1}" if component == "fluid" and ranks > 1 else "0"
    if returncode < 0:
        return Exit(component, signal=-returncode, rank=rank, host=host, output=output)
    return Exit(component, code=returncode, rank=rank if returncode == 0 else "0", host=host, output=output, log=log)


def failure_of_event(event, host):
    """Failure from the coupler's failure event."""
    return Failure(
        code=int(event.get("code", exit_codes.SOLVER_FAILED)),
        component=event.get("component", "coupler"),
        host=event.get("host") or host,
        rank=str(event.get("rank", 0)),
        step=int(event.get("step", -1)),
        reason=event.get("reason", "no reason given"),
    )


def judge(reported, exits, last_step, host):
    """The failure of a run that did not finish.

    @param reported   Failure that the coupler reported, or None
    @param exits      Exits in the order in which they were seen
    @param last_step  last step that the coupler told of, -1 if none
    """
    killed = next((exit for exit in exits if exit.signal), None)
    if reported is not None:
        step = reported.step if reported.step >= 0 else last_step
        if killed and reported.code == exit_codes.COMPONENT_LOST:
            return replace(_of_killed(killed, step), code=exit_codes.COMPONENT_LOST)
        return replace(reported, step=step)
    if killed and not _is_consequence(killed, exits):
        return _of_killed(killed, last_step)
    if exits:
        return _of_exit(exits[0], last_step, host)
    return Failure(
        exit_codes.COMPONENT_LOST,
        "coupler",
        host,
        "0",
        last_step,
        "it closed its output without a word (a defect). Look into its log, and report it.",
    )


def _is_consequence(killed, exits):
    """Whether another component had failed by itself before `killed` was killed."""
    first = exits[0]
    return first is not killed and first.code not in (0, exit_codes.COMPONENT_LOST)


def _of_killed(exit, step):
    name = signal.Signals(exit.signal).name if exit.signal in set(signal.Signals) else "unknown"
    reason = f"killed by signal {exit.signal}, {name} ({_likely_cause(exit.signal)})."
    return Failure(exit_codes.COMPONENT_LOST, exit.component, exit.host, exit.rank, step, reason)


def _likely_cause(number):
    if number == signal.SIGKILL:
        return "by somebody, or by the system for lack of memory"
    if number in (signal.SIGSEGV, signal.SIGABRT, signal.SIGBUS, signal.SIGFPE, signal.SIGILL):
        return "a defect in the program"
    return "by somebody"


def _of_exit(exit, step, host):
    """Failure told by an exit code alone."""
    if exit.code == exit_codes.COMPONENT_LOST and exit.component != "coupler":
        return Failure(
            exit.code,
            "coupler",
            host,
            "0",
            step,
            f"it does not answer any more (says the {COMPONENTS[exit.component]}, which gave up).",
        )
    code = exit.code if exit.code in exit_codes.OF_COMPONENTS else exit_codes.COMPONENT_LOST
    words = _last_words(exit.output, exit.log)
    if exit.code == 0:
        return Failure(code, exit.component, exit.host, exit.rank, step, f"it ended before the run did{words}.")
    return Failure(code, exit.component, exit.host, exit.rank, step, f"it ended with exit code {exit.code}{words}.")


def _last_words(output, log):
    """In brackets: the last error of its log, or else the last line of its own and not mpirun's talk."""
    errors = _LOGGED_ERROR.findall(log)
    lines = errors or _lines(output.split("-----------------")[0]) or _lines(log)
    if lines:
        return f" (its last words: «{lines[-1][:300].rstrip('.')}»)"
    return "" if output.strip() else " (it wrote nothing)"


def _lines(text):
    return [line.strip() for line in text.splitlines() if line.strip()]
