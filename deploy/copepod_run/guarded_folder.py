"""A private folder and marked processes of a command that has no run directory: nothing of them is left, however it ends."""

import os
import secrets
import tempfile
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from copepod_run import cleanup
from copepod_run.components import MARK
from copepod_run.guard import Guard
from copepod_run.scratch import Scratch


@dataclass
class GuardedFolder:
    """`mark`: value of COPEPOD_RUN in the environment of every process that is to end with the command."""

    path: Path
    scratch: Scratch
    mark: str
    is_kept: bool = False  # set it to leave the folder, but not what else there is


@contextmanager
def guarded_folder():
    """Yields a GuardedFolder; another process cleans up should this one be killed."""
    path = Path(tempfile.mkdtemp(prefix=f"copepod-{os.getpid()}-", dir="/tmp"))  # a short path: it holds sockets
    folder = GuardedFolder(path, Scratch(path), secrets.token_hex(16))
    mark = f"{MARK}={folder.mark}"
    guard = Guard(mark, [path, *folder.scratch.folders])
    try:
        yield folder
    finally:
        cleanup.end_marked(mark)
        cleanup.remove_folders(folder.scratch.folders if folder.is_kept else [path, *folder.scratch.folders])
        guard.dismiss()
