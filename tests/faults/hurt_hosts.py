"""A run over three hosts that is halted in a step, hurt on one of them, looked after on all, and gone on with."""

import ctypes
import os
import re
import shlex
import signal
import subprocess
import tempfile
import threading
import time
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from hurt_run import CASE, LONGEST_S, PROGRAMS, ROOT, Session, digest, has_checkpoint, wait_for
from three_hosts import Hosts, clean_within

CLEAN_WITHIN_S = 5.0  # after the end of the command
HALT_AT = 45
_SETTINGS = ("--set", "run.steps=60", "--set", "output.checkpoint.every_steps=20")
_GUARDS = {"guard": "COPEPOD_GUARD", "starter": "COPEPOD_STARTER"}

# What can be hurt where, and what the last line of the command must contain if it is killed there.
VICTIMS = {
    ("a", "command"): "",
    ("a", "coupler"): "coupler on host a.* killed by signal 9",
    ("a", "body"): "body service on host a.* killed by signal 9",
    ("a", "mpirun"): "fluid service on host a, rank 0-2.* killed by signal 9",
    ("a", "agent"): "mpirun lost the connection to|host [bc]",
    ("a", "rank"): "fluid service on host a, rank 0.* killed by signal 9",
    ("a", "connection"): "host [bc]",
    ("b", "rank"): "fluid service on host b, rank 1.* killed by signal 9",
    ("c", "rank"): "fluid service on host c, rank 2.* killed by signal 9",
    **{(host, kind): f"host {host}" for kind in ("orted", "guard", "starter", "sshd") for host in ("b", "c")},
}


class HostsRun(Session):
    """One `copepod run` on host a of `hosts`, in a folder on the disk that they share."""

    def __init__(self, hosts, folder, *arguments):
        program, *words = hosts.command(
            "a", "env", "-C", folder, ROOT / "deploy/copepod", "run", CASE, *_SETTINGS, *arguments
        )
        self.hosts = hosts
        super().__init__(words, folder, PROGRAMS, {"COPEPOD_SSH": hosts.ssh}, program)

    def victims(self, host, kind):
        """Processes of that kind on a host."""
        return [pid for pid, variables in self.hosts.processes(host).items() if self._is(kind, pid, variables)]

    def _is(self, kind, pid, variables):
        name, marked = _name(pid), "COPEPOD_RUN" in variables
        if kind in _GUARDS:
            return _GUARDS[kind] in variables and name == "python3"
        if kind == "rank":
            return "OMPI_COMM_WORLD_RANK" in variables
        if kind in ("coupler", "body"):
            return variables.get("COPEPOD_COMPONENT") == kind
        if kind == "command":
            return not marked and b"copepod_command" in _command_line(pid)
        if kind == "agent":
            return marked and b"copepod_run.hosts" in _command_line(pid)
        if kind == "connection":
            return name == "ssh"
        if kind == "sshd":  # of a connection, not the one that listens
            return name == "sshd" and b"@notty" in _command_line(pid)
        return marked and name == kind


@dataclass
class Outcome:
    """What came of one fault."""

    code: int | None  # None: not over in time
    message: str
    seconds: float  # from the fault to the end of the command
    clean_s: float  # from there until nothing was left on any host
    left: list
    digest: str = ""

    def problems(self, words, expected_digest):
        wrong = [f"left behind: {', '.join(self.left)}"] if self.left else []
        if self.clean_s > CLEAN_WITHIN_S:
            wrong.append(f"clean only after {self.clean_s:.1f} s")
        if self.code is None:
            wrong.append(self.message)
        elif self.code != 0 and not re.search(words, self.message):
            wrong.append(f"not named: {self.message}")
        if self.digest != expected_digest:
            wrong.append(f"digest {self.digest or 'missing'} instead of {expected_digest}")
        return wrong


@contextmanager
def three_hosts():
    """(hosts, a folder on the disk that they share)"""
    with tempfile.TemporaryDirectory(prefix="copepod_hosts_", dir="/var/tmp") as folder:
        folder = Path(folder).resolve()
        hosts = Hosts(folder)
        try:
            yield hosts, folder
        finally:
            hosts.close()


