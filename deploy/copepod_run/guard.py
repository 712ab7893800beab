"""Cleans up after a run when the command itself was killed (kill -9): a process of its own that waits for that.

    guard.py MARK FOLDER…     stdin: a pipe that closes when the command ends

It keeps the lock of the run directory until it is done, so that nobody starts there too early.
"""

import os
import signal
import subprocess
import sys
from pathlib import Path

_ALL_IS_WELL = b"done"


class Guard:
    """The command's side: starts the guard, and dismisses it once everything is cleaned up."""

    def __init__(self, mark, folders, lock=None):
        """`lock`: descriptor that locks the run directory, if there is one."""
        self._process = subprocess.Popen(
            [sys.executable, "-S", __file__, mark, *map(str, folders)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
            pass_fds=[] if lock is None else [lock],
            cwd="/",
        )

    def dismiss(self):
        try:
            self._process.communicate(_ALL_IS_WELL, timeout=2)
        except (OSError, subprocess.TimeoutExpired):
            self._process.kill()
            self._process.wait()


def watch_over(mark, folders):
    """Waits for the pipe to close; without the word that all is well, ends what is marked and removes the folders."""
    from copepod_run import cleanup

    if os.read(0, len(_ALL_IS_WELL)) != _ALL_IS_WELL:
        cleanup.end_marked(mark)
        cleanup.remove_folders(folders)


if __name__ == "__main__":
    sys.path[0] = str(Path(__file__).resolve().parent.parent)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    watch_over(sys.argv[1], sys.argv[2:])
