"""Command line and environment of the three processes of a run."""

import os
import shlex
import shutil
from dataclasses import dataclass, replace
from pathlib import Path

from copepod_run import capabilities, exit_codes
from copepod_run.checkout import build_digest, program
from copepod_run.component_settings import component_settings
from copepod_run.errors import Stop
from copepod_run.plan import case_arguments

MARK = "COPEPOD_RUN"  # in the environment of every process of a run, so that none can get lost
IN_PROCESS = "in_process"  # services.transport of a run without services
COMPONENT = "COPEPOD_COMPONENT"  # says which one it belongs to

_BODY_SERVICES = {"own": "body_service", "external": "body_service", "bullet": "bullet_body_service"}
_MOST_RANKS_PER_CORE = 32
_STARTERS = ("mpirun", "mpiexec", "srun")


@dataclass(frozen=True)
class Connection:
    """Where the processes of a run meet, and what they must show."""

    endpoint: str
    session: str  # token
    keys: dict  # role to key file; empty: none are needed
    logs: Path  # folder

    def arguments(self, name):
        """The options that every process of a run takes."""
        keys = ["--keys", str(self.keys[name])] if self.keys else []
        return [
            "--endpoint",
            self.endpoint,
            "--session",
            self.session,
            *keys,
            "--log-file",
            str(self.logs / f"{name}.log"),
        ]


def coupler_command(options, plan, directory, connection, resume):
    command = [
        str(program("in_process_run" if plan.transport == IN_PROCESS else "coupler")),
        "--run",
        *case_arguments(options),
        "--out",
        str(directory),
        *connection.arguments("coupler"),
        "--build",
        build_digest(),
    ]
    return command + (["--resume"] if resume else [])


def fluid_program(plan):
    """Our fluid service, or the command that replaces it."""
    return plan.fluid_command or [str(program("fluid_service"))]


def body_program(plan):
    """The body service of the chosen solver, or the command that replaces it."""
    return plan.body_command or [str(program(_BODY_SERVICES[plan.body_solver]))]


def needs_mpirun(plan):
    """Our fluid service always, one that replaces it if it is to have several ranks and brings no starter."""
    return plan.fluid_command is None or (plan.fluid_ranks > 1 and not _brings_starter(plan.fluid_command))


def with_ranks(plan, command):
    """The command of a fluid, behind mpirun where that is needed."""
    return ["mpirun", "-n", str(plan.fluid_ranks), "--oversubscribe", *command] if needs_mpirun(plan) else command


def fluid_command(plan, connection):
    return with_ranks(plan, fluid_program(plan) + connection.arguments("fluid"))


def body_command(plan, connection):
    return body_program(plan) + connection.arguments("body")


def settled(plan, options):
    """The plan as it can be carried out: a component that replaces our fluid is started once unless it knows MPI.

    Raises Stop(2) if a program is missing or the ranks would bring the machine down, before anything is started.
    """
    _check_services(plan)
    own = plan.fluid_command
    if own and plan.fluid_ranks > 1 and not (_brings_starter(own) or options.ranks or capabilities.can(own, "mpi")):
        return replace(plan, fluid_ranks=1)
    _check_ranks(plan)
    return plan


def _check_ranks(plan):
    cores = len(os.sched_getaffinity(0))
    if needs_mpirun(plan) and plan.fluid_ranks > _MOST_RANKS_PER_CORE * cores:
        raise Stop(
            exit_codes.BAD_CASE,
            f"{plan.fluid_ranks} fluid ranks (each is a process, and {cores} core(s) of this machine are to run them "
            f"all). Use --ranks {cores}, or start ranks on several machines yourself: --fluid 'mpirun …'.",
        )


def _brings_starter(command):
    return Path(command[0]).name in _STARTERS


def require_program(role, command):
    """Raises Stop(2) if the first word of a component's command is no program."""
    if shutil.which(command[0]) is None:
        raise Stop(
            exit_codes.BAD_CASE,
            f"the {role} component {shlex.join(command)} cannot be started (no such program). "
            "Give its path, or put it in PATH.",
        )


def _check_services(plan):
    if plan.body_command is None and plan.body_solver == "bullet" and not Path(body_program(plan)[0]).exists():
        raise Stop(
            exit_codes.BAD_CASE,
            "body.solver is bullet (this build has no bullet_body_service: the library was missing when it was "
            "configured). Install libbullet-dev, remove the build folder, and run again.",
        )
    for key, command in (("fluid", plan.fluid_command), ("body", plan.body_command)):
        if command is not None:
            require_program(key, command)


def environment(mark, scratch, ranks):
    """Environment of all three processes: the mark, and settings for those variables that the user has not set."""
    settings = {
        **component_settings(),
        "OMPI_MCA_orte_tmpdir_base": str(scratch.mpi_files),
        "OMPI_MCA_btl_vader_backing_directory": str(scratch.shared_memory),
        "OMPI_MCA_osc_sm_backing_directory": str(scratch.shared_memory),
        "OMPI_MCA_odls_base_sigkill_timeout": "0",  # when a rank died, mpirun need not wait to end the others
    }
    if ranks + 2 > len(os.sched_getaffinity(0)):
        # Cores are shared with the coupler and the bodies: ranks must neither be bound to one core nor spin there.
        settings["OMPI_MCA_hwloc_base_binding_policy"] = "none"
        settings["OMPI_MCA_mpi_yield_when_idle"] = "1"
    return {**settings, **os.environ, MARK: mark}
