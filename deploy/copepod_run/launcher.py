"""The processes of a run on this machine: each in a session of its own, marked, ended with this command."""

import os
import subprocess
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from copepod_run import cleanup
from copepod_run.cleanup import COMPONENT, MARK
from copepod_run.outcome import Failure, lost
from copepod_run.processes import ENDED, Attention, Looker, Wrong, adopt_orphans
from copepod_run.processes import family_of, own_host, reap_orphans, start_child, state_of
from copepod_run.scratch import Scratch

LOOK_EVERY_S = 0.5  # how often look() is called
_STOPPED_FOR_S = 1.4  # longer than by accident; with the looks and the clean-up it remains below three seconds
_ENDED_FOR_S = 2.0  # mpirun had its time to report how a rank ended
_TAIL_BYTES = 8192


class Launcher:
    """Starts the processes of one attempt of a run and leaves nothing of them behind: all are children of this command,
    and a guard cleans up if the command is killed.

    Calls: start() for every component, then any others, then close(), also after an error.
    """

    ended_for_s = _ENDED_FOR_S  # how long a rank may have ended before mpirun has

    def __init__(self, scratch: Scratch, locks: Sequence[int]) -> None:
        """`scratch`: with the value of COPEPOD_RUN for all processes; removed at the end; `locks`: the guard's, too."""
        adopt_orphans()
        self._scratch = scratch
        self._guard = cleanup.Guard(f"{MARK}={scratch.mark}", scratch.folders, locks)
        self._processes: list["Process"] = []
        self._attention = Attention()
        self._looker = Looker(own_host())
        self._since: dict[Wrong, float] = {}  # when that was seen first

    def start(
        self, name: str, command: Sequence[str], environment: Mapping[str, str], logs: Path, events: int | None = None
    ) -> "Process":
        """Starts `command`; both outputs go to NAME.out in `logs`, except that stdout may be the pipe end `events`.

        Raises OSError if it cannot be started.
        """
        variables = {**environment, MARK: self._scratch.mark, COMPONENT: name}
        process = Process(name, command, variables, logs, events)
        self._processes.append(process)
        return process

    def look(self) -> Failure | None:
        """What cannot continue: a process stopped by a signal, or a rank whose end mpirun missed, for too long."""
        now, was_away = time.monotonic(), self._attention.was_away()
        known = {} if was_away else self._since
        if was_away:
            self._forgive()
        self._since = {wrong: known.get(wrong, now) for wrong in self._wrong()}
        for wrong, since in self._since.items():
            if wrong.what == "stopped" and now - since >= _STOPPED_FOR_S:
                how = f"its process {wrong.pid} ({wrong.program}) is stopped (SIGSTOP, a terminal, or a debugger)."
                return lost(wrong.component, wrong.host, wrong.rank, f"frozen: {how}")
            if wrong.what == "ended" and now - since >= self.ended_for_s:
                return lost("fluid", wrong.host, wrong.rank, "it has ended, and mpirun did not notice.")
        return None

    def has_ended_rank(self) -> bool:
        """Whether the last look() found a rank that had ended while mpirun had not."""
        return any(wrong.what == "ended" for wrong in self._since)

    def end_all(self) -> int:
        """Ends every process, with SIGTERM first; returns how many could not be ended."""
        return cleanup.end_marked(f"{MARK}={self._scratch.mark}")

    def close(self) -> None:
        """Ends what is left and removes every temporary file."""
        self.end_all()
        for process in self._processes:
            process.collect()
        reap_orphans()
        cleanup.remove_folders(self._scratch.folders)
        self._guard.dismiss()

    def _forgive(self) -> None:
        """This command was away: what was too late may have been in time."""

    def _wrong(self) -> Iterator[Wrong]:
        """Every process that is not as it should be."""
        yield from self._looker.wrong(
            [pid for process in self._processes for pid in family_of(process.pid)], self._fluid_lives()
        )

    def _fluid_lives(self) -> bool:
        """Whether mpirun does."""
        fluid = next((process.pid for process in self._processes if process.name == "fluid"), None)
        return fluid is not None and state_of(fluid) not in ENDED


class Process:
    """A component's process, or the starter of its ranks (mpirun), with its descendants."""

    def __init__(
        self, name: str, command: Sequence[str], environment: Mapping[str, str], logs: Path, events: int | None
    ) -> None:
        """Starts `command`; a restart appends to the same files. Raises OSError if it cannot be started."""
        self.name, self.host = name, own_host()
        self.output, self.log = logs / f"{name}.out", logs / f"{name}.log"  # the log is what it reports itself
        for path in (self.output, self.log):
            if path.is_symlink():  # in a run directory from elsewhere: what it leads to is not ours
                path.unlink()
        self._starts = {path: path.stat().st_size if path.exists() else 0 for path in (self.output, self.log)}
        with open(self.output, "ab") as output:
            stdout = output if events is None else events
            self._popen = start_child(command, env=environment, stdin=subprocess.DEVNULL, stdout=stdout, stderr=output)
        self.pid = self._popen.pid
        self.descriptor = os.pidfd_open(self.pid)  # becomes readable when the process ends

    @property
    def returncode(self) -> int | None:
        """As in subprocess: None while it lives, minus the signal's number if a signal ended it."""
        return self._popen.poll()

    def send(self, number: int) -> None:
        """A signal; does nothing if the process has ended."""
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(self.pid, number)

    def collect(self) -> None:
        """Waits for the ended process, so that no zombie is left."""
        with suppress(subprocess.TimeoutExpired):  # hangs in the kernel; end_all() has counted it
            self._popen.wait(timeout=1)
        os.close(self.descriptor)

    def tail(self, path: Path) -> str:
        """The end of what this attempt has added to its `output` or `log`; empty if there is no such file."""
        try:
            with open(path, "rb") as file:
                size = file.seek(0, os.SEEK_END)
                file.seek(max(self._starts[path], size - _TAIL_BYTES))
                return file.read().decode(errors="replace")
        except FileNotFoundError:
            return ""
