"""One process group of a run: started in a session of its own, ended with this command, noticed when it dies."""

import ctypes
import os
import signal
import subprocess

_TAIL_BYTES = 8192
_PR_SET_PDEATHSIG = 1
_PR_SET_CHILD_SUBREAPER = 36
_libc = ctypes.CDLL(None, use_errno=True)


def adopt_orphans():
    """Grandchildren whose parent died become ours, so that none escapes (prctl PR_SET_CHILD_SUBREAPER)."""
    _libc.prctl(_PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


class Text:
    """A file that a process appends to; a restart goes on in the same one."""

    def __init__(self, path):
        self._path = path
        self._start = path.stat().st_size if path.exists() else 0

    def tail(self):
        """The end of what came since; empty if there is no such file."""
        try:
            with open(self._path, "rb") as file:
                size = file.seek(0, os.SEEK_END)
                file.seek(max(self._start, size - _TAIL_BYTES))
                return file.read().decode(errors="replace")
        except FileNotFoundError:
            return ""


class Process:
    """A component's process, or the mpirun of its ranks."""

    def __init__(self, name, command, environment, folder, events=None):
        """Starts `command`; both outputs go to NAME.out in `folder`, except that stdout may be the pipe end `events`.

        Its log is NAME.log there.

        Raises OSError if it cannot be started.
        """
        self.name = name
        self._output, self._log = Text(folder / f"{name}.out"), Text(folder / f"{name}.log")
        parent = os.getpid()
        with open(folder / f"{name}.out", "ab") as log:
            self._popen = subprocess.Popen(
                command,
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=log if events is None else events,
                stderr=log,
                start_new_session=True,
                preexec_fn=lambda: end_with_parent(parent),
            )
        self.pid = self._popen.pid
        self.descriptor = os.pidfd_open(self.pid)  # becomes readable when the process ends

    @property
    def returncode(self):
        """As subprocess: None while it lives, minus the signal's number if one killed it."""
        return self._popen.poll()

    def send(self, number):
        """Signal to the whole process group."""
        try:
            os.killpg(self.pid, number)
        except (ProcessLookupError, PermissionError):
            pass

    def tail(self):
        """The last text that the process wrote to its outputs."""
        return self._output.tail()

    def log_tail(self):
        """The last text that it wrote to its log."""
        return self._log.tail()

    def wait(self):
        """Collects the ended process; call it after everything marked was ended."""
        try:
            self._popen.wait(timeout=1)
        except subprocess.TimeoutExpired:  # hangs in the kernel; the command has said so already
            pass
        os.close(self.descriptor)


def end_with_parent(parent):
    """Runs in the child: SIGTERM if this command dies, whatever kills it. mpirun then takes its ranks along."""
    _libc.prctl(_PR_SET_PDEATHSIG, signal.SIGTERM, 0, 0, 0)
    if os.getppid() != parent:
        os._exit(1)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGPIPE):
        signal.signal(number, signal.SIG_DFL)
