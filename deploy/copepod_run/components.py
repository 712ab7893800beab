"""The processes of a run: command lines, environment, and what a component announces about itself."""

import difflib
import functools
import json
import os
import shlex
import shutil
import subprocess
from argparse import Namespace
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from copepod_run import hosts
from copepod_run.cleanup import MARK
from copepod_run.checkout import build_digest, program, python_path_of_components
from copepod_run.errors import BadCase
from copepod_run.plan import COUPLER_SILENCE_S, Plan, case_arguments
from copepod_run.scratch import Scratch

IN_PROCESS = "in_process"  # services.transport of a run without services
ROLES = ("fluid", "body")
SESSION = "COPEPOD_SESSION"  # variable with the token of the run

_BODY_SERVICES = {
    "own": "body_service",
    "external": "body_service",
    "bullet": "bullet_body_service",
    "mujoco": "mujoco_body_service",
}
_MOST_RANKS_PER_CORE = 32
_STARTERS = ("mpirun", "mpiexec", "srun")
_ANSWER_WITHIN_S = 20
_ORPHAN_AFTER_S = 10.0  # default of a component's --orphan-after
# Ranks that share cores with other processes must neither be bound to one core nor spin there.
ON_SHARED_CORES = {"OMPI_MCA_hwloc_base_binding_policy": "none", "OMPI_MCA_mpi_yield_when_idle": "1"}
_OF_MPIRUN = ("OMPI_", "PMIX_", "PMI_", "PRTE_")
_AS_ROOT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}  # mpirun would refuse to start


@dataclass(frozen=True)
class Connection:
    """Where the processes of a run meet, and what they must show."""

    endpoint: str
    session: str  # token; our own programs have it from the environment, which other users cannot read
    keys: Mapping[str, Path]  # key file by role; empty: none are needed
    logs: Path  # folder

    def arguments(self, name: str, is_ours: bool = True) -> list[str]:
        """The options that every process of a run takes."""
        keys = ["--keys", str(self.keys[name])] if self.keys else []
        log = str(self.logs / f"{name}.log")
        session = [] if is_ours else ["--session", self.session]
        return ["--endpoint", self.endpoint, *session, *keys, "--log-file", log]


def coupler_command(options: Namespace, plan: Plan, directory: Path, connection: Connection, resume: bool) -> list[str]:
    coupler = str(program("in_process_run" if plan.transport == IN_PROCESS else "coupler"))
    command = [coupler, "--run", *case_arguments(options), "--out", str(directory), *connection.arguments("coupler")]
    return [*command, "--build", build_digest(), *(["--resume"] if resume else branch_arguments(options))]


def branch_arguments(options: Namespace) -> list[str]:
    """For the coupler: the run, and perhaps the step, in --branch-from DIR[:STEP]; empty without it."""
    if not options.branch_from:
        return []
    directory, colon, step = options.branch_from.rpartition(":")
    if colon and step.isdecimal() and not Path(options.branch_from).exists():
        return ["--branch-from", str(Path(directory).absolute()), "--branch-step", step]
    return ["--branch-from", str(Path(options.branch_from).absolute())]


def component_command(plan: Plan, role: str, connection: Connection) -> list[str]:
    command = program_of(plan, role) + connection.arguments(role, role not in plan.commands)
    command += ["--name", role] if role in plan.controllers else []
    if plan.silence_s > COUPLER_SILENCE_S:  # a component waits longer for the coupler than the coupler does for it
        command += ["--orphan-after", f"{plan.silence_s + _ORPHAN_AFTER_S - COUPLER_SILENCE_S:g}"]
    return with_ranks(plan, role, command)


def program_of(plan: Plan, role: str) -> list[str]:
    """Our service, of bodies that of the chosen solver, or the command that replaces it."""
    service = "fluid_service" if role == "fluid" else _BODY_SERVICES[plan.body_solver]
    return plan.commands.get(role) or [str(program(service))]


