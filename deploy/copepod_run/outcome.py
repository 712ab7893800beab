"""How a run ended: the coupler's report weighed against how the processes ended. No processes here, only judgement."""

import re
import resource
import signal
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from copepod_run.errors import ExitCode
from copepod_run.progress import Event

COMPONENTS = {"coupler": "coupler", "fluid": "fluid service", "body": "body service", "guard": "guard"}
_CODES_OF_COMPONENTS = {code for code in ExitCode if code is ExitCode.BAD_CASE or 64 < code < 128}


@dataclass(frozen=True)
class Failure:
    """Where and why a run ended early; the same fields as proto/contract/errors.hpp FailureReport."""

    code: int
    component: str
    host: str
    rank: str  # "0", or "0-3" where all ranks ended together; empty for a guard
    step: int  # -1: before the first
    reason: str
    log: str = ""  # file to look into, if the reason is not all that is known
    was_killed: bool = False  # by a signal from outside
    is_after_step: bool = False  # `step` is the last one known to have begun

    def sentence(self) -> str:
        """Component, host, rank, step and reason on one line."""
        name = COMPONENTS.get(self.component, f"controller {self.component}")
        rank = f", rank {self.rank}" if self.rank else ""
        when = "after" if self.is_after_step else "at"
        place = f"{when} step {self.step}" if self.step >= 0 else "before the first step"
        see = f" See its log {self.log}." if self.log else ""
        return f"{name} on host {self.host}{rank}, {place}: {self.reason}{see}"


def lost(component: str, host: str, rank: str, reason: str, step: int = -1, **more: Any) -> Failure:
    """Of a component that has died, froze or cannot be reached."""
    return Failure(ExitCode.COMPONENT_LOST, component, host, rank, step, reason, **more)


@dataclass(frozen=True)
class Exit:
    """End of a component's process; `output`, `log`: the ends of what it wrote on stdout and stderr, and to its log."""

    component: str
    code: int = 0  # exit code, if no signal ended it
    signal: int = 0  # signal that ended it, or 0
    rank: str = "0"
    host: str = ""
    output: str = ""
    log: str = ""
    log_file: str = ""
    reason: str = ""  # why mpirun lost a host


_HOST_LOST = re.compile(r"^copepod: host (\S+): (.+)$", re.MULTILINE)  # host_guard.py, hosts.py
_DAEMON_LOST = re.compile(r"lost communication with a remote daemon.*? Remote daemon\s*: \S+ on node (\S+)")
_AGENT_LOST = "ORTE was unable to reliably start one or more daemons"
_RANK_KILLED = re.compile(r"process rank (\d+) with PID \d+ on node\s+(\S+)\s+exited on\s+signal (\d+)", re.DOTALL)
_RANK_FAILED = re.compile(r"Process name: \[\[\d+,\d+\],(\d+)\]\s+Exit code:\s+(\d+)", re.DOTALL)
_LOG_LINE = re.compile(r"^\S+ \S+ (?P<level>\w+) \[.*?\](?: \[step -?\d+\])? (?P<text>.+)$")


def reported_by_mpirun(output: str, host: str) -> Exit | None:
    """Exit of the rank that ended the fluid, if mpirun has reported it."""
    news = _HOST_LOST.search(output)
    words = re.sub(r"\s+", " ", output[: news.start()] if news else output)  # what follows is a consequence
    if killed := _RANK_KILLED.search(words):
        return Exit("fluid", signal=int(killed[3]), rank=killed[1], host=killed[2], output=output)
    if failed := _RANK_FAILED.search(words):
        return Exit("fluid", code=int(failed[2]), rank=failed[1], host=host, output=output)
    if news:
        host, reason = news.groups()
    elif daemon := _DAEMON_LOST.search(words):
        host, reason = daemon[1], "mpirun lost the connection to it."
    elif _AGENT_LOST in words:
        reason = "mpirun lost the connection to a host."
    else:
        return None
    return Exit("guard", 1, rank="", host=host, output=output, reason=reason)


def describe_exit(
    component: str, returncode: int, output: str, host: str, ranks: int, log: str = "", log_file: str = ""
) -> Exit:
    """Exit from subprocess' return code; mpirun's message names the rank and how it ended."""
    if component == "fluid" and returncode != 0:
        if reported := reported_by_mpirun(output, host):
            return replace(reported, log=log, log_file=log_file)
        if 128 < returncode <= 128 + signal.SIGRTMAX:  # a rank that was killed before it had started MPI
            returncode = 128 - returncode
    are_all = component == "fluid" and ranks > 1 and returncode <= 0
    rank = f"0-{ranks - 1}" if are_all else "0"
    return Exit(component, max(returncode, 0), max(-returncode, 0), rank, host, output, log, log_file)


