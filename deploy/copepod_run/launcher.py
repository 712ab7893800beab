"""The processes of a run on this machine: each in a session of its own, marked, ended with this command. Campaigns and
Python start a whole run as one process."""

import os
import secrets
import subprocess
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import IO, Any

from copepod_run import cleanup
from copepod_run.cleanup import COMPONENT, MARK
from copepod_run.outcome import Exit, Failure, describe_exit, lost
from copepod_run.processes import ENDED, Attention, Looker, Wrong, adopt_orphans
from copepod_run.processes import family_of, own_host, reap_orphans, start_child, state_of
from copepod_run.progress import Event, EventReader
from copepod_run.run_directory import shown
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
        self.processes: dict[str, "Process"] = {}  # that have been started, by name
        self._attention, self._was_away = Attention(), False  # whether this command was, at the last look
        self._looker = Looker(own_host())
        self._since: dict[Wrong, float] = {}  # when that was seen first

    def start(
        self, name: str, command: Sequence[str], environment: Mapping[str, str], logs: Path, events: int | None = None
    ) -> None:
        """Starts `command`; both outputs go to NAME.out in `logs`, except that stdout may be the pipe end `events`.

        Raises OSError if it cannot be started.
        """
        variables = {**environment, MARK: self._scratch.mark, COMPONENT: name}
        self.processes[name] = Process(name, command, variables, logs, events)

    def look(self) -> Failure | None:
        """What cannot continue: a process stopped by a signal, or a rank whose end mpirun missed, for too long."""
        now, self._was_away = time.monotonic(), self._attention.was_away()
        known = {} if self._was_away else self._since  # what was too late may have been in time
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
        for process in self.processes.values():
            process.collect()
        reap_orphans()
        cleanup.remove_folders(self._scratch.folders)
        self._guard.dismiss()

    def _wrong(self) -> Iterator[Wrong]:
        """Every process that is not as it should be."""
        pids = [pid for process in self.processes.values() for pid in family_of(process.pid)]
        return self._looker.wrong(pids, self._fluid_lives())

    def _fluid_lives(self) -> bool:
        """Whether mpirun does."""
        return "fluid" in self.processes and state_of(self.processes["fluid"].pid) not in ENDED


@contextmanager
def guarded_folder() -> Iterator[Scratch]:
    """A private folder, `run_path`, and marked processes of a command without a run directory: nothing of them remains.

    Every process that is to end with the command has `mark` as its COPEPOD_RUN. A folder taken from `folders` stays.
    """
    with closing(Scratch(None, secrets.token_hex(16))) as scratch, closing(Launcher(scratch, scratch.locks)):
        yield scratch


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

    def exit(self, ranks: int) -> Exit:
        """How it has ended."""
        output, log = self.tail(self.output), self.tail(self.log)
        log_file = shown(self.log if log else self.output)
        return describe_exit(self.name, self.returncode or 0, output, self.host, ranks, log, log_file)

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


class RunProcess:
    """A `copepod run`: its events, its lines, and how it ends.

    It ends with the thread that has started it. SIGTERM lets it write a checkpoint.
    """

    def __init__(self, command: Sequence[str], environment: Mapping[str, str], output: IO[bytes] | int) -> None:
        """`command`: up to its options; `output`: for the result table."""
        streams: dict[str, Any] = {"stdin": subprocess.DEVNULL, "stdout": output, "stderr": subprocess.PIPE}
        self._popen = start_child([*command, "--progress", "json"], env=environment, **streams)
        assert self._popen.stderr is not None
        self._stderr = self._popen.stderr
        self.descriptor = self._stderr.fileno()  # becomes readable when there is something to read()
        self.exit_code: int | None = None  # 128 + number if a signal has ended it
        self._reader = EventReader(on_other=lambda line: self._note(line.decode(errors="replace")))

    def read(self) -> None:
        """Takes what has arrived, after waiting for some; at the end of the process `exit_code` is set."""
        received = os.read(self.descriptor, 65536)
        for event in self._reader.feed(received):
            if event["event"] == "notice":
                self._note(f"copepod: {event['text']}")
            else:
                self._take(event)
        if not received:
            code = self._popen.wait()
            self._stderr.close()
            self.exit_code = code if code >= 0 else 128 - code

    def _take(self, event: Event) -> None:
        """For derived classes: an event that is not a notice."""

    def _note(self, line: str) -> None:
        """For derived classes: a line for people."""

    def send(self, number: int) -> None:
        self._popen.send_signal(number)
