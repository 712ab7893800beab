"""`copepod replay`: a recorded run against a real component, or a recorded component against a real coupler."""

import os
import secrets
import shlex
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

from copepod_run import build, components
from copepod_run.checkout import ROOT
from copepod_run.errors import ExitCode, Stop
from copepod_run.scratch import guarded_folder
from copepod_run.plan import plan_of
from copepod_run.messages import say

_SHOWN = 10  # differences


def replay(options):
    """Returns 0 if every reply is the recorded one; Stop otherwise."""
    build.ensure_programs()
    from copepod_recording.location import wire_file

    path = wire_file(options.directory, options.attempt)
    with guarded_folder() as folder:
        if options.stand_in:
            return _stand_in(options, path, folder)
        return _replay(options, path, "fluid" if options.fluid else "body", folder)


def _replay(options, path, role, folder):
    from copepod_recording.player import Failed, Player

    recording = _open(path)
    script = _script(recording, role)
    _require_checkpoint(script, path)
    command = _command(options, role)
    components.require_program(role, command)
    found = Differences()
    token = secrets.token_hex(16)
    endpoint = folder.scratch.endpoint("ipc")
    environment = components.environment(folder.mark, folder.scratch, options.ranks)
    process = subprocess.Popen(
        [*command, "--endpoint", endpoint, "--session", token],
        env=environment,
        stdin=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        is_alive = lambda: process.poll() is None  # noqa: E731
        with Player(endpoint, token, role, recording.envelope_class(), is_alive, folder.path) as player:
            player.greet()
            compared = player.play(script, options.tolerance, found.add)
            code = process.wait(timeout=30)
    except Failed as problem:
        found.print()
        raise Stop(ExitCode.SOLVER_FAILED, f"the {role} component failed: {problem}") from None
    except subprocess.TimeoutExpired:
        raise Stop(
            ExitCode.COMPONENT_LOST, f"the {role} component did not end after Finish. Look at its output."
        ) from None
    finally:
        _end(process)
    _say_where_it_ends(recording)
    if code != 0:
        raise Stop(ExitCode.COMPONENT_LOST, f"the {role} component ended with exit code {code} after Finish.")
    return found.verdict(compared, options.tolerance)


def _script(recording, role):
    """What was said to the component. Raises Stop(2) if that is nothing."""
    from copepod_recording.script import script_of

    script = script_of(recording, role)
    if not script.exchanges:
        raise Stop(ExitCode.BAD_CASE, f"{recording.path} has no requests to the {role} component. Record a longer run.")
    return script


def _require_checkpoint(script, path):
    """Raises Stop(2) if the attempt went on from a checkpoint that is not there any more."""
    start = script.restore
    if start is not None and not Path(start.path).parent.exists():
        raise Stop(
            ExitCode.BAD_CASE,
            f"{path.stem} cannot be replayed (it went on from {Path(start.path).parent}, which is gone: a run keeps its "
            "last checkpoints only). Replay an earlier --attempt, or record a run that is not resumed.",
        )


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
            return ExitCode.FINISHED
        self.print()
        raise Stop(
            ExitCode.SOLVER_FAILED,
            f"{self._number} values in {compared} replies differ from the recording (compared {how}; the first "
            f"{min(self._number, _SHOWN)} above). Another build or solver? --tolerance allows for rounding.",
        )


def _open(path):
    from copepod_recording.reader import Recording, UnreadableRecording

    try:
        return Recording(path)
    except (OSError, UnreadableRecording) as problem:
        raise Stop(ExitCode.STORAGE_FAILED, str(problem)) from None


def _say_where_it_ends(recording):
    if recording.ending:
        say(f"{recording.path} is {recording.ending}; what comes before was used")


def _command(options, role):
    """The component that was recorded, or the one that the user names."""
    if options.component:
        return options.component
    plan = replace(plan_of(Path(options.directory) / "case.yaml"), fluid_ranks=options.ranks)
    if role == "body":
        return components.body_program(plan)
    return components.with_ranks(plan, components.fluid_program(plan))


def _end(process):
    """The component and everything it started; they are a process group of their own."""
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass
    process.wait()


def _stand_in(options, path, folder):
    """Runs the recorded case with one component replaced by what it said; its run directory stays if it fails."""
    start = _script(_open(path), options.stand_in).restore
    if start is not None:
        raise Stop(
            ExitCode.BAD_CASE,
            f"{path.stem} cannot play the {options.stand_in} component (it went on from a checkpoint, a run that is "
            "played starts at step 0). Use --attempt 1, or --fluid or --body to replay it.",
        )
    program_path = ROOT / "proto" / "python" / "copepod_recording" / "stand_in.py"
    words = ["/usr/bin/python3", str(program_path), options.stand_in, str(path.resolve()), str(options.tolerance)]
    command = [sys.executable, str(ROOT / "deploy/copepod_command/__main__.py"), "run"]
    command += [str(Path(options.directory) / "case.yaml"), "--out", options.out or f"{folder.path}/run"]
    command += ["--set", "output.wire=false", "--set", "output.trace=false"]
    command += [f"--{options.stand_in}", shlex.join(words)] + (["--ranks", "1"] if options.stand_in == "fluid" else [])
    code = subprocess.run(command, env={**os.environ, components.MARK: folder.mark}).returncode
    folder.is_kept = code != 0 and not options.out and (folder.path / "run").exists()
    return code
