"""The processes of a run on this host as /proc shows them: which there are, and what is wrong with them."""

import ctypes
import glob
import os
import signal
import subprocess
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from copepod_run.cleanup import COMPONENT

ENDED = (None, "Z", "X")
_AWAY_S = 1.5
_PR_SET_PDEATHSIG = 1
_PR_SET_CHILD_SUBREAPER = 36
_libc = ctypes.CDLL(None, use_errno=True)


@dataclass(frozen=True)
class Wrong:
    """A process that is not as it should be."""

    host: str
    pid: int
    what: str  # "stopped" by a signal, or "ended" although it is a rank of a fluid that has not
    component: str
    rank: str
    program: str


class Looker:
    """Looks at processes again and again, and remembers the ranks that have ended."""

    def __init__(self, host: str) -> None:
        self._host = host
        self._ranks: dict[int, str] = {}  # process id: rank

    def wrong(self, pids: Iterable[int], fluid_lives: bool) -> Iterator[Wrong]:
        """`fluid_lives`: whether the ranks should still be there."""
        states = {pid: state_of(pid) for pid in pids}
        for pid, state in states.items():
            rank = None if pid in self._ranks else environment_of(pid).get("OMPI_COMM_WORLD_RANK")
            if rank is not None:
                self._ranks[pid] = rank
            if state == "T":
                variables, program = environment_of(pid), "ended"
                with suppress(OSError):
                    program = Path("/proc", str(pid), "comm").read_text().strip()
                component = variables.get(COMPONENT, "guard")  # or its connection
                rank = variables.get("OMPI_COMM_WORLD_RANK", "" if component == "guard" else "0")
                yield Wrong(self._host, pid, "stopped", component, rank, program)
        if fluid_lives:
            for pid, rank in self._ranks.items():
                if states.get(pid) in ENDED:
                    yield Wrong(self._host, pid, "ended", "fluid", rank, "")


class Attention:
    """Notices that this process was stopped itself (Ctrl-Z, a suspended machine): its clocks then start again."""

    def __init__(self) -> None:
        self._looked = time.monotonic()

    def was_away(self) -> bool:
        """Whether the last question, one of two in a second, is longer ago than it should be."""
        since, self._looked = self._looked, time.monotonic()
        return self._looked - since > _AWAY_S


def own_host() -> str:
    return os.uname().nodename


def family_of(pid: int) -> list[int]:
    """A process and all its descendants."""
    family = [pid]
    for member in family:
        for children in glob.glob(f"/proc/{member}/task/*/children"):  # Path.glob fails if the process ends meanwhile
            with suppress(OSError):  # ended meanwhile
                family += map(int, Path(children).read_text().split())
    return family


def state_of(pid: int) -> str | None:
    """One letter as in ps: R, S, D, T (stopped by a signal), Z; None if the process does not exist."""
    try:
        return Path("/proc", str(pid), "stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return None


def environment_of(pid: int) -> dict[str, str]:
    """Environment of a process; empty if it cannot be read."""
    try:
        pairs = Path("/proc", str(pid), "environ").read_bytes().decode(errors="replace").split("\0")
    except OSError:
        return {}
    return {name: value for name, separator, value in (pair.partition("=") for pair in pairs) if separator}


def adopt_orphans() -> None:
    """Grandchildren whose parent dies become ours, so that none escapes."""
    _libc.prctl(_PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def reap_orphans() -> None:
    """Collects adopted orphans that have ended, once our own processes have been waited for."""
    with suppress(ChildProcessError):
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass


def start_child(command: Sequence[str], number: int = signal.SIGTERM, **streams: Any) -> subprocess.Popen[bytes]:
    """Starts a process in a session of its own, which gets this signal if we die; `streams`: as for Popen."""
    parent = os.getpid()
    return subprocess.Popen(
        command, start_new_session=True, preexec_fn=lambda: end_with_parent(parent, number), **streams
    )


def end_with_parent(parent: int, number: int = signal.SIGTERM) -> None:
    """Runs in the child: this signal if the parent dies, whatever kills it. mpirun then ends its ranks too."""
    _libc.prctl(_PR_SET_PDEATHSIG, number, 0, 0, 0)
    if os.getppid() != parent:
        os._exit(1)
    for default in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGPIPE):
        signal.signal(default, signal.SIG_DFL)
    signal.signal(signal.SIGUSR1, signal.SIG_IGN)  # asks for a checkpoint: nothing ends before the coupler can answer
