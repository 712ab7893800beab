"""`copepod check`: everything about a case that can be known before it runs."""

import json
import os
import shlex
from argparse import Namespace
from collections.abc import Sequence
from dataclasses import asdict, replace

from copepod_campaign import check as campaign_check
from copepod_campaign.campaign import item_of_sweep
from copepod_run import build, components, estimate, hosts
from copepod_run.errors import ExitCode, Stop
from copepod_run.estimate import Check, Memory
from copepod_run.plan import CampaignPlan, Plan, request


def check(options: Namespace) -> int:
    """Prints the key figures of a case, sweep or campaign that can run; errors end in Stop(2)."""
    found = findings(options)
    if options.json:
        print(json.dumps(asdict(found)))
    else:
        print(f"{options.case}: {found.name}, {found.text()}")
    if found.problems:
        raise Stop(ExitCode.BAD_CASE)
    if not options.json:
        print("ok")
    return ExitCode.FINISHED


def findings(options: Namespace) -> Check:
    """Everything that can be known of a case, every member of a sweep or every case of a campaign before it runs.

    Raises Stop(2) with the errors of the coupler if one is bad.
    """
    build.ensure_programs(options)
    plan = request(options)
    if isinstance(plan, CampaignPlan):
        return campaign_check.findings(plan.name, plan.items, plan.jobs, options.start_components)
    if plan.sweep:
        return campaign_check.findings(plan.name, [item_of_sweep(options, plan)], None, options.start_components)
    if not options.start_components:
        plan = replace(plan, unasked=_named_by_case(plan, options))
    plan = components.settled(plan, options)
    problems = [*components.problems_of_components(plan), *hosts.problems_of_hosts(plan)]
    memory: list[Memory] = []
    try:
        memory = estimate.memory_of(plan)
    except Stop as refusal:
        problems.append(refusal.refused())
    warnings = [
        *plan.warnings,
        *estimate.warnings(memory),
        *estimate.disk_warnings(plan.estimate["disk_bytes"], "runs"),
        *_rank_warnings(plan),
        *_unasked_warnings(plan),
    ]
    return Check(
        plan.name,
        plan.steps,
        {note["what"]: note["value"] for note in plan.notes} | _estimate_rows(plan, memory),
        {part.name: part.total for part in memory},
        plan.estimate["disk_bytes"],
        warnings,
        problems,
    )


def _named_by_case(plan: Plan, options: Namespace) -> frozenset[str]:
    """Roles of components whose commands the case has brought along, and not the user."""
    return frozenset(
        role for role in ("fluid", "body") if plan.command_of(role) is not None and getattr(options, role) is None
    )


def _estimate_rows(plan: Plan, memory: Sequence[Memory]) -> dict[str, str]:
    """What runs where, memory, disk and time of the run."""
    rows = {f"on {host}": what for host, what in hosts.table(plan)}
    if memory:
        parts = ", ".join(part.text() for part in memory)
        rows["memory"] = f"{sum(part.total for part in memory) / 2**20:.0f} MiB ({parts})"
    return rows | {"disk": estimate.disk_text(plan.estimate["disk_bytes"]), "time": estimate.time_text(plan)}


def _rank_warnings(plan: Plan) -> list[str]:
    cores = len(os.sched_getaffinity(0))
    ranks = hosts.placement(plan)[0].ranks if plan.hosts else plan.fluid_ranks
    if ranks <= cores:
        return []
    return [
        f"warning: {ranks} fluid ranks share {cores} core(s) (slower than one rank per core). " f"Use --ranks {cores}."
    ]


def _unasked_warnings(plan: Plan) -> list[str]:
    return [
        f"warning: the {role} component was not asked what it can do (that would start a command of the case: "
        f"{shlex.join(plan.command_of(role) or [])}). Use --start-components if you trust the case."
        for role in sorted(plan.unasked)
    ]