def with_ranks(plan: Plan, role: str, command: list[str]) -> list[str]:
    """The command of a component, that of a fluid behind mpirun where that is needed."""
    if role != "fluid" or not _needs_mpirun(plan):
        return command
    here = ["--oversubscribe", "--mca", "pml", os.environ.get("OMPI_MCA_pml", "ob1")]  # trying all takes 0.2 s
    return [mpirun(), "-n", str(plan.fluid_ranks), *([] if hosts.others(plan) else here), *command]


def mpirun() -> str:
    """That of the MPI which our fluid service was built with: another one starts ranks that do not find each other."""
    built, found = program("mpirun"), shutil.which("mpirun")
    return str(built.resolve()) if built.exists() and not (found and built.samefile(found)) else "mpirun"


def _needs_mpirun(plan: Plan) -> bool:
    """Our fluid service always, one that replaces it if it is to have several ranks and brings no starter."""
    own = plan.commands.get("fluid")
    return own is None or (plan.fluid_ranks > 1 and Path(own[0]).name not in _STARTERS)


def settled(plan: Plan, ranks: int | None = None) -> Plan:
    """The plan as it can be carried out: a component that replaces our fluid is started once unless it announces MPI
    or the user has chosen its `ranks`.

    Raises Stop(2) if a program is missing or the ranks would exhaust the machine, before anything is started.
    """
    _require_programs(plan)
    _require_address(plan.transport)
    hosts.require_first_here(plan)
    own = plan.commands.get("fluid")
    if own and _needs_mpirun(plan) and not (ranks or "fluid" in plan.unasked or announces(own, "mpi")):
        return replace(plan, fluid_ranks=1)
    cores = len(os.sched_getaffinity(0))
    if _needs_mpirun(plan) and not hosts.others(plan) and plan.fluid_ranks > _MOST_RANKS_PER_CORE * cores:
        raise BadCase(
            f"{plan.fluid_ranks} fluid ranks are too many (each is a process, and this machine has {cores} core(s)). "
            f"Use --ranks {cores}, or start ranks on several machines yourself: --fluid 'mpirun …'."
        )
    return plan


def _require_address(transport: str) -> None:
    """Raises Stop(2) unless the coupler can listen there: at an address of this machine, or a name that has one."""
    if not transport.startswith("tcp://"):
        return
    host = transport.removeprefix("tcp://").rpartition(":")[0].strip("[]")
    try:
        hosts.bind_to(host)
    except OSError as problem:
        raise BadCase(
            f"the coupler cannot listen on {transport} ({host}: {problem.strerror}). Give services.transport "
            "an address or a name of this machine."
        ) from None


def _require_programs(plan: Plan) -> None:
    solver, service = plan.body_solver, _BODY_SERVICES[plan.body_solver]
    is_engine = service != _BODY_SERVICES["own"]
    if "body" not in plan.commands and is_engine and not Path(program_of(plan, "body")[0]).exists():
        raise BadCase(
            f"body.solver is {solver} (this build has no {service}: the library was missing when it was "
            f"configured). Install lib{solver}-dev, remove the build folder, and run again."
        )
    for role, command in plan.commands.items():
        if shutil.which(command[0]) is None:
            raise BadCase(
                f"the {role} component {shlex.join(command)} cannot be started (no such program). "
                "Give its path, or put it in PATH."
            )


def announces(command: Sequence[str], feature: str) -> bool:
    """Whether a component can be asked and announces `feature`."""
    return shutil.which(command[0]) is not None and feature in ask(tuple(command)).get("features", [])


def run_to_answer(command: Sequence[str], within_s: float, given: bytes = b"") -> tuple[Any, int, str]:
    """(the JSON on its standard output, None if it is none; exit code; its standard error) of a component.

    Raises OSError if it cannot be started, subprocess.TimeoutExpired.
    """
    done = subprocess.run(command, env=environment_to_ask(), input=given, capture_output=True, timeout=within_s)
    errors = done.stderr.decode(errors="replace")
    try:
        text = done.stdout.decode(errors="replace").lstrip()
        return json.JSONDecoder().raw_decode(text)[0], done.returncode, errors  # under mpirun every rank may print it
    except ValueError:
        return None, done.returncode, errors


