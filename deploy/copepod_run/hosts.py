"""Which host of a run has which ranks of the fluid, and how another host is reached.

    python3 -m copepod_run.hosts HOST WORDS…     what mpirun starts instead of ssh for every other host
                                                 (plm_rsh_agent): a guard there that carries out the command
    COPEPOD_HOSTS                                a private file with the order for the guards
"""

import json
import os
import shlex
import shutil
import signal
import socket
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from copepod_run.checkout import MODULES
from copepod_run.errors import BadCase
from copepod_run.host_guard import STARTER
from copepod_run.plan import Plan
from copepod_run.processes import own_host, start_child

ORDER = "COPEPOD_HOSTS"
_NOTHING = ("true",)
_TRIED_FOR_S = 15
_SSH = ("ssh", "-T", "-o", "BatchMode=yes", "-o", "ConnectTimeout=10")
_SRUN = ("srun", "--quiet", "--overlap", "--nodes=1", "--ntasks=1", "--mem=0", "--mpi=none", "--cpu-bind=none")


def placement(plan: Plan) -> dict[str, int]:
    """Ranks of the fluid on the hosts of a case, in its order, the first of which has the command, the coupler and the
    bodies; empty for a run on this machine alone. Ranks fill them in this order."""
    left = plan.fluid_ranks
    ranks_on = {}
    for word in plan.hosts:
        name, _, number = word.partition(":")
        ranks_on[name] = min(left, int(number or 1))
        left -= ranks_on[name]
    return ranks_on


def others(plan: Plan) -> list[str]:
    """The hosts other than this one that have something to do."""
    return [host for host, ranks in list(placement(plan).items())[1:] if ranks > 0]


def host_of_rank_0(plan: Plan) -> str | None:
    """None: this one."""
    first = next((host for host, ranks in placement(plan).items() if ranks > 0), None)
    return first if first in others(plan) else None


def hostfile_text(plan: Plan) -> str:
    """For mpirun, which must recognise this host."""
    ranks_on = placement(plan)
    names = [own_host(), *list(ranks_on)[1:]]
    return "".join(f"{name} slots={ranks}\n" for name, ranks in zip(names, ranks_on.values()) if ranks > 0)


def table(plan: Plan) -> list[tuple[str, str]]:
    """What runs where, for people: (host, components)."""
    rows, start = [], 0
    for number, (host, ranks) in enumerate(placement(plan).items()):
        parts = ["command, coupler, bodies"] if number == 0 else []
        if ranks:
            last = start + ranks - 1
            parts.append(f"fluid rank {start}" if ranks == 1 else f"fluid ranks {start} to {last}")
        rows.append((host, ", ".join(parts) or "nothing"))
        start += ranks
    return rows


def require_first_here(plan: Plan) -> None:
    """Raises Stop(2) unless the command runs on the first host of the case."""
    name = next(iter(placement(plan)), own_host())
    if name.partition(".")[0] == own_host().partition(".")[0]:
        return
    with suppress(OSError):
        bind_to(name)
        return
    raise BadCase(
        f"the first of the hosts is {name}, but this is {own_host()} (coupler and bodies run where the command runs). "
        f"Run it on {name}, or begin the list with {own_host()}:0."
    )


def bind_to(name: str) -> None:
    """Raises OSError unless that is an address of this machine, or a name that has one: no other can be bound to."""
    family, _, _, _, address = socket.getaddrinfo(name, 0, type=socket.SOCK_STREAM)[0]
    with socket.socket(family, socket.SOCK_STREAM) as probe:
        probe.bind(address)


def connecting_command(host: str, command: Sequence[str]) -> list[str]:
    """Carries out `command` on another host, with our stdin: COPEPOD_SSH, else srun inside a Slurm job, else ssh."""
    text = shlex.join(command)
    if chosen := os.environ.get("COPEPOD_SSH"):
        return [*shlex.split(chosen), host, text]
    if "SLURM_JOB_ID" in os.environ and shutil.which("srun"):
        return [*_SRUN, f"--nodelist={host}", "/bin/sh", "-c", text]
    return [*_SSH, host, text]


def not_reached(host: str, why: str) -> str:
    """The error about a host of the case, with the command that must work first."""
    return (
        f"host {host} cannot be reached ({why}). "
        f"This command must succeed without questions: {shlex.join(connecting_command(host, _NOTHING))}"
    )


def problems_of_hosts(plan: Plan) -> list[str]:
    """Errors of the other hosts of a case that cannot be reached; all are tried at once."""
    if not (names := others(plan)):
        return []
    from concurrent.futures import ThreadPoolExecutor  # runs on one host start without it

    with ThreadPoolExecutor(max_workers=len(names)) as pool:
        return [problem for problem in pool.map(_problem_of, names) if problem]


def _problem_of(host: str) -> str:
    try:
        command = connecting_command(host, _NOTHING)
        tried = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=_TRIED_FOR_S)
    except subprocess.TimeoutExpired:
        return not_reached(host, f"no answer within {_TRIED_FOR_S} s")
    except OSError as problem:
        return not_reached(host, str(problem))
    how = f"the command ended with {tried.returncode}"
    *_, last = tried.stderr.decode(errors="replace").strip().splitlines() or [how]
    return not_reached(host, last) if tried.returncode != 0 else ""


def guard_command(variable: str, mark: str) -> list[str]:
    """Starts the guard on another host; `variable`, by which the guards find each other, holds the mark there."""
    return [*_python(f"{variable}={mark}"), "-m", "copepod_run.host_guard"]


def ending_command(variable: str, mark: str) -> list[str]:
    """Continues a guard that is stopped, and kills it if it does not end then: what it has started cleans up."""
    code = "import sys; from copepod_run.cleanup import end_marked; end_marked(sys.argv[1], 2.0)"
    return [*_python(), "-c", code, f"{variable}={mark}"]


def _python(*settings: str) -> list[str]:
    """Becomes a Python that finds our modules and loads no others, with these variables."""
    own = (f"PYTHONPATH={MODULES}", "PYTHONUTF8=1")
    return ["exec", "env", *settings, *own, "/usr/bin/python3", "-S", "-P", "-B"]


def free_endpoint(address: str, host: str) -> str:
    """A port of this host on the network that leads to another one; `address`: ours as seen from there, if known."""
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.connect((address or host, 9))
            own = probe.getsockname()[0]
        with socket.socket() as listener:
            listener.bind((address or own, 0))
            return f"tcp://{address or own}:{listener.getsockname()[1]}"
    except OSError as problem:
        raise BadCase(
            f"host {host} cannot find this one ({problem}). "
            "Give an address: --set services.transport=tcp://ADDRESS:PORT"
        ) from None


def _main(host: str, words: list[str]) -> int:
    """Exit code of mpirun's command on the host."""
    order = json.loads(Path(os.environ[ORDER]).read_text())
    command = connecting_command(host, guard_command(STARTER, order["mark"]))
    process = start_child(command, signal.SIGKILL, stdin=subprocess.PIPE)
    assert process.stdin is not None
    with suppress(OSError):  # seen below
        process.stdin.write(json.dumps({**order, "host": host, "command": " ".join(words)}).encode() + b"\n")
        process.stdin.flush()
    code = process.wait()
    if code < 0 or code == 255:
        how = f"was killed by signal {-code}" if code < 0 else "ended with code 255"
        print(f"copepod: host {host}: its connection, process {process.pid}, {how}.", file=sys.stderr, flush=True)
    return code if code >= 0 else 128 - code


if __name__ == "__main__":
    sys.exit(_main(sys.argv[1], sys.argv[2:]))
