"""The folder of a run: chosen without ever overwriting one, locked while it is in use."""

import errno
import fcntl
import json
import os
import re
import time
from pathlib import Path

from copepod_run import exit_codes
from copepod_run.destinations import make_folder
from copepod_run.errors import Stop


_LOCK_PATIENCE_S = 4.0  # a command that was killed (kill -9) is being cleaned up after


class RunDirectory:
    """A run's folder, held by this command; the lock lives on the folder itself and leaves no file."""

    def __init__(self, path, must_be_empty=False):
        """Raises Stop(2) if another command holds the folder, its name is no text, or it is not empty as it `must_be`.

        Raises Stop(73) if nothing can be written there.
        """
        self.path = Path(path).absolute()
        _require_utf8(self.path)
        self.lock = _opened(path)
        try:
            if not _is_locked(self.lock, _LOCK_PATIENCE_S):
                raise Stop(
                    exit_codes.BAD_CASE,
                    f"{path} is in use (another copepod runs there). Wait for it, or choose another --out.",
                )
            if must_be_empty:  # known only now: another command may have run there while we waited
                _require_empty(self.path, path)
            (self.path / "logs").mkdir(exist_ok=True)
        except BaseException:
            os.close(self.lock)
            raise

    def close(self):
        os.close(self.lock)

    @property
    def shown(self):
        """The path as text, relative to the current directory if that is shorter."""
        relative = os.path.relpath(self.path)
        return relative if len(relative) < len(str(self.path)) else str(self.path)

    def summary(self):
        """summary.json, or None if there is none that can be read."""
        try:
            return json.loads((self.path / "summary.json").read_text())
        except (OSError, ValueError):
            return None

    def has_checkpoint(self):
        return has_checkpoint(self.path)


def has_checkpoint(path):
    """Whether there is a complete one; a folder has this name, and its manifest, only once all of it is written."""
    return any((path / "checkpoints").glob("step_*/manifest.json"))


def _opened(path):
    """Descriptor of the folder. Raises Stop(73) if it is not ours to write to."""
    try:
        if not os.access(path, os.R_OK | os.W_OK | os.X_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        return os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    except OSError as problem:
        raise Stop(
            exit_codes.STORAGE_FAILED,
            f"{path} cannot be written to ({problem.strerror}). Choose another --out; to go on with somebody else's run, "
            "copy its folder first.",
        ) from None


def _require_empty(path, shown):
    """Raises Stop(2) if there is anything at `path` but an empty folder; Stop(73) if that cannot be told."""
    try:
        if not path.exists() or path.is_dir() and not any(path.iterdir()):
            return
    except OSError as problem:
        raise Stop(
            exit_codes.STORAGE_FAILED, f"{shown} cannot be read ({problem.strerror}). Choose another --out."
        ) from None
    raise Stop(
        exit_codes.BAD_CASE,
        f"{shown} exists already (a run is never overwritten). Go on with it by --resume, or choose another --out.",
    )


def _is_locked(descriptor, patience_s):
    """Whether the lock became ours in time."""
    deadline = time.monotonic() + patience_s
    while True:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
        except OSError:
            if time.monotonic() > deadline:
                return False
            time.sleep(0.05)


def create(name, out):
    """New folder: `out` if given, else runs/<name>, runs/<name>-2, … in the current directory.

    Raises Stop(2) if `out` exists and is not empty.
    """
    if out is not None:
        path = Path(out)
        _require_utf8(path)
        _require_empty(path, out)
        make_folder(path)
        return RunDirectory(path, must_be_empty=True)
    name = folder_name(name)
    for number in range(1, 100000):
        path = Path("runs") / _numbered(name, number)
        try:
            make_folder(path, exist_ok=False)
            return RunDirectory(path)
        except FileExistsError:
            continue
    raise Stop(exit_codes.BAD_CASE, f"runs/ holds 100000 runs of {name} (no free number). Remove some.")


def reopen(name, out):
    """Folder of the run to go on with: `out`, or the latest runs/<name>-N. Raises Stop(2) if it cannot be resumed."""
    path = Path(out) if out is not None else _latest(name)
    if path is None or not _holds_case(path):
        where = out if out is not None else f"runs/{name}"
        raise Stop(exit_codes.BAD_CASE, f"{where} holds no run (no case.yaml). Start it without --resume.")
    directory = RunDirectory(path)
    if not directory.has_checkpoint():
        directory.close()
        raise Stop(
            exit_codes.BAD_CASE,
            f"{path} cannot be resumed (it holds no checkpoint). Start again without --resume; that makes a new folder.",
        )
    return directory


def _require_utf8(path):
    """Raises Stop(2) for a path that no message can carry: texts of Protocol Buffers are UTF-8."""
    name = os.fsencode(Path(path).absolute())
    try:
        name.decode("utf-8")
    except UnicodeDecodeError:
        raise Stop(
            exit_codes.BAD_CASE,
            f"{name.decode('utf-8', 'backslashreplace')} cannot be the folder of a run (its name is not UTF-8 text). "
            "Choose another --out, or rename it.",
        ) from None


def _holds_case(path):
    try:
        return (path / "case.yaml").exists()
    except OSError as problem:
        raise Stop(
            exit_codes.STORAGE_FAILED, f"{path} cannot be read ({problem.strerror}). Choose another --out."
        ) from None


def folder_name(case_name):
    """The case's name without what has a meaning in paths."""
    return re.sub(r"[^\w.+=-]+", "_", case_name).lstrip(".") or "run"


def _numbered(name, number):
    return name if number == 1 else f"{name}-{number}"


def _latest(name):
    """Highest numbered runs/<name>-N that holds a case."""
    name = folder_name(name)
    pattern = re.compile(re.escape(name) + r"(?:-(\d+))?")
    found = []
    for path in Path("runs").glob(f"{name}*"):
        match = pattern.fullmatch(path.name)
        if match and (path / "case.yaml").exists():
            found.append((int(match.group(1) or 1), path))
    return max(found)[1] if found else None