@functools.cache
def ask(command: tuple[str, ...]) -> dict[str, Any]:
    """A component's name, role and features; or why they cannot be read, as `problem`. Raises Stop(2) if the command
    cannot be started."""
    try:
        read, _, errors = run_to_answer([*command, "--capabilities"], _ANSWER_WITHIN_S)
    except OSError as problem:
        raise BadCase(f"a component cannot be started ({problem}). Check this command: {shlex.join(command)}") from None
    except subprocess.TimeoutExpired:
        return {"problem": f"it does not answer --capabilities within {_ANSWER_WITHIN_S} s"}
    if isinstance(read, dict):
        return {"name": shlex.join(command), "role": "", "features": []} | read | {"problem": ""}
    lines = errors.strip().splitlines()
    last = f" but with: {lines[-1].strip()}" if lines else ""
    return {"problem": f"it does not answer --capabilities with JSON{last}"}


def problems_of_components(plan: Plan, roles: Iterable[str] | None = None) -> Iterator[str]:
    """What keeps components from taking part in the run: one does not answer, has another role, or can do less than the
    case needs."""
    for role in plan.roles if roles is None else roles:
        command = program_of(plan, role)
        # A folder of programs for runs in one process need not hold our own.
        if role in plan.unasked or role not in plan.commands and not Path(command[0]).exists():
            continue
        answer = ask(tuple(command))
        if answer["problem"]:
            yield (
                f"{shlex.join(command)} cannot be used as {role} component ({answer['problem']}). "
                "Give the command of a component, see docs/adding_a_component.md."
            )
            continue
        name, announced, features = answer["name"], answer["role"], answer["features"]
        if announced not in ("controller" if role in plan.controllers else role, ""):
            remedy = f"Use --{announced}" if announced in ROLES else "Name it in the case's controllers"
            yield f"{name} cannot be used as {role} component (it is a {announced} component). {remedy}."
            continue
        for feature, accepted in plan.requires.get(role, {}).items():
            if not set(accepted) & set(features):
                misspelt = difflib.get_close_matches(feature, features, n=1, cutoff=0.8)
                yield (
                    f"the case needs «{feature}» ({name} does not announce it"
                    + (f", but «{misspelt[0]}»" if misspelt else "")
                    + f"). Change the case, or use another --{role} component."
                )


def environment(scratch: Scratch, ranks: int) -> dict[str, str]:
    """Environment of all processes: the mark, and settings for those variables that the user has not set."""
    settings = {
        "OMPI_MCA_orte_tmpdir_base": str(scratch.files),
        "OMPI_MCA_btl_vader_backing_directory": str(scratch.shared_memory),
        "OMPI_MCA_osc_sm_backing_directory": str(scratch.shared_memory),
        "OMPI_MCA_plm": "^slurm",  # ranks run here, also in a job that has other nodes
        "OMPI_MCA_ras": "^slurm",
        "OMPI_MCA_opal_signal": "16",  # one never sent: its handler of crashes allocates, and may wait for ever
        "OMPI_MCA_odls_base_sigkill_timeout": "0",  # when a rank died, mpirun need not wait to end the others
    }
    if ranks + 2 > len(os.sched_getaffinity(0)):
        settings |= ON_SHARED_CORES
    return {**settings, **environment_to_ask(), MARK: scratch.mark}


def environment_to_ask() -> dict[str, str]:
    """Environment of a component that only answers a question: the user's, without the variables that an mpirun sets
    for this command if it starts it, which ours would obey."""
    variables = {**os.environ, "PYTHONPATH": python_path_of_components()}
    if "OMPI_COMM_WORLD_RANK" in variables:
        variables = {name: value for name, value in variables.items() if not name.startswith(_OF_MPIRUN)}
    return {**_AS_ROOT, **variables}
