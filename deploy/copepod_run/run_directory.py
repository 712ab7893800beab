"""The folder of a run: chosen without ever overwriting one, locked while it is in use."""

import datetime
import enum
import errno
import fcntl
import json
import os
import re
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

from copepod_run.errors import BadCase, Stop, StorageFailed
from copepod_run.messages import say
from copepod_run.names import as_word

_LOCK_PATIENCE_S = 4.0  # a command that was killed (kill -9) is being cleaned up after


class RunDirectory:
    """A run's folder, held by this command; the lock lives on the folder itself and leaves no file."""

    def __init__(self, path: Path, must_be_empty: bool = False) -> None:
        """Raises Stop(2) if another command holds the folder, its name is not text, or it is not empty as it `must_be`.

        Raises Stop(73) if nothing can be written there.
        """
        self.path = Path(path).absolute()
        self.shown = shown(self.path)
        _require_utf8(self.path)
        self.lock = _opened(path)
        try:
            found = take_lock(self.lock, _LOCK_PATIENCE_S)
            if found is Lock.HELD:
                raise _in_use(path)
            if found is Lock.IMPOSSIBLE:
                say(f"{path} cannot be locked (its file system has no locks). Let no other copepod use this folder.")
            if must_be_empty:  # known only now: another command may have run there while we waited
                _require_empty(self.path, path)
            (self.path / "logs").mkdir(exist_ok=True)
        except BaseException:
            os.close(self.lock)
            raise

    def close(self) -> None:
        os.close(self.lock)

    def record_exit(self, code: int, reason: str) -> None:
        """Adds to provenance.json how the run ended, for a coupler that could not do so itself. Never raises.

        Sets status, exit_code, exit_reason and, if missing, end; does nothing if the coupler wrote no provenance.
        """
        path = self.path / "provenance.json"
        if not (provenance := read_object(path)):
            return
        provenance |= {"status": "failed", "exit_code": code, "exit_reason": reason}
        if not provenance.get("end"):
            provenance["end"] = datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")
        replace_text(path, json.dumps(provenance, indent=2) + "\n")


def shown(path: Path) -> str:
    """As text, relative to the current directory if that is shorter."""
    return min(str(path), os.path.relpath(path), key=len)


def read_object(path: Path) -> dict[str, Any]:
    """Of a JSON file; empty if it is missing or half written."""
    try:
        content = json.loads(path.read_text())
    except (OSError, ValueError):
        return {}
    return content if isinstance(content, dict) else {}


def replace_text(path: Path, text: str) -> None:
    """Of a file, at once; on a full disk in the blocks that the file has. What cannot be written is lost: the run, and
    the reason of its failure, matter more."""
    fresh = path.with_suffix(".json.new")
    try:
        fresh.write_text(text)
        fresh.replace(path)
    except OSError:
        with suppress(OSError):
            fresh.unlink()
        with suppress(OSError), open(path, "r+b") as file:
            content = text.encode()
            if len(content) <= os.fstat(file.fileno()).st_blocks * 512:
                file.write(content)
                file.truncate()


def last_checkpoint_step(path: Path) -> int:
    """Step of the last complete checkpoint, whose manifest is written last; -1 if there is none."""
    manifests = (path / "checkpoints").glob("step_*/manifest.json")
    return max((int(manifest.parent.name.removeprefix("step_")) for manifest in manifests), default=-1)


