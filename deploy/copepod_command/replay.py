"""`copepod replay`: a recorded run against a real component, or a recorded component against a real coupler."""

import os
import secrets
import shlex
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

from copepod_command import build, components, exit_codes
from copepod_command.checkout import ROOT, program
from copepod_command.errors import Stop
from copepod_command.scratch import Scratch
from copepod_command.stages import say

_SHOWN = 10  # differences


def replay(options):
    """Returns 0 if every reply is the recorded one; Stop otherwise."""
    build.ensure_programs()
    from copepod_recording.location import wire_file

    path = wire_file(options.directory, options.attempt)
    if options.stand_in:
        return _stand_in(options, path)
    with tempfile.TemporaryDirectory(prefix="copepod-replay-") as folder:
        return _replay(options, path, "fluid" if options.fluid else "body", Path(folder))


def _replay(options, path, role, folder):
    from copepod_recording.player import Failed, Player
    from copepod_recording.script import script_of

    recording = _open(path)
    script = script_of(recording, role)
    if not script.exchanges:
        raise Stop(exit_codes.BAD_CASE, f"{path} has no requests to the {role} component. Record a longer run.")
    found = Differences()
    token = secrets.token_hex(16)
    scratch = Scratch(folder)
    endpoint = scratch.endpoint("ipc")
    command = _command(options, role) + ["--endpoint", endpoint, "--session", token]
    environment = components.environment("replay-" + token, scratch, options.ranks)
    process = subprocess.Popen(command, env=environment, stdin=subprocess.DEVNULL, start_new_session=True)
    try:
        is_alive = lambda: process.poll() is None  # noqa: E731
        with Player(endpoint, token, role, recording.envelope_class(), is_alive, folder) as player:
            player.greet()
            compared = player.play(script, options.tolerance, found.add)
            code = process.wait(timeout=30)
    except Failed as problem:
        found.print()
        raise Stop(exit_codes.SOLVER_FAILED, f"the {role} component failed: {problem}") from None
    except subprocess.TimeoutExpired:
        raise Stop(exit_codes.COMPONENT_LOST, f"the {role} component did not end after Finish. Look at its output.") from None
    finally:
        _end(process)
        scratch.remove()
    _say_where_it_ends(recording)
    if code != 0:
        raise Stop(exit_codes.COMPONENT_LOST, f"the {role} component ended with exit code {code} after Finish.")
    return found.verdict(compared, options.tolerance)


class Differences:
    """Values that are not as recorded."""

    def __init__(self):
        self._lines, self._number = [], 0

    def add(self, exchange, text):
        self._number += 1
        if self._number <= _SHOWN:
            self._lines.append(f"step {exchange.request.step}: {text}")

    def print(self):
        for line in self._lines:
            print(line)

    def verdict(self, compared, tolerance):
        """0 if there are none; Stop(70) otherwise."""
        how = f"within a relative difference of {tolerance:g}" if tolerance else "bit by bit"
        if self._number == 0:
            print(f"{compared} replies agree {how}")
            return exit_codes.FINISHED
        self.print()
        raise Stop(
            exit_codes.SOLVER_FAILED,
            f"{self._number} values in {compared} replies differ from the recording (compared {how}; the first "
            f"{min(self._number, _SHOWN)} above). Another build or solver? --tolerance allows for rounding.",
        )


def _open(path):
    from copepod_recording.reader import Recording, UnreadableRecording

    try:
        return Recording(path)
    except (OSError, UnreadableRecording) as problem:
        raise Stop(exit_codes.STORAGE_FAILED, str(problem)) from None


def _say_where_it_ends(recording):
    if recording.ending:
        say(f"{recording.path} is {recording.ending}; what comes before was used")


def _command(options, role):
    if options.component:
        return options.component
    if role == "fluid":
        return ["mpirun", "-n", str(options.ranks), "--oversubscribe", str(program("fluid_service"))]
    return [str(program("body_service"))]


def _end(process):
    """The component and everything it started; they are a process group of their own."""
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass
    process.wait()


def _stand_in(options, path):
    """Runs the recorded case with one component replaced by what it said."""
    program_path = ROOT / "deploy" / "copepod_recording" / "stand_in.py"
    words = ["/usr/bin/python3", str(program_path), options.stand_in, str(path.resolve()), str(options.tolerance)]
    with tempfile.TemporaryDirectory(prefix="copepod-replay-") as folder:
        command = [sys.executable, str(ROOT / "deploy/copepod_command/__main__.py"), "run"]
        command += [str(Path(options.directory) / "case.yaml"), "--out", options.out or f"{folder}/run"]
        command += ["--set", "output.wire=false", "--set", "output.trace=false"]
        command += [f"--{options.stand_in}", shlex.join(words)] + (["--ranks", "1"] if options.stand_in == "fluid" else [])
        return subprocess.run(command).returncode
