"""Finding every process and folder of a run by its mark and ending it; also from a process that outlives the command.

    cleanup.py MARK FOLDER…     stdin: a pipe that closes when the command ends

This file alone is the guard's program: it imports nothing of ours.
"""

import os
import shutil
import signal
import stat
import subprocess
import sys
import time
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

MARK = "COPEPOD_RUN"  # in the environment of every process of a run, so that none can get lost
CLAIM = ".copepod-run"  # a file in each folder that a run may remove: the run's mark and the folder's inode
COMPONENT = "COPEPOD_COMPONENT"  # in the environment too: which component the process belongs to
POLITE_S = 0.5  # between SIGTERM and SIGKILL
FINAL_S = 2.0  # after SIGKILL; longer only in uninterruptible sleep, where nothing can be done
_DISMISSED = b"done"


def marked_processes(mark: str) -> list[int]:
    """Process ids whose environment holds `mark` («NAME=value»), zombies left out."""
    wanted = mark.encode()
    found = []
    for entry in os.listdir("/proc"):
        if entry.isdigit() and int(entry) != os.getpid():
            with suppress(OSError):  # it has ended, or belongs to another user
                if wanted in Path("/proc", entry, "environ").read_bytes().split(b"\0"):
                    found.append(int(entry))
    return found


def end_marked(mark: str, patience_s: float = POLITE_S) -> int:
    """SIGTERM to all marked processes, SIGKILL to those that remain; returns how many could not be ended.

    A process that is stopped (SIGSTOP) obeys SIGTERM only when it is continued.
    """
    _signal_until_gone(mark, (signal.SIGTERM, signal.SIGCONT), patience_s)
    return _signal_until_gone(mark, (signal.SIGKILL,), FINAL_S)


def _signal_until_gone(mark: str, numbers: Iterable[int], patience_s: float) -> int:
    """Sends the signals to every marked process once, newcomers too, until none is left or patience ends."""
    deadline = time.monotonic() + patience_s
    signalled: set[int] = set()
    while True:
        alive = marked_processes(mark)
        for pid in alive:
            if pid not in signalled:
                signalled.add(pid)
                send(pid, *numbers)
        if not alive or time.monotonic() > deadline:
            return len(alive)
        time.sleep(0.02)


def send(pid: int, *numbers: int) -> None:
    """These signals; nothing if the process has ended."""
    with suppress(ProcessLookupError, PermissionError):
        for number in numbers:
            os.kill(pid, number)


def claim(folder: str | Path, mark: str) -> None:
    """Marks a folder that was just made as one that may be removed, contents and all. Raises OSError.

    The mark holds for this folder only, not for a copy of it: the file names the folder's inode.
    """
    write_private(Path(folder, CLAIM), f"{mark} {os.stat(folder).st_ino}\n")


def write_private(path: str | Path, text: str) -> None:
    """A new file that only its owner can read. Raises OSError."""
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
        file.write(text)


def is_claimed(folder: str | Path, mark: str | None = None) -> bool:
    """Whether `claim` marked this folder, as this user and for the run `mark` (None: for any run)."""
    try:
        folder_status, file_status = os.lstat(folder), os.lstat(Path(folder, CLAIM))
        own = {folder_status.st_uid, file_status.st_uid} == {os.geteuid()}
        if not (own and stat.S_ISDIR(folder_status.st_mode) and stat.S_ISREG(file_status.st_mode)):
            return False
        found_mark, _, inode = Path(folder, CLAIM).read_text().partition(" ")
    except (OSError, UnicodeDecodeError):
        return False
    return inode == f"{folder_status.st_ino}\n" and mark in (None, found_mark)


def remove_folders(folders: Iterable[str | Path]) -> None:
    """Removes those of the folders that are claimed; whatever else has such a name stays."""
    for folder in folders:
        if is_claimed(folder):
            shutil.rmtree(folder, ignore_errors=True)


class Guard:
    """A process that cleans up after a run if the command itself is killed (kill -9), and is dismissed otherwise.

    It keeps the locks of the run's folders until it is done, so that no other run uses or removes them too early.
    """

    def __init__(self, mark: str, folders: Sequence[Path], locks: Sequence[int] = ()) -> None:
        """`locks`: descriptors that lock the run directory and `folders`."""
        command = [sys.executable, "-S", "-P", __file__, mark, *map(str, folders)]
        streams: Any = {"stdin": subprocess.PIPE, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self._process = subprocess.Popen(command, **streams, start_new_session=True, pass_fds=locks, cwd="/")

    def dismiss(self) -> None:
        try:
            self._process.communicate(_DISMISSED, timeout=2)
        except (OSError, subprocess.TimeoutExpired):
            self._process.kill()
            self._process.wait()


def _stand_guard(mark: str, folders: Sequence[str]) -> None:
    """Waits for the pipe to close; unless dismissed, ends what is marked and removes the folders."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    if os.read(0, len(_DISMISSED)) != _DISMISSED:
        end_marked(mark)
        remove_folders(folders)


if __name__ == "__main__":
    _stand_guard(sys.argv[1], sys.argv[2:])