def failure_of_event(event: Event, host: str) -> Failure:
    """Failure from the coupler's failure event."""
    return Failure(
        code=int(event.get("code", ExitCode.SOLVER_FAILED)),
        component=event.get("component", "coupler"),
        host=event.get("host") or host,
        rank=str(event.get("rank", 0)),
        step=int(event.get("step", -1)),
        reason=event.get("reason", "no reason given"),
    )


def judge(reported: Failure | None, exits: Sequence[Exit], last_step: int, host: str) -> Failure:
    """The failure of a run that did not finish.

    @param reported   Failure that the coupler reported
    @param exits      Exits in the order in which they were seen
    @param last_step  last step in the coupler's events, -1 if none
    """
    killed = next((exit for exit in exits if exit.signal or exit.reason), None)
    if reported is not None:
        failure = _with_cause(reported, killed, exits, host)
    elif killed and (exits[0] is killed or exits[0].code in (0, ExitCode.COMPONENT_LOST)):  # else a consequence
        failure = _of_killed(killed, -1)
    elif exits:
        failure = _of_exit(exits[0], -1, host)
    else:
        reason = "closed its output without reporting an error (a defect). See its log, and report it."
        failure = lost("coupler", host, "0", reason)
    return failure if failure.step >= 0 else replace(failure, step=last_step, is_after_step=True)


def _with_cause(reported: Failure, killed: Exit | None, exits: Sequence[Exit], host: str) -> Failure:
    """The coupler sees only that a component is lost; the end of its process is the cause."""
    if reported.code != ExitCode.COMPONENT_LOST:
        return reported
    if killed:
        return _of_killed(killed, reported.step)
    for exit in exits:
        if exit.component == reported.component != "coupler" and exit.code != ExitCode.COMPONENT_LOST:
            return replace(_of_exit(exit, reported.step, host), code=reported.code)
    return reported


def _of_killed(exit: Exit, step: int) -> Failure:
    if exit.reason:
        return lost(exit.component, exit.host, exit.rank, exit.reason, step, was_killed=True)
    name = signal.Signals(exit.signal).name if exit.signal in set(signal.Signals) else "unknown"
    is_defect = exit.signal in (signal.SIGSEGV, signal.SIGABRT, signal.SIGBUS, signal.SIGFPE, signal.SIGILL)
    cause = "a defect in the program" if is_defect else "sent by a user or another program"
    for option, kind in (("v", resource.RLIMIT_AS), ("f", resource.RLIMIT_FSIZE)):  # which processes of a run inherit
        if is_defect and (limit := resource.getrlimit(kind)[0]) != resource.RLIM_INFINITY:
            cause += f", or a library that does not expect the limit: ulimit -{option} is {limit >> 10}"
    if exit.signal == signal.SIGKILL:
        cause = "sent by a user, or by the system for lack of memory"
    reason = f"killed by signal {exit.signal}, {name} ({cause})."
    log = exit.log_file if is_defect else ""
    return lost(exit.component, exit.host, exit.rank, reason, step, log=log, was_killed=not is_defect)


def _of_exit(exit: Exit, step: int, host: str) -> Failure:
    """Failure known by an exit code alone."""
    if exit.code == ExitCode.COMPONENT_LOST and exit.component != "coupler":
        reporter = COMPONENTS.get(exit.component, exit.component)
        reason = f"it no longer answers (reported by the {reporter}, which stopped waiting for it)."
        return lost("coupler", host, "0", reason, step)
    code = exit.code if exit.code in _CODES_OF_COMPONENTS else ExitCode.COMPONENT_LOST
    when = " before the run ended" if exit.code == 0 else ""
    last_line = _last_line(exit.output, exit.log)
    how = f"; the last it wrote: «{last_line}»." if last_line else " without reporting an error."
    reason = f"exited with code {exit.code}{when}{how}"
    return Failure(code, exit.component, exit.host, exit.rank, step, reason, exit.log_file)


def _last_line(output: str, log: str) -> str:
    """The last error in its log or, as `error: …`, in its output; or else the last line of its own that is neither
    mpirun's nor a note in the log; what mpirun wrote if the program wrote nothing."""
    parsed = [(line, _LOG_LINE.match(line)) for line in _lines(log)]
    errors = [match["text"] for _, match in parsed if match and match["level"].lower() in ("error", "critical")]
    errors = errors or [line.removeprefix("error: ") for line in _lines(output) if line.startswith("error: ")]
    own, *of_mpirun = output.split("-----------------")
    lines = errors or _lines(own) or [line for line, match in parsed if not match]
    lines = lines or [" ".join(_lines(text)) for text in of_mpirun if _lines(text)][:1]
    return lines[-1][:300].rstrip(".") if lines else ""


def _lines(text: str) -> list[str]:
    """With words in them: not those that only draw a frame."""
    return [line.strip() for line in text.splitlines() if any(character.isalnum() for character in line)]
