"""What the coupler makes of a case file before anything is started: `coupler --plan`."""

import json
import subprocess
from dataclasses import dataclass
from types import SimpleNamespace

from copepod_run import exit_codes
from copepod_run.checkout import program
from copepod_run.errors import Stop
from copepod_run.stages import say_lines


@dataclass(frozen=True)
class Plan:
    """The answer of `coupler --plan`, see docs/protocol for its keys."""

    name: str
    steps: int
    case: dict
    case_yaml: str
    fluid_ranks: int
    fluid_command: list  # what replaces our fluid service, or None
    body_solver: str  # "own", "bullet" or "external"
    body_command: list  # what replaces the body service, or None
    transport: str  # "ipc" or "tcp://host:port"
    requires: dict
    estimate: dict
    warnings: list
    notes: list
    sweep: dict  # key and members (value, settings) of a case that is several, or None


def case_arguments(options):
    """Arguments that the coupler needs to see the case as the user wants it."""
    arguments = [options.case]
    for setting in options.set:
        arguments += ["--set", setting]
    for name in ("ranks", "fluid", "body"):
        if getattr(options, name) is not None:
            arguments += [f"--{name}", str(getattr(options, name))]
    return arguments


def request_plan(options):
    """Asks the coupler. Raises Stop(2) after passing on its list of errors if the case is bad."""
    return parse_plan(_ask_coupler(["--plan", *case_arguments(options)]))


def plan_of(file, settings=()):
    """Plan of a case file. Raises Stop(2) if it is bad or missing."""
    return request_plan(SimpleNamespace(case=str(file), set=settings, ranks=None, fluid=None, body=None))


def request_campaign(file):
    """Name, jobs and cases of a campaign file. Raises Stop(2) after passing on the errors if it is bad."""
    return json.loads(_ask_coupler(["--campaign", file]))


def resolved_case(file):
    """The resolved case in `file` as the present coupler reads it, or None if there is none that it can read."""
    answer = subprocess.run(
        [str(program("coupler")), "--plan", str(file)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    return parse_plan(answer.stdout).case if answer.returncode == 0 else None


def _ask_coupler(arguments):
    """What the coupler prints; its list of errors is passed on."""
    try:
        answer = subprocess.run(
            [str(program("coupler")), *arguments],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",  # errors quote the file, whatever it holds
        )
    except OSError as problem:
        raise Stop(
            exit_codes.PREPARATION_FAILED,
            f"{program('coupler')} cannot be started ({problem.strerror}). If it is being built just now, wait for "
            "that; otherwise run: copepod setup",
        ) from None
    say_lines(answer.stderr)
    if answer.returncode == exit_codes.BAD_CASE:
        raise Stop(exit_codes.BAD_CASE)
    if answer.returncode != 0:
        raise Stop(
            exit_codes.SOLVER_FAILED,
            f"coupler {arguments[0]} ended with code {answer.returncode} "
            "(a defect: it should name what is wrong with the file). Please report it.",
        )
    return answer.stdout


def parse_plan(text):
    """Plan from the coupler's JSON. Raises Stop(70) if it is not what the coupler promises."""
    try:
        plan = json.loads(text)
        services = plan["services"]
        return Plan(
            name=plan["name"],
            steps=int(plan["steps"]),
            case=plan["case"],
            case_yaml=plan["case_yaml"],
            fluid_ranks=int(services["fluid"]["ranks"]),
            fluid_command=services["fluid"].get("command"),
            body_solver=services["body"].get("solver", "own"),
            body_command=services["body"].get("command"),
            transport=services["transport"],
            requires=plan.get("requires", {}),
            estimate=plan.get("estimate", {}),
            warnings=plan.get("warnings", []),
            notes=plan.get("notes", []),
            sweep=plan.get("sweep"),
        )
    except (ValueError, KeyError, TypeError) as problem:
        raise Stop(
            exit_codes.SOLVER_FAILED,
            f"the answer of coupler --plan cannot be read ({problem!r}; is it of "
            "another version?). Build coupler and command from one checkout.",
        ) from None
