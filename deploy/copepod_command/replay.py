"""`copepod replay`: a recorded run against a real component, or a recorded component against a real coupler."""

import os
import shlex
import subprocess
import sys
from argparse import Namespace
from dataclasses import replace
from pathlib import Path

from copepod_run import build, components
from copepod_run.scratch import GuardedFolder, guarded_folder
from copepod_run.plan import plan_of

_TOOL = (sys.executable, "-m", "copepod_recording")


def replay(options: Namespace) -> int:
    """Exit code 0 if every reply is the recorded one, or if the run with the recorded component finished."""
    build.ensure_programs()
    with guarded_folder() as folder:
        if options.stand_in:
            return _run_with_recorded(options, folder)
        role = "fluid" if options.fluid else "body"
        command = [*_TOOL, "replay", *_recording(options, role), "--", *_command(options, role)]
        environment = components.environment(folder.mark, folder.scratch, options.ranks)
        return subprocess.run(command, env={**environment, "TMPDIR": str(folder.path)}).returncode


def _recording(options: Namespace, role: str) -> list[str]:
    attempt = ["--attempt", str(options.attempt)] if options.attempt else []
    return [str(Path(options.directory).resolve()), "--role", role, "--tolerance", str(options.tolerance), *attempt]


def _command(options: Namespace, role: str) -> list[str]:
    """The component that was recorded, or the one that the user names."""
    if options.component:
        return options.component
    plan = replace(plan_of(Path(options.directory) / "case.yaml"), fluid_ranks=options.ranks)
    if role == "body":
        return components.body_program(plan)
    return components.with_ranks(plan, components.fluid_program(plan))


def _run_with_recorded(options: Namespace, folder: GuardedFolder) -> int:
    """Runs the recorded case with one component replaced by its recording; the run directory stays if the run fails."""
    role = options.stand_in
    recorded = [*_TOOL, "component", *_recording(options, role)]
    code = subprocess.run([*recorded, "--capabilities"], stdout=subprocess.DEVNULL).returncode
    if code != 0:
        return code
    command = [sys.executable, "-m", "copepod_command", "run", str(Path(options.directory) / "case.yaml")]
    command += ["--out", options.out or f"{folder.path}/run"]
    command += ["--set", "output.wire=false", "--set", "output.trace=false"]
    command += [f"--{role}", shlex.join(recorded)] + (["--ranks", "1"] if role == "fluid" else [])
    code = subprocess.run(command, env={**os.environ, components.MARK: folder.mark}).returncode
    folder.is_kept = code != 0 and not options.out and (folder.path / "run").exists()
    return code
