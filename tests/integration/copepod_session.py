"""Starts the Copepod command as a user would, and lets a test look at it, hurt it and see what is left."""

import json
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
PROGRAMS = Path(os.environ.get("COPEPOD_BUILT_PROGRAMS", ROOT / "build/bin"))

# A loss is noticed within about a second on an idle machine; without the mechanism under test, a run would end by a
# deadline of 30 s or more. This limit lies between, so that a busy machine does not matter.
PROMPT_S = 20

sys.path[:0] = [str(ROOT / "deploy"), str(ROOT / "proto" / "python")]


def wait_until(condition, what, timeout_s=60):
    """Returns as soon as `condition()` holds; AssertionError naming `what` if that takes too long."""
    deadline = time.monotonic() + timeout_s
    while not condition():
        if time.monotonic() > deadline:
            raise AssertionError(f"{what}: not within {timeout_s} s")
        time.sleep(0.01)


class Session:
    """One `copepod …` in its own process group and working directory."""

    def __init__(self, arguments, folder, programs, environment=(), program=COMMAND):
        variables = {**os.environ, "COPEPOD_BIN_DIR": str(programs), **dict(environment)}
        self.folder = Path(folder)
        self._started_at = time.time()
        self.process = subprocess.Popen(
            [str(program), *map(str, arguments)],
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

    def wait_for(self, text, times=1):
        """Until `text` is on stderr, `times` times."""
        self._wait_until(lambda: "".join(list(self.stderr)).count(text) >= times, f"«{text}» on stderr")

    def wait_for_file(self, pattern):
        """Until a file below the working directory matches `pattern`."""
        self._wait_until(lambda: any(self.folder.glob(pattern)), f"a file {pattern}")

    def _wait_until(self, condition, what):
        def ended():
            return self.process.poll() is not None

        wait_until(lambda: condition() or ended(), what)
        if not condition():
            raise AssertionError(f"{what}: not before the command ended; stderr was:\n{''.join(self.stderr)}")

    def wait_until_clean(self):
        """Until nothing of the run is left: the command has been killed, and its guard cleans up."""
        wait_until(lambda: not self.leftovers(), "nothing left of the run", PROMPT_S)

    def end(self, timeout_s=60):
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
        """Processes, keys and temporary folders of the run that are still there."""
        return [*self.processes(), *self.folder.rglob(".keys"), *self.scratch_folders()]

    def is_guard(self, pid):
        """Whether a process is the one that cleans up after this command."""
        try:
            return f"/copepod-{self.process.pid}-" in Path(f"/proc/{pid}/cmdline").read_text()
        except OSError:
            return False

    def scratch_folders(self):
        """Temporary folders of this command, without those of an earlier process of the same id."""
        found = [path for where in ("/tmp", "/dev/shm") for path in Path(where).glob(f"copepod-{self.process.pid}-*")]
        return [path for path in found if _changed_at(path) >= self._started_at - 1.0]

    def has_open(self, path):
        """Whether the command itself has a file or folder open."""
        descriptors = Path(f"/proc/{self.process.pid}/fd")
        try:
            return any(os.path.samefile(descriptor, path) for descriptor in descriptors.iterdir())
        except OSError:  # one was closed meanwhile
            return False

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

    def start(self, *arguments, environment=(), program=COMMAND):
        session = Session(arguments, self.folder, self.programs, environment, program)
        self.addCleanup(self._end_for_sure, session)
        return session

    def assert_nothing_left(self, session):
        """No process, no socket, no temporary folder of the run."""
        self.assertEqual(session.leftovers(), [])

    def assert_ends(self, session, code, timeout_s=PROMPT_S):
        """The command ends in time with `code`, and cleans up."""
        self.assertEqual(session.end(timeout_s), code, "".join(session.stderr))
        self.assert_nothing_left(session)

    @staticmethod
    def _end_for_sure(session):
        if session.process.poll() is None:
            session.process.send_signal(signal.SIGTERM)
            session.end()


class WholeRunTest(CommandTest):
    """Runs of whole cases by the programs that were built, to their end; ctest limits their time."""

    programs = PROGRAMS

    def finish(self, *arguments, code=0):
        """The ended session of a command."""
        session = self.start(*arguments)
        self.assert_ends(session, code, timeout_s=None)
        return session

    def run_of(self, case, *settings, code=0):
        """Folder of a run of the case below configs/, or of a file, with other values of some keys: «key=value».

        In one process, where the settings name no transport: the results are the same, and sooner.
        """
        out = self.folder / f"run_{len(list(self.folder.glob('run_*')))}"
        if not any(setting.startswith("services.transport") for setting in settings):
            settings = ("services.transport=in_process", *settings)
        words = [word for setting in settings for word in ("--set", setting)]
        self.finish("run", ROOT / "configs" / case, *words, "--out", out, code=code)
        return out


class TinyRunTest(CommandTest):
    """Runs of a case without physics, by the stand-ins in fakes/."""

    def case(self, **changes):
        path = self.folder / "case.yaml"
        path.write_text(json.dumps({"name": "tiny", "steps": 3000, "step_s": 0.01, "ranks": 2, **changes}))
        return path.name

    def start_long_run(self, *arguments, **changes):
        session = self.start("run", self.case(**changes), *arguments)
        session.wait_for("copepod: step 0 of")
        if "checkpoint_at" in changes:
            session.wait_for_file("**/checkpoints/*/manifest.json")
        return session

    def component(self, commands):
        """A body component that answers --capabilities, and otherwise carries out `commands` of bash."""
        script = self.folder / "body.sh"
        script.write_text(
            f'#!/bin/bash\n[ "$1" = --capabilities ] && exec {FAKES}/body_service --capabilities\n{commands}\n'
        )
        script.chmod(0o755)
        return script
