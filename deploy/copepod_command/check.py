"""`copepod check`: everything about a case that can be known before it runs."""

import os
import shlex
from argparse import Namespace
from collections.abc import Sequence
from dataclasses import dataclass, replace

from copepod_run import build, components, estimate
from copepod_run.errors import ExitCode, Stop
from copepod_run.estimate import Memory
from copepod_run.messages import elapsed_text
from copepod_run.plan import Plan, request_plan


@dataclass(frozen=True)
class Findings:
    """What is known of a case before it runs."""

    name: str
    steps: int
    figures: list[tuple[str, str]]  # (name, value)
    warnings: list[str]
    problems: list[str]  # what keeps it from running


def check(options: Namespace) -> int:
    """Prints the key figures of a case that can run; errors end in Stop(2)."""
    found = findings(options)
    width = max((len(name) for name, _ in found.figures), default=0) + 2
    print(f"{options.case}: {found.name}, {found.steps} steps")
    for name, value in found.figures:
        print(f"  {name:<{width}}{value}")
    for warning in found.warnings:
        print(warning)
    for problem in found.problems:
        print(f"error: {problem}")
    if found.problems:
        raise Stop(ExitCode.BAD_CASE)
    print("ok")
    return ExitCode.FINISHED


def findings(options: Namespace) -> Findings:
    """Everything that can be known of a case. Raises Stop(2) with the errors of the coupler if it is bad."""
    build.ensure_programs()
    plan = request_plan(options)
    if not options.start_components:
        plan = replace(plan, unasked=_named_by_case(plan, options))
    plan = components.settled(plan, options)
    problems = components.problems_of_components(plan)
    memory: list[Memory] = []
    try:
        memory = estimate.memory_of(plan)
    except Stop as refusal:
        problems.append(refusal.message)
    rows = [(note["what"], note["value"]) for note in plan.notes]
    warnings = [*plan.warnings, *estimate.warnings(memory), *_rank_warnings(plan)]
    for role in sorted(plan.unasked):
        command = shlex.join(plan.command_of(role) or [])
        warnings.append(
            f"warning: the {role} component was not asked what it can do (that would start a command of the case: "
            f"{command}). Use --start-components if you trust the case."
        )
    return Findings(plan.name, plan.steps, rows + _estimate_rows(plan, memory), warnings, problems)


def _named_by_case(plan: Plan, options: Namespace) -> frozenset[str]:
    """Roles of components whose commands the case has brought along, and not the user."""
    return frozenset(
        role for role in ("fluid", "body") if plan.command_of(role) is not None and getattr(options, role) is None
    )


def _estimate_rows(plan: Plan, memory: Sequence[Memory]) -> list[tuple[str, str]]:
    """Memory and time of the run."""
    rows = []
    if memory:
        parts = ", ".join(part.text() for part in memory)
        rows.append(("memory", f"{sum(part.total for part in memory) / 2**20:.0f} MiB ({parts})"))
    updates = plan.estimate.get("cell_updates")
    if updates:
        precision = plan.case.get("fluid", {}).get("precision", "double")
        mlups = estimate.remembered(precision, plan.fluid_ranks)
        of_what = f"{precision} run on {plan.fluid_ranks} rank(s)"
        if mlups:
            time = f"about {elapsed_text(updates / (mlups * 1e6))}, at the {mlups:.0f} MLUPS of the last {of_what}"
        else:
            time = f"unknown: no {of_what} has finished on this machine yet"
        rows.append(("time", time))
    return rows


def _rank_warnings(plan: Plan) -> list[str]:
    cores = len(os.sched_getaffinity(0))
    if plan.fluid_ranks <= cores:
        return []
    return [
        f"warning: {plan.fluid_ranks} fluid ranks share {cores} core(s) (slower than one rank per core). "
        f"Use --ranks {cores}."
    ]
