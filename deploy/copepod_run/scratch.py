"""Private folders that live as long as a run: the sockets, the keys, and the temporary files of MPI."""

import os
import stat
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from copepod_run import cleanup
from copepod_run.errors import BadCase
from copepod_run.run_directory import Lock, lock_of, take_lock

_PLACES = ("/tmp", "/dev/shm")
_YOUNG_S = 60.0  # a folder may be about to be locked


class Scratch:
    """Private folders (0700) of one run.

    MPI gets folders of its own: a killed mpirun cannot remove what it left in /tmp and /dev/shm. Those there are locked
    by the command and by its guard; what is locked by neither is swept by a later run. Every folder is claimed: one
    that this program did not make is never removed, whatever its name.
    """

    def __init__(self, run_path: Path | None, mark: str) -> None:
        """`run_path`: the run directory, None for one more private folder; `mark`: of the run."""
        folders = (folder for where in _PLACES for folder in Path(where).glob("copepod-*"))
        cleanup.remove_folders(folder for folder in folders if _is_abandoned(folder))
        self.mark = mark
        self.folders: list[Path] = []
        self.locks: list[int] = []  # descriptors
        self.run_path = run_path or self._private_folder("/tmp")
        self.files = self._private_folder("/tmp")  # a short path, on a file system that has sockets
        self.shared_memory = self._private_folder("/dev/shm" if os.access("/dev/shm", os.W_OK) else "/tmp")

    def keys(self, transport: str, roles: Sequence[str], is_private: bool = False) -> dict[str, Path]:
        """Key file by role, of the coupler too, if messages use tcp, else none. They are in the run directory, which
        other hosts see too; `is_private`: on this host alone.

        CURVE (ZeroMQ's encryption, Curve25519): a process without a key cannot listen, and the key of one role is not
        accepted for another. Keys are made for every run and removed with it; no command line contains one.
        Raises Stop(2) if a stranger's folder is in the way.
        """
        if not transport.startswith("tcp://"):
            return {}
        import zmq  # needed by runs over tcp only

        folder = self.files
        if not is_private:
            folder = self.run_path / ".keys"
            fresh_folder(folder, self.mark)
            self.folders.append(folder)
        pairs = {role: [key.decode() for key in zmq.curve_keypair()] for role in ("coupler", *roles)}
        files = {}
        for role in pairs:
            peers = roles if role == "coupler" else ("coupler",)  # whose public keys it needs
            lines = {"secret": pairs[role][1], **{peer: pairs[peer][0] for peer in peers}}
            files[role] = folder / f"{role}.key"  # proto/transport/lanes.hpp describes it
            cleanup.write_private(files[role], "".join(f"{name} {key}\n" for name, key in lines.items()))
        return files

    def endpoint(self, transport: str) -> str:
        """Where the coupler listens: a socket in our folder, or the planned tcp address."""
        return f"ipc://{self.files}/coupler.ipc" if transport == "ipc" else transport

    def _private_folder(self, where: str) -> Path:
        """Claimed, and locked, so that no other run sweeps it."""
        folder = Path(tempfile.mkdtemp(prefix=f"copepod-{os.getpid()}-", dir=where))
        cleanup.claim(folder, self.mark)
        self.folders.append(folder)
        self.locks.append(os.open(folder, os.O_RDONLY | os.O_DIRECTORY))
        take_lock(self.locks[-1])
        return folder

    def close(self) -> None:
        for lock in self.locks:
            os.close(lock)


def fresh_folder(folder: Path, mark: str) -> None:
    """Makes a private folder in a run directory, in the place of one that an earlier run left. Raises Stop(2) if what
    has this name was not made by a run."""
    cleanup.remove_folders([folder])
    try:
        if folder.is_dir() and not folder.is_symlink() and not any(folder.iterdir()):
            folder.rmdir()  # the run was killed before it could claim its folder
        folder.mkdir(mode=0o700)
    except FileExistsError:
        raise BadCase(f"{folder} is in the way (not made by a run). Move it away, or choose another --out.") from None
    cleanup.claim(folder, mark)


def _is_abandoned(folder: Path) -> bool:
    """Whether this is a private folder of a run that nothing holds any more: command and guard have been killed."""
    try:
        status = folder.lstat()
        is_old = stat.S_IMODE(status.st_mode) == 0o700 and time.time() - status.st_mtime >= _YOUNG_S
        return is_old and cleanup.is_claimed(folder) and lock_of(folder) is Lock.OURS
    except OSError:  # gone meanwhile
        return False
