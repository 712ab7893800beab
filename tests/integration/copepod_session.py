"""Starts the Copepod command as a user would, and lets a test look at it, hurt it and see what is left."""

import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
COMMAND = ROOT / "deploy" / "copepod"
FAKES = Path(__file__).resolve().parent / "fakes"

sys.path[:0] = [str(ROOT / "deploy"), str(ROOT / "proto" / "python")]


class Session:
    """One `copepod …` in its own process group and working directory."""

    def __init__(self, arguments, folder, programs, environment=()):
        variables = {**os.environ, "COPEPOD_BIN_DIR": str(programs), **dict(environment)}
        self.folder = Path(folder)
        self._started_at = time.time()
        self.process = subprocess.Popen(
            [str(COMMAND), *map(str, arguments)],
            cwd=folder,
            env=variables,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        self.stdout, self.stderr = [], []
        self._threads = [
            threading.Thread(target=self._copy, args=pair, daemon=True)
            for pair in ((self.process.stdout, self.stdout), (self.process.stderr, self.stderr))
        ]
        for thread in self._threads:
            thread.start()

    def wait_for(self, text, timeout_s=20):
        """Until stderr holds `text`."""
        deadline = time.monotonic() + timeout_s
        while time.monotonic() < deadline:
            if any(text in line for line in list(self.stderr)):
                return
            if self.process.poll() is not None:
                break
            time.sleep(0.01)
        raise AssertionError(f"«{text}» never came; stderr was:\n{''.join(self.stderr)}")

    def end(self, timeout_s=20):
        """Exit code, once it has ended."""
        code = self.process.wait(timeout_s)
        for thread in self._threads:
            thread.join(5)
        self.process.stdout.close()
        self.process.stderr.close()
        return code

    @property
    def last_line(self):
        return self.stderr[-1].rstrip("\n")

    def pid_of(self, component, rank=None):
        """Process of a component of this run; for the fluid, mpirun without `rank`, else that rank."""
        for pid, variables in self.processes().items():
            if variables.get("COPEPOD_COMPONENT") == component and variables.get("OMPI_COMM_WORLD_RANK") == rank:
                return pid
        raise AssertionError(f"no process of {component}, rank {rank}, in {self.processes()}")

    def processes(self):
        """Living processes of this run by id, with their environment; found by their working directory."""
        found = {}
        for entry in Path("/proc").iterdir():
            try:
                if entry.name.isdigit() and Path(os.readlink(entry / "cwd")) == self.folder:
                    pairs = (entry / "environ").read_bytes().decode(errors="replace").split("\0")
                    variables = dict(pair.split("=", 1) for pair in pairs if "=" in pair)
                    if "COPEPOD_RUN" in variables:
                        found[int(entry.name)] = variables
            except OSError:
                continue
        return found

    def leftovers(self):
        """Processes, sockets and temporary folders of the run that are still there."""
        sockets = list(self.folder.rglob(".sockets"))
        return [*self.processes(), *sockets, *self.scratch_folders()]

    def scratch_folders(self):
        """Temporary folders of this command, not of one that had its process id long ago and was killed with its guard."""
        found = [path for where in ("/tmp", "/dev/shm") for path in Path(where).glob(f"copepod-{self.process.pid}-*")]
        return [path for path in found if _changed_at(path) >= self._started_at - 1.0]

    def kill(self, number, component, rank=None):
        os.kill(self.pid_of(component, rank), number)

    @staticmethod
    def _copy(stream, lines):
        for line in stream:
            lines.append(line)


def _changed_at(path):
    """Seconds since the epoch; 0 if it is gone."""
    try:
        return path.stat().st_ctime
    except FileNotFoundError:
        return 0.0


class CommandTest(unittest.TestCase):
    """A test with a private folder, in which nothing of a run may be left at the end."""

    programs = FAKES

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="copepod_test_")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name).resolve()

    def start(self, *arguments, environment=()):
        session = Session(arguments, self.folder, self.programs, environment)
        self.addCleanup(self._end_for_sure, session)
        return session

    def assert_nothing_left(self, session):
        """No process, no socket, no temporary folder of the run."""
        self.assertEqual(session.leftovers(), [])

    def assert_ends(self, session, code, within_s):
        """The command ends with `code` in time, and cleans up."""
        start = time.monotonic()
        self.assertEqual(session.end(), code, "".join(session.stderr))
        self.assertLess(time.monotonic() - start, within_s)
        self.assert_nothing_left(session)

    @staticmethod
    def _end_for_sure(session):
        if session.process.poll() is None:
            session.process.send_signal(signal.SIGTERM)
            session.end()
