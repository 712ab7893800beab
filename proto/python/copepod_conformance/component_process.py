"""The processes of a component: started, counted, measured, ended."""

import os
import signal
import subprocess
import tempfile
import time
import uuid
from contextlib import suppress
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path

import zmq

_TRIAL = "COPEPOD_TRIAL"  # in the environment of all processes of one trial, including grandchildren
_CLOCK_TICKS = os.sysconf("SC_CLK_TCK")
_END_S = 2.0  # for what the first process leaves behind: mpirun's ranks need a moment


@dataclass
class Component:
    """How to start a component, and how long to wait for its answers."""

    command: list
    environment: dict
    folder: str  # everything that is written goes below it
    context: zmq.Context
    patience_s: float
    shows_output: bool = False  # on the terminal; otherwise it is kept for reports

    def run_to_end(self, *options, standard_input=b""):
        """Exit code (None if it did not end by itself), standard output and last words of a process of its own."""
        with tempfile.TemporaryDirectory(prefix="copepod-conformance-") as folder:
            given = Path(folder, "stdin")
            given.write_bytes(standard_input)
            process = ComponentProcess([*self.command, *options], self.environment, folder, given=given)
            try:
                return process.exit_code(self.patience_s), process.output(), process.last_words()
            finally:
                process.end()


class ComponentProcess:
    def __init__(self, command, environment, folder, shows_output=False, given=os.devnull):
        """Unless shown, standard output and error become files in `folder`. Raises OSError if it cannot be started.

        `given`: file that becomes its standard input.
        """
        self._mark = f"{_TRIAL}={uuid.uuid4().hex}"
        name, value = self._mark.split("=")
        self._output, self._errors = Path(folder, "stdout"), Path(folder, "stderr")
        with open(self._output, "wb") as output, open(self._errors, "wb") as errors, open(given, "rb") as source:
            self._popen = subprocess.Popen(
                command,
                # Components that are started by mpirun at the same time would share a folder otherwise, which the one
                # that ends removes while another starts.
                env={**environment, "OMPI_MCA_orte_tmpdir_base": os.path.abspath(folder), name: value},
                stdin=source,
                stdout=None if shows_output else output,
                stderr=None if shows_output else errors,
                start_new_session=True,
            )

    def exit_code(self, within_s=0.0):
        """None if it still lives after `within_s`; minus the signal's number if one killed it."""
        try:
            return self._popen.wait(within_s) if within_s else self._popen.poll()
        except subprocess.TimeoutExpired:
            return None

    def left_behind(self):
        """Command lines of processes that outlive the component by more than a moment."""
        deadline = time.monotonic() + _END_S
        while (alive := marked_processes(self._mark)) and time.monotonic() < deadline:
            time.sleep(0.05)
        return [_command_line(pid) for pid in alive]

    def send_signal(self, number):
        """To each of its processes."""
        signal_marked(self._mark, number)

    def cpu_seconds(self):
        """CPU time so far of each of its processes, by process id."""
        return {pid: _cpu_seconds(pid) for pid in marked_processes(self._mark)}

    def last_words(self, *logs):
        """The last line of its logs, or else of what it printed; a line «error: …» comes before what mpirun adds.

        If that is a line of dashes, by which mpirun frames its messages, what is inside the frame.
        """
        texts = (path.read_text(errors="replace") for path in (*logs, self._errors, self._output) if path.exists())
        lines = next((text.strip().split("\n") for text in texts if text.strip()), [""])
        if error := next((line for line in reversed(lines) if line.startswith("error: ")), ""):
            return error
        if not lines[-1].startswith("-----"):
            return lines[-1]
        inside = takewhile(lambda line: not line.startswith("-----"), reversed(lines[:-1]))
        return " ".join(line.strip() for line in reversed([*inside]) if line.strip())

    def output(self):
        """What it wrote to its standard output."""
        return self._output.read_text(errors="replace")

    def end(self):
        """Ends whatever is left of it."""
        signal_marked(self._mark, signal.SIGKILL)
        self._popen.kill()
        self._popen.wait()


def marked_processes(mark):
    """Process ids whose environment holds `mark` («NAME=value»), without this process and zombies."""
    others = (int(entry) for entry in os.listdir("/proc") if entry.isdigit() and int(entry) != os.getpid())
    return [pid for pid in others if mark.encode() in _about(pid, "environ").split(b"\0")]


def signal_marked(mark, number):
    """Sends a signal to every process that carries the mark."""
    for pid in marked_processes(mark):
        with suppress(ProcessLookupError):
            os.kill(pid, number)


def _about(pid, file):
    """A file of /proc about a process; empty if the process has ended meanwhile, or belongs to another user."""
    try:
        return Path("/proc", str(pid), file).read_bytes()
    except OSError:
        return b""


def _command_line(pid):
    return _about(pid, "cmdline").replace(b"\0", b" ").decode(errors="replace").strip() or f"process {pid}"


def _cpu_seconds(pid):
    fields = _about(pid, "stat").rpartition(b")")[2].split()
    return (int(fields[11]) + int(fields[12])) / _CLOCK_TICKS if fields else 0.0
