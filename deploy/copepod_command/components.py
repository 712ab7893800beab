"""Command line and environment of the three processes of a run."""

import os
import re
import shlex
import shutil
from pathlib import Path

from copepod_command import exit_codes
from copepod_command.checkout import build_digest, program
from copepod_command.errors import Stop
from copepod_command.plan import case_arguments

MARK = "COPEPOD_RUN"  # in the environment of every process of a run, so that none can get lost
IN_PROCESS = "in_process"  # services.transport of a run without services
COMPONENT = "COPEPOD_COMPONENT"  # says which one it belongs to

_STARTERS = ("mpirun", "mpiexec", "srun")


def coupler_command(options, plan, directory, endpoint, session, resume):
    command = [
        str(program("in_process_run" if plan.transport == IN_PROCESS else "coupler")),
        "--run",
        *case_arguments(options),
        "--out",
        str(directory),
        "--endpoint",
        endpoint,
        "--session",
        session,
        "--log-file",
        str(directory / "logs" / "coupler.log"),
        "--build",
        build_digest(),
    ]
    return command + (["--resume"] if resume else [])


def needs_mpirun(plan):
    """Our fluid service always, one that replaces it if it is to have several ranks and brings no starter."""
    own = plan.fluid_command
    return own is None or (plan.fluid_ranks > 1 and Path(own[0]).name not in _STARTERS)


def fluid_command(plan, directory, endpoint, session):
    """Our fluid service, or the command that replaces it."""
    command = (plan.fluid_command or [str(program("fluid_service"))]) + _connection(
        "fluid", directory, endpoint, session
    )
    return ["mpirun", "-n", str(plan.fluid_ranks), "--oversubscribe", *command] if needs_mpirun(plan) else command


def body_command(plan, directory, endpoint, session):
    return (plan.body_command or [str(program("body_service"))]) + _connection("body", directory, endpoint, session)


def check_services(plan):
    """Raises Stop(2) if a replacing command cannot be found or the address is not ours, before anything is started."""
    if not _stays_here(plan.transport):
        raise Stop(
            exit_codes.BAD_CASE,
            f"services.transport is {plan.transport} (other machines could listen and take part: there are no keys). "
            "Use ipc, or tcp://127.0.0.1:port.",
        )
    for key, command in (("fluid", plan.fluid_command), ("body", plan.body_command)):
        if command is not None and shutil.which(command[0]) is None:
            raise Stop(
                exit_codes.BAD_CASE,
                f"the {key} component {shlex.join(command)} cannot be started "
                "(no such program). Give its path, or put it in PATH.",
            )


def _stays_here(transport):
    """Whether messages never leave this machine."""
    host = transport.removeprefix("tcp://").rpartition(":")[0].strip("[]")
    return transport in ("ipc", IN_PROCESS) or host in ("localhost", "::1") or re.fullmatch(r"127(\.\d{1,3}){3}", host) is not None


def _connection(name, directory, endpoint, session):
    return ["--endpoint", endpoint, "--session", session, "--log-file", str(directory / "logs" / f"{name}.log")]


def environment(mark, scratch, ranks):
    """Environment of all three processes: the mark, and settings for those variables that the user has not set."""
    settings = {
        "COPEPOD_BUILD_PYTHON": str(
            program("coupler").parent.parent / "python"
        ),  # message classes, for Python components
        "OMPI_ALLOW_RUN_AS_ROOT": "1",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "OMPI_MCA_orte_tmpdir_base": str(scratch.mpi_files),
        "OMPI_MCA_btl_vader_backing_directory": str(scratch.shared_memory),
        "OMPI_MCA_odls_base_sigkill_timeout": "0",  # when a rank died, mpirun need not wait to end the others
    }
    if ranks + 2 > len(os.sched_getaffinity(0)):
        # Cores are shared with the coupler and the bodies: ranks must neither be bound to one core nor spin there.
        settings["OMPI_MCA_hwloc_base_binding_policy"] = "none"
        settings["OMPI_MCA_mpi_yield_when_idle"] = "1"
    return {**settings, **os.environ, MARK: mark}
