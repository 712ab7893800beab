"""Where results are to be written, checked before the work that makes them."""

import errno
import os
from pathlib import Path

from copepod_run.errors import StorageFailed


def require_file(file: str | Path | None, option: str) -> None:
    """Raises Stop(73) unless `file`, which `option` of the command line named, can be written; None is fine."""
    if file is None:
        return
    path = Path(file)
    problem: str | None
    try:
        if path.is_dir():
            problem = "that is a folder"
        elif not path.absolute().parent.is_dir():
            problem = "there is no such folder"
        else:
            existing = path if path.exists() else path.absolute().parent
            problem = None if os.access(existing, os.W_OK) else os.strerror(errno.EACCES)
    except OSError as refusal:  # a name that is too long
        problem = refusal.strerror
    if problem:
        raise StorageFailed(f"{path} cannot be written ({problem}). Choose another {option}.")


def make_folder(path: Path, exist_ok: bool = True) -> None:
    """Makes a folder and those above it. Raises Stop(73), and FileExistsError unless `exist_ok`."""
    try:
        path.mkdir(parents=True, exist_ok=exist_ok)
    except OSError as problem:
        if isinstance(problem, FileExistsError) and not exist_ok:
            raise
        raise StorageFailed(f"{path} cannot be made ({problem.strerror}). Choose another --out.") from None


def advice(problem: OSError) -> str:
    """What to do about an OSError, as the last sentence of a message."""
    if problem.errno in (errno.ENOSPC, errno.EDQUOT):
        return "Free space on that disk and run again."
    if problem.errno == errno.EFBIG:
        return "Raise the limit of the size of files (ulimit -f)."
    if problem.errno in (errno.EACCES, errno.EPERM, errno.EROFS):
        return "Use a place that you may write to, or ask its owner."
    return "Check that path, or use another one."
