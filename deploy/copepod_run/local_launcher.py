"""Processes on this machine: each in a session of its own, marked, ended with this command, noticed when it dies."""

import ctypes
import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from copepod_run import cleanup
from copepod_run.cleanup import COMPONENT, MARK
from copepod_run.launcher import Launcher, Process, Trouble

_STOPPED_FOR_S = 1.4  # longer than by accident; with the looks and the clean-up it remains below three seconds
_ENDED_FOR_S = 2.0  # mpirun had its time to report how a rank ended
_AWAY_S = 1.5  # this command was stopped itself (Ctrl-Z, a suspended machine): the clocks start again
_ENDED = (None, "Z", "X")
_TAIL_BYTES = 8192
_PR_SET_PDEATHSIG = 1
_PR_SET_CHILD_SUBREAPER = 36
_libc = ctypes.CDLL(None, use_errno=True)


class LocalLauncher(Launcher):
    """All processes of the run are children of this command; a guard cleans up if the command is killed."""

    def __init__(
        self, mark: str, folders: Sequence[Path], locks: Sequence[int], clock: Callable[[], float] = time.monotonic
    ) -> None:
        """`mark`: value of COPEPOD_RUN for all processes; `folders`: removed at the end; `locks`: the guard's, too."""
        # Grandchildren whose parent dies become ours, so that none escapes.
        _libc.prctl(_PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
        self._mark = mark
        self._folders = folders
        self._guard = cleanup.Guard(f"{MARK}={mark}", folders, locks)
        self._processes: list[LocalProcess] = []
        self._clock = clock
        self._last_look = clock()
        self._ranks: dict[int, str] = {}  # process id: rank
        self._since: dict[tuple[int, str], float] = {}  # (process id, what is wrong with it): when that was seen first

    def start(
        self, name: str, command: Sequence[str], environment: Mapping[str, str], logs: Path, events: int | None = None
    ) -> Process:
        variables = {**environment, MARK: self._mark, COMPONENT: name}
        process = LocalProcess(name, command, variables, logs, events)
        self._processes.append(process)
        return process

    def look(self) -> Trouble | None:
        now = self._clock()
        was_away = now - self._last_look > _AWAY_S
        self._last_look = now
        known = {} if was_away else self._since
        self._since = {wrong: known.get(wrong, now) for wrong in self._wrong()}
        for (pid, what), since in self._since.items():
            if what == "stopped" and now - since >= _STOPPED_FOR_S:
                return _stopped(pid)
            if what == "ended" and now - since >= _ENDED_FOR_S:
                return Trouble("fluid", _host(), self._ranks[pid], "it has ended, and mpirun did not notice.")
        return None

    def has_ended_rank(self) -> bool:
        return any(what == "ended" for _, what in self._since)

    def end_all(self) -> int:
        return cleanup.end_marked(f"{MARK}={self._mark}")

    def close(self) -> None:
        self.end_all()
        for process in self._processes:
            process.collect()
        _reap_orphans()
        cleanup.remove_folders(self._folders)
        self._guard.dismiss()

    def _wrong(self) -> Iterator[tuple[int, str]]:
        """(process id, stopped or ended) of every process that is not as it should be."""
        states = {pid: _state(pid) for process in self._processes for pid in _family(process.pid)}
        for pid, state in states.items():
            rank = None if pid in self._ranks else _environment(pid).get("OMPI_COMM_WORLD_RANK")
            if rank is not None:
                self._ranks[pid] = rank
            if state == "T":
                yield pid, "stopped"
        fluid = next((process.pid for process in self._processes if process.name == "fluid"), None)
        if fluid is not None and states.get(fluid) not in _ENDED:
            yield from ((pid, "ended") for pid in self._ranks if states.get(pid) in _ENDED)


class LocalProcess(Process):
    """A process group of this machine."""

    def __init__(
        self, name: str, command: Sequence[str], environment: Mapping[str, str], logs: Path, events: int | None
    ) -> None:
        """Starts `command`; a restart appends to the same files. Raises OSError if it cannot be started."""
        self.name, self.host = name, _host()
        self.output, self.log = logs / f"{name}.out", logs / f"{name}.log"
        self._starts = {path: path.stat().st_size if path.exists() else 0 for path in (self.output, self.log)}
        parent = os.getpid()
        with open(self.output, "ab") as output:
            self._popen = subprocess.Popen(
                command,
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=output if events is None else events,
                stderr=output,
                start_new_session=True,
                preexec_fn=lambda: end_with_parent(parent),
            )
        self.pid = self._popen.pid
        self.descriptor = os.pidfd_open(self.pid)

    @property
    def returncode(self) -> int | None:
        return self._popen.poll()

    def send(self, number: int) -> None:
        try:
            os.killpg(self.pid, number)
        except (ProcessLookupError, PermissionError):
            pass

    def tail(self) -> str:
        return self._tail(self.output)

    def log_tail(self) -> str:
        return self._tail(self.log)

    def collect(self) -> None:
        """Waits for the ended process, so that no zombie is left."""
        try:
            self._popen.wait(timeout=1)
        except subprocess.TimeoutExpired:  # hangs in the kernel; end_all() has counted it
            pass
        os.close(self.descriptor)

    def _tail(self, path: Path) -> str:
        """The end of what was added to a file since the start; empty if there is no such file."""
        try:
            with open(path, "rb") as file:
                size = file.seek(0, os.SEEK_END)
                file.seek(max(self._starts[path], size - _TAIL_BYTES))
                return file.read().decode(errors="replace")
        except FileNotFoundError:
            return ""


def end_with_parent(parent: int) -> None:
    """Runs in the child: SIGTERM if this command dies, whatever kills it. mpirun then ends its ranks too."""
    _libc.prctl(_PR_SET_PDEATHSIG, signal.SIGTERM, 0, 0, 0)
    if os.getppid() != parent:
        os._exit(1)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGPIPE):
        signal.signal(number, signal.SIG_DFL)


def _host() -> str:
    return os.uname().nodename


def _family(pid: int) -> list[int]:
    """A process and all its descendants."""
    family = [pid]
    for member in family:
        for children in Path("/proc", str(member), "task").glob("*/children"):
            try:
                family += map(int, children.read_text().split())
            except OSError:  # ended meanwhile
                pass
    return family


def _state(pid: int) -> str | None:
    """One letter as in ps: R, S, D, T (stopped by a signal), Z; None if the process does not exist."""
    try:
        return Path("/proc", str(pid), "stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return None


def _environment(pid: int) -> dict[str, str]:
    """Environment of a process; empty if it cannot be read."""
    try:
        pairs = Path("/proc", str(pid), "environ").read_bytes().decode(errors="replace").split("\0")
    except OSError:
        return {}
    return {name: value for name, separator, value in (pair.partition("=") for pair in pairs) if separator}


def _stopped(pid: int) -> Trouble:
    variables = _environment(pid)
    try:
        program = Path("/proc", str(pid), "comm").read_text().strip()
    except OSError:
        program = "ended"
    reason = f"frozen: its process {pid} ({program}) is stopped (SIGSTOP, a terminal, or a debugger)."
    return Trouble(variables.get(COMPONENT, ""), _host(), variables.get("OMPI_COMM_WORLD_RANK", "0"), reason)


def _reap_orphans() -> None:
    """Collects adopted orphans that have ended, once our own processes have been waited for."""
    try:
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass
    except ChildProcessError:
        pass
