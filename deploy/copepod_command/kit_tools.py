"""`copepod conformance`, `recording`, `replay` and `python`: build what is missing, then start these tools."""

import json
import os
import shlex
import shutil
import subprocess
import sys
from argparse import Namespace
from dataclasses import replace
from pathlib import Path

from copepod_run import build, components, packages
from copepod_run.checkout import ROOT, python_path_of_components
from copepod_run.cleanup import MARK
from copepod_run.launcher import guarded_folder
from copepod_run.plan import plan_of
from copepod_run.scratch import Scratch

_CONFORMANCE = (sys.executable, "-P", "-m", "copepod_conformance")
_RECORDING = (sys.executable, "-P", "-m", "copepod_recording")


def python(options: Namespace) -> int:
    """Becomes Debian's Python with the same arguments, in which `import copepod` works."""
    packages.ensure(packages.PYTHON)
    path = os.pathsep.join([str(ROOT / "python"), os.environ["PYTHONPATH"], python_path_of_components()])
    os.execve(sys.executable, [sys.executable, *options.arguments], {**os.environ, "PYTHONPATH": path})


def conformance(options: Namespace) -> int:
    """Exit code of the tool with the same arguments; none of its processes and files remain."""
    place = options.arguments.index("--") + 1 if "--" in options.arguments else len(options.arguments)
    command = [*_CONFORMANCE, *options.arguments[:place], *_on_path_of_components(options.arguments[place:])]
    if options.arguments[:1] in (["-h"], ["--help"]):
        return subprocess.run(command).returncode
    build.ensure_programs()
    with guarded_folder() as folder:
        return _run_in(folder, command, ranks=len(os.sched_getaffinity(0)))


def recording(options: Namespace) -> int:
    """Exit code of the tool with the same arguments."""
    return subprocess.run([*_RECORDING, *options.arguments]).returncode


def replay(options: Namespace) -> int:
    """Exit code 0 if every reply is the recorded one, or if the run with the recorded component finished."""
    build.ensure_programs()
    with guarded_folder() as folder:
        if options.stand_in:
            return _run_with_recorded(options, folder)
        role = options.controller or ("fluid" if options.fluid else "body")
        if not (component := list(options.component)):  # the one that was recorded
            plan = replace(plan_of(Path(options.directory) / "case.yaml"), fluid_ranks=options.ranks)
            component = components.with_ranks(plan, role, components.program_of(plan, role))
        command = [*_RECORDING, "replay", *_selection(options, role), "--", *_on_path_of_components(component)]
        return _run_in(folder, command, options.ranks)


def _run_in(folder: Scratch, command: list[str], ranks: int) -> int:
    environment = components.environment(folder, ranks)
    kept = {"TMPDIR": str(folder.run_path), "PYTHONPATH": os.environ["PYTHONPATH"]}
    return subprocess.run(command, env={**environment, **kept}).returncode


def _on_path_of_components(command: list[str]) -> list[str]:
    """The command of a component whose tool runs with our own modules first."""
    path = python_path_of_components()
    is_program = bool(command) and shutil.which(command[0]) is not None  # the tool reports a missing one
    return ["env", f"PYTHONPATH={path}", *command] if is_program and path != os.environ["PYTHONPATH"] else command


def _selection(options: Namespace, role: str) -> list[str]:
    """Arguments that select what is played of which recording."""
    attempt = ["--attempt", str(options.attempt)] if options.attempt else []
    return [str(Path(options.directory).resolve()), "--role", role, "--tolerance", str(options.tolerance), *attempt]


def _run_with_recorded(options: Namespace, folder: Scratch) -> int:
    """Runs the recorded case with one component replaced by its recording; the run directory stays if the run fails."""
    role = options.stand_in
    recorded = ["env", f"PYTHONPATH={os.environ['PYTHONPATH']}", *_RECORDING, "component", *_selection(options, role)]
    code = subprocess.run([*recorded, "--capabilities"], stdout=subprocess.DEVNULL).returncode
    if code != 0:
        return code
    command = [sys.executable, "-P", "-m", "copepod_command", "run", str(Path(options.directory) / "case.yaml")]
    command += ["--out", options.out or f"{folder.run_path}/run"]
    command += ["--set", "output.wire=false", "--set", "output.trace=false"]
    command += ["--ranks", "1"] if role == "fluid" else []
    if role in components.ROLES:
        command += [f"--{role}", shlex.join(recorded)]
    else:
        number = plan_of(Path(options.directory) / "case.yaml").controllers.index(role)
        command += ["--set", f"controllers.{number}.command={json.dumps(recorded)}"]
    code = subprocess.run(command, env={**os.environ, MARK: folder.mark}).returncode
    if code != 0 and not options.out and (folder.run_path / "run").exists():
        folder.folders.remove(folder.run_path)
    return code
