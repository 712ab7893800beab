"""What the coupler makes of a case file before anything is started: `coupler --plan`."""

import json
import subprocess
from argparse import Namespace
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

from copepod_run.checkout import program
from copepod_run.errors import BadCase, ExitCode, Stop
from copepod_run.messages import say_lines

COUPLER_SILENCE_S = 3.0  # default of services.silence_s without a network


@dataclass(frozen=True)
class Plan:
    """The answer of `coupler --plan`, see docs/protocol for its keys."""

    name: str
    steps: int
    case: dict[str, Any]
    fluid_ranks: int
    body_solver: str  # "own", "bullet", "mujoco" or "external"
    commands: dict[str, list[str]]  # of the components that replace our services, by role
    transport: str  # "ipc" or "tcp://host:port"
    hosts: list[str]  # «name» or «name:ranks»; empty: this machine alone
    silence_s: float  # longest time without an answer between the processes
    requires: dict[str, dict[str, list[str]]]  # role: feature: announcements of which one is enough
    setups: dict[str, str]  # role: what the component receives, in Protocol Buffers, as hexadecimal digits
    estimate: dict[str, Any] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)
    notes: list[dict[str, str]] = field(default_factory=list)
    sweep: dict[str, Any] | None = None  # of a case that is several: swept keys, values and settings of each member
    surfaces: dict[str, Any] | None = None  # of bodies and obstacles, if they were asked for
    unasked: frozenset[str] = frozenset()  # roles of components that must not be started, not even to ask them
    controllers: list[str] = field(default_factory=list)  # names, which stand for their roles

    @property
    def roles(self) -> list[str]:
        """Of all components."""
        return ["fluid", "body", *self.controllers]


@dataclass(frozen=True)
class CampaignPlan:
    """The same of a list of cases; the cases themselves have not been looked into."""

    name: str
    jobs: int | None  # at once
    items: list[dict[str, Any]]  # name, file and settings (set) of each


def case_arguments(options: Namespace) -> list[str]:
    """Arguments that give the coupler the case or campaign as specified by the user."""
    arguments = [options.case, *(word for setting in options.set for word in ("--set", setting))]
    for name in ("ranks", "fluid", "body"):
        if (value := getattr(options, name, None)) is not None:
            arguments += [f"--{name}", str(value)]
    return arguments


def request(options: Namespace, asked: Sequence[str] = ()) -> Plan | CampaignPlan:
    """Asks the coupler about a file. Raises Stop(2) with its list of errors if it is bad."""
    command = [str(program("coupler")), "--plan", *case_arguments(options), *asked]
    try:  # errors quote the file, whatever it holds
        answer = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace")
    except OSError as problem:
        raise Stop(
            ExitCode.FAILED,
            f"{command[0]} cannot be started ({problem.strerror}). If a build is under way, wait for it; "
            "otherwise run: copepod setup",
        ) from None
    if answer.returncode == ExitCode.BAD_CASE:
        raise Stop(ExitCode.BAD_CASE, errors=answer.stderr)
    say_lines(answer.stderr)
    if answer.returncode != 0:
        raise Stop(
            ExitCode.SOLVER_FAILED,
            f"coupler --plan ended with code {answer.returncode} "
            "(a defect: it should have named the error in the file). Please report it.",
        )
    try:
        plan = json.loads(answer.stdout)
        return CampaignPlan(plan["name"], plan["jobs"], plan["cases"]) if "cases" in plan else _plan_of_case(plan)
    except (ValueError, KeyError, TypeError) as problem:
        raise Stop(
            ExitCode.SOLVER_FAILED,
            f"the answer of coupler --plan cannot be read ({problem!r}; is it of "
            "another version?). Build coupler and command from one checkout.",
        ) from None


def _plan_of_case(plan: dict[str, Any]) -> Plan:
    services, controllers = plan["services"], plan.get("controllers", {})
    return Plan(
        **{key.name: plan[key.name] for key in fields(Plan) if key.name in plan and key.name != "controllers"},
        controllers=list(controllers),
        fluid_ranks=int(services["fluid"]["ranks"]),
        body_solver=services["body"].get("solver", "own"),
        commands={role: services[role]["command"] for role in ("fluid", "body") if services[role].get("command")}
        | controllers,
        transport=services["transport"],
        hosts=services.get("hosts", []),
        silence_s=float(services.get("silence_s", COUPLER_SILENCE_S)),
    )


def request_plan(options: Namespace, asked: Sequence[str] = ()) -> Plan:
    """Of a case."""
    plan = request(options, asked)
    if isinstance(plan, CampaignPlan):
        hint = f"Run it with: copepod campaign {options.case}"
        raise BadCase(f"{options.case} is a campaign (a list of cases). {hint}")
    return plan


def plan_of(file: str | Path, settings: Sequence[str] = (), asked: Sequence[str] = ()) -> Plan:
    """Plan of a case file; `asked`: "--surfaces" if pages draw it. Raises Stop(2) if it is bad or missing."""
    return request_plan(Namespace(case=str(file), set=settings), asked)


def drawn_case(file: str | Path) -> dict[str, Any]:
    """The resolved case in `file`, and `surfaces`: what pages draw of it. Raises Stop(2) if it is bad or missing."""
    plan = plan_of(file, asked=["--surfaces"])
    return {**plan.case, "surfaces": plan.surfaces}
