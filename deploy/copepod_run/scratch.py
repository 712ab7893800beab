"""Folders that live as long as a run: the sockets, the keys, and the temporary files of MPI."""

import os
import shutil
import tempfile
from pathlib import Path

from copepod_run.keys import write_keys

LONGEST_SOCKET_PATH = 100  # Linux allows 107 bytes; the rest is for suffixes such as the lock's


class Scratch:
    """Private folders (0700) of one run.

    MPI gets folders of its own, for when mpirun is killed it cannot remove what it left in /tmp and /dev/shm.
    """

    def __init__(self, run_path):
        self.folders = []
        self._run_path = Path(run_path)
        self.sockets = Path(run_path) / ".sockets"
        if len(os.fsencode(self.sockets / "coupler.ipc")) <= LONGEST_SOCKET_PATH:
            shutil.rmtree(self.sockets, ignore_errors=True)
            self.sockets.mkdir(mode=0o700)
            self.folders.append(self.sockets)
        else:
            self.sockets = self._private_folder("/tmp")
        self.mpi_files = self._private_folder("/tmp")
        self.shared_memory = self._private_folder("/dev/shm" if os.access("/dev/shm", os.W_OK) else "/tmp")

    def keys(self, transport):
        """Key file per role where messages go over tcp, else none. The run directory is what other hosts can see too."""
        if not transport.startswith("tcp://"):
            return {}
        folder = self._run_path / ".keys"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(mode=0o700)
        self.folders.append(folder)
        return write_keys(folder)

    def endpoint(self, transport):
        """Where the coupler listens: a socket in our folder, or the planned tcp address."""
        return f"ipc://{self.sockets}/coupler.ipc" if transport == "ipc" else transport

    def remove(self):
        for folder in self.folders:
            shutil.rmtree(folder, ignore_errors=True)

    def _private_folder(self, where):
        folder = Path(tempfile.mkdtemp(prefix=f"copepod-{os.getpid()}-", dir=where))
        self.folders.append(folder)
        return folder