def start_halted(hosts, folder, *arguments, placement="a,b,c"):
    """A run that stands still in a step until the file `halted` is removed."""
    words = [PROGRAMS / "halting_fluid", "--halt-in", "exchange", "--halt-at-step", HALT_AT, "--halt-rank", 0]
    command = shlex.join(map(str, [*words, "--halt-file", folder / "halted"]))
    run = HostsRun(hosts, folder, "--out", "out", "--hosts", placement, "--fluid", command, *arguments)
    if not wait_for(lambda: (folder / "halted").exists() or run.process.poll() is not None, LONGEST_S):
        run.process.kill()
    if not (folder / "halted").exists():
        raise AssertionError(f"the step was never reached:\n{''.join(run.stderr)}")
    return run


def finish(hosts, folder, *arguments, placement="a,b,c"):
    """Digest of the run, resumed if it has a checkpoint; or its last line if it fails or takes too long."""
    resumes = has_checkpoint(folder)
    if not resumes and (folder / "out").exists():
        (folder / "out").rename(folder / f"out_{time.monotonic_ns()}")
    words = ["--out", "out", "--hosts", placement, *(["--resume"] if resumes else []), *arguments]
    run = HostsRun(hosts, folder, *words)
    return digest(folder) if end_of(run) == 0 else run.last_line


def end_of(run):
    """Exit code of a run; None if it takes too long and is killed, and its last line shows what was there then."""
    try:
        return run.end(LONGEST_S)
    except subprocess.TimeoutExpired:
        found = "; ".join(line[:100] for line in run.hosts.left())
        for pid in run.victims("a", "command"):
            os.kill(pid, signal.SIGKILL)
        run.end()
        run.stderr.append(f"not over after {LONGEST_S} s, after {''.join(run.stderr[-1:]).strip()}: {found}\n")
        return None


def outcome_of(run, since):
    """Waits for the end of a run that was hurt at the time `since`."""
    code = end_of(run)
    seconds = time.monotonic() - since
    clean_s, left = clean_within(run.hosts, CLEAN_WITHIN_S + 5)
    return Outcome(code, run.stderr[-1].strip() if run.stderr else "", seconds, clean_s, left)


@contextmanager
def held(pid):
    """A process that notices nothing meanwhile: its threads are traced, a state that Copepod does not look for."""
    seize, interrupt = 0x4206, 0x4207  # <sys/ptrace.h>
    is_held, is_over = threading.Event(), threading.Event()

    def trace():  # the end of the thread that traces ends that
        ptrace = ctypes.CDLL(None).ptrace
        results = [
            ptrace(request, int(thread.name), None, None)
            for thread in Path(f"/proc/{pid}/task").iterdir()
            for request in (seize, interrupt)
        ]
        if not any(results):
            is_held.set()
        is_over.wait()

    tracer = threading.Thread(target=trace)
    tracer.start()
    try:
        assert is_held.wait(5), f"process {pid} cannot be traced"
        yield
    finally:
        is_over.set()
        tracer.join()


def hurt(host, kind, number=signal.SIGKILL, *arguments, cut_off=None, unaware=None):
    """Outcome of one signal to one process while a host is `cut_off`, or a kind of process on host a `unaware` of all;
    the run resumed afterwards."""
    with three_hosts() as (hosts, folder):
        run = start_halted(hosts, folder, *arguments)
        if cut_off:
            hosts.cut(cut_off)
        with ExitStack() as stack:
            if unaware:
                stack.enter_context(held(run.victims("a", unaware)[0]))
            start = time.monotonic()
            os.kill(run.victims(host, kind)[0], number)
            outcome = outcome_of(run, start)
        hosts.mend()
        (folder / "halted").unlink(missing_ok=True)
        outcome.digest = finish(hosts, folder)
        return outcome


def cut(host, direction, seconds, *arguments, placement="a,b,c"):
    """Outcome of a network that is cut for a while while the run continues; resumed if it has failed."""
    with three_hosts() as (hosts, folder):
        run = start_halted(hosts, folder, *arguments, placement=placement)
        start = time.monotonic()
        hosts.cut(host, direction)
        (folder / "halted").unlink()
        wait_for(lambda: run.process.poll() is not None, seconds)
        if run.process.poll() is None:
            hosts.mend()
        outcome = outcome_of(run, start)
        hosts.mend()
        outcome.digest = digest(folder) if outcome.code == 0 else finish(hosts, folder, placement=placement)
        return outcome


def _name(pid):
    try:
        return Path(f"/proc/{pid}/comm").read_text().strip()
    except OSError:
        return ""


def _command_line(pid):
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return b""
