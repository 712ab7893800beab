"""Finding every process of a run by its mark and ending it, politely first."""

import os
import shutil
import signal
import time
from pathlib import Path

POLITE_S = 0.5  # between SIGTERM and SIGKILL
FINAL_S = 2.0  # after SIGKILL; longer only in uninterruptible sleep, where nothing can be done


def marked_processes(mark):
    """Process ids whose environment holds `mark` («NAME=value»), zombies left out."""
    wanted = mark.encode()
    found = []
    for entry in os.listdir("/proc"):
        if entry.isdigit() and int(entry) != os.getpid():
            try:
                if wanted in Path("/proc", entry, "environ").read_bytes().split(b"\0"):
                    found.append(int(entry))
            except OSError:  # gone meanwhile, or somebody else's
                pass
    return found


def process_state(pid):
    """One letter as in ps: R, S, D, T (stopped by a signal), Z; None if there is no such process."""
    try:
        return Path("/proc", str(pid), "stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return None


def environment_of(pid):
    """Environment of a process as a dictionary; empty if it cannot be read."""
    try:
        pairs = Path("/proc", str(pid), "environ").read_bytes().decode(errors="replace").split("\0")
    except OSError:
        return {}
    return dict(pair.split("=", 1) for pair in pairs if "=" in pair)


def end_marked(mark, patience_s=POLITE_S):
    """SIGTERM to all marked processes, SIGKILL to those that stay; returns how many would not go.

    A process that is stopped (SIGSTOP) obeys SIGTERM only when it is continued.
    """
    _signal_until_gone(mark, (signal.SIGTERM, signal.SIGCONT), patience_s)
    return _signal_until_gone(mark, (signal.SIGKILL,), FINAL_S)


def _signal_until_gone(mark, numbers, patience_s):
    """Sends the signals to every marked process once, newcomers too, until none is left or patience ends."""
    deadline = time.monotonic() + patience_s
    signalled = set()
    while True:
        alive = marked_processes(mark)
        for pid in alive:
            if pid not in signalled:
                signalled.add(pid)
                _send(pid, numbers)
        if not alive or time.monotonic() > deadline:
            return len(alive)
        time.sleep(0.02)


def _send(pid, numbers):
    try:
        for number in numbers:
            os.kill(pid, number)
    except (ProcessLookupError, PermissionError):
        pass


def reap_orphans():
    """Collects adopted orphans that have ended; to be called once our own processes have been waited for."""
    try:
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass
    except ChildProcessError:
        pass


def remove_folders(folders):
    for folder in folders:
        shutil.rmtree(folder, ignore_errors=True)