def _opened(path: Path) -> int:
    """Descriptor of the folder. Raises Stop(73) if this user may not write there."""
    try:
        if not os.access(path, os.R_OK | os.W_OK | os.X_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        return os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    except OSError as problem:
        raise StorageFailed(
            f"{path} cannot be written to ({problem.strerror}). Choose another --out; to resume another user's run, "
            "copy its folder first."
        ) from None


def _in_use(path: Path | str) -> Stop:
    return BadCase(f"{path} is in use (another copepod runs there). Wait for it, or choose another --out.")


def _require_empty(path: Path, shown: Path | str) -> None:
    """Raises Stop(2) if there is anything at `path` but an empty folder; Stop(73) if it cannot be read."""
    try:
        if not path.exists() or path.is_dir() and not any(path.iterdir()):
            return
    except OSError as problem:
        raise StorageFailed(f"{shown} cannot be read ({problem.strerror}). Choose another --out.") from None
    raise BadCase(
        f"{shown} exists already (a run is never overwritten). Continue it with --resume, or choose another --out."
    )


class Lock(enum.Enum):
    """What came of an attempt to lock a folder."""

    OURS = enum.auto()
    HELD = enum.auto()  # by another process
    IMPOSSIBLE = enum.auto()  # some network file systems have no locks


def take_lock(descriptor: int, patience_s: float = 0.0) -> Lock:
    """Locks an open folder, waiting that long for its holder; closing the descriptor gives the lock back."""
    deadline = time.monotonic() + patience_s
    while True:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return Lock.OURS
        except BlockingIOError:
            if time.monotonic() > deadline:
                return Lock.HELD
            time.sleep(0.05)
        except OSError:
            return Lock.IMPOSSIBLE


def lock_of(folder: Path, patience_s: float = 0.0) -> Lock:
    """What comes of such an attempt, after which the folder is free again. Raises OSError if it cannot be opened."""
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        return take_lock(descriptor, patience_s)
    finally:
        os.close(descriptor)


def make_folder(path: Path, exist_ok: bool = True) -> None:
    """Makes a folder and those above it. Raises Stop(73), and FileExistsError unless `exist_ok`."""
    try:
        path.mkdir(parents=True, exist_ok=exist_ok)
    except OSError as problem:
        if isinstance(problem, FileExistsError) and not exist_ok:
            raise
        raise StorageFailed(f"{path} cannot be made ({problem.strerror}). Choose another --out.") from None


def create(name: str, out: str | None) -> RunDirectory:
    """New folder: `out` if given, else runs/<name>, runs/<name>-2, … in the current directory.

    Raises Stop(2) if `out` exists and is not empty, or another command holds it.
    """
    if out is not None:
        path = Path(out)
        _require_utf8(path)
        try:
            _require_empty(path, out)
        except Stop:
            with suppress(OSError):  # of a file, or a folder that may not be read
                if lock_of(path) is Lock.HELD:
                    raise _in_use(out) from None
            raise
        make_folder(path)
        return RunDirectory(path, must_be_empty=True)
    name = folder_name(name)
    for number in range(1, 100000):
        path = Path("runs") / (name if number == 1 else f"{name}-{number}")
        with suppress(FileExistsError):
            make_folder(path, exist_ok=False)
            return RunDirectory(path)
    raise BadCase(f"runs/ holds 100000 runs of {name} (no free number). Remove some.")


def reopen(name: str, out: str | None) -> RunDirectory:
    """Folder of the run to continue: `out`, or the latest runs/<name>-N. Raises Stop(2) if it cannot be resumed."""
    path = Path(out) if out is not None else _latest(name)
    try:
        holds_case = path is not None and (path / "case.yaml").exists()
    except OSError as problem:
        raise StorageFailed(f"{path} cannot be read ({problem.strerror}). Choose another --out.") from None
    if path is None or not holds_case:
        where = out if out is not None else f"runs/{name}"
        raise BadCase(f"{where} does not hold a run (no case.yaml). Start it without --resume.")
    directory = RunDirectory(path)
    if last_checkpoint_step(path) < 0:
        directory.close()
        raise BadCase(
            f"{path} cannot be resumed (it holds no checkpoint). Start again without --resume, in a new folder."
        )
    return directory


def _require_utf8(path: Path) -> None:
    """Raises Stop(2) for a path that messages cannot carry: texts of Protocol Buffers are UTF-8."""
    name = os.fsencode(Path(path).absolute())
    try:
        name.decode("utf-8")
    except UnicodeDecodeError:
        raise BadCase(
            f"{name.decode('utf-8', 'backslashreplace')} cannot be the folder of a run (its name is not UTF-8 text). "
            "Choose another --out, or rename it."
        ) from None


def folder_name(case_name: str) -> str:
    """The case's name without characters that have a meaning in paths."""
    return as_word(case_name).lstrip(".") or "run"


def _latest(name: str) -> Path | None:
    """Highest numbered runs/<name>-N that holds a case."""
    name = folder_name(name)
    pattern = re.escape(name) + r"(?:-(\d+))?"
    matches = ((re.fullmatch(pattern, path.name), path) for path in Path("runs").glob(f"{name}*"))
    found = [(int(match[1] or 1), path) for match, path in matches if match and (path / "case.yaml").exists()]
    return max(found)[1] if found else None
