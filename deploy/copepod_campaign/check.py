"""What a case, a sweep or a campaign will do and need, before anything of it runs."""

import os
import shlex
from argparse import Namespace
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from copepod_campaign.campaign import item_of_sweep
from copepod_campaign.cases import Member, Problems, members_of, swept_keys, value_text
from copepod_campaign.pool import last_end
from copepod_run import build, components, estimate, hosts
from copepod_run.errors import Stop
from copepod_run.estimate import Memory
from copepod_run.figures import number_text
from copepod_run.messages import elapsed_text
from copepod_run.plan import CampaignPlan, Plan, request

_MANY_RUNS = 1000
_UNKNOWN = "unknown: nothing like them has finished on this machine yet"


@dataclass(frozen=True)
class Check:
    """What is known of a case, sweep or campaign before it runs."""

    name: str  #: of the case
    steps: int  #: of all runs
    figures: dict[str, str]  #: as texts: relaxation time, Reynolds numbers, memory, time, …
    memory_bytes: dict[str, int]  #: by component, of all its processes; of several runs: of those at once
    disk_bytes: dict[str, int]  #: by kind of output
    warnings: list[str]  #: what may go wrong
    problems: list[str]  #: what keeps it from running: a component that cannot be started or can do too little
    runs: int = 1  #: of a sweep or campaign: its members

    def __str__(self) -> str:
        return f"{self.name}: {self.text()}"

    def text(self) -> str:
        """Number of runs and steps; then, line by line, figures, warnings and problems."""
        width = max(map(len, self.figures), default=0)
        lines = [(f"{self.runs} runs, " if self.runs > 1 else "") + f"{self.steps} steps"]
        lines += [f"  {name:<{width}}  {value}" for name, value in self.figures.items()]
        return "\n".join([*lines, *self.warnings, *(f"error: {problem}" for problem in self.problems)])


def findings(options: Namespace) -> Check:
    """Everything that can be known of a case, every member of a sweep or every case of a campaign before it runs.

    Raises Stop(2) with the errors of the coupler if one is bad.
    """
    build.ensure_programs(options)
    plan = request(options)
    if isinstance(plan, CampaignPlan):
        return _of_several(plan.name, plan.items, plan.jobs, options.start_components)
    if plan.sweep:
        return _of_several(plan.name, [item_of_sweep(options, plan)], None, options.start_components)
    if not options.start_components:  # those whose commands the case has brought along, and not the user
        named = (role for role in plan.commands if getattr(options, role, None) is None)
        plan = replace(plan, unasked=frozenset(named))
    plan = components.settled(plan, options.ranks)
    problems = [*components.problems_of_components(plan), *hosts.problems_of_hosts(plan)]
    memory: list[Memory] = []
    try:
        memory = estimate.memory_of(plan)
    except Stop as refusal:
        problems.append(refusal.refused())
    disk_bytes = plan.estimate["disk_bytes"]
    warnings = [*plan.warnings, *estimate.warnings(memory), *estimate.disk_warnings(disk_bytes, "runs")]
    warnings += _rank_warnings(plan) + [
        f"warning: the {role} component was not asked what it can do (that would start a command of the case: "
        f"{shlex.join(plan.commands[role])}). Use --start-components if you trust the case."
        for role in sorted(plan.unasked)
    ]
    return Check(
        plan.name,
        plan.steps,
        {note["what"]: note["value"] for note in plan.notes} | _estimate_rows(plan, memory),
        {part.name: part.total for part in memory},
        disk_bytes,
        warnings,
        problems,
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
    ranks = next(iter(hosts.placement(plan).values())) if plan.hosts else plan.fluid_ranks
    shares = f"{ranks} fluid ranks share {cores} core(s) (slower than one rank per core)"
    return [f"warning: {shares}. Use --ranks {cores}."] if ranks > cores else []


def _of_several(name: str, items: Sequence[Mapping[str, Any]], jobs: int | None, trusted: bool) -> Check:
    """Of the items of a campaign. Raises Stop(2) with the errors of all cases if one is bad."""
    members = members_of(items, trusted)
    jobs = min(jobs or len(os.sched_getaffinity(0)), len(members))
    problems, remarks = Problems(), Problems()
    memory_of: dict[str, list[estimate.Memory]] = {}  # members that are alike for the components are asked for once
    bytes_of: list[int] = []
    disk_bytes: Counter[str] = Counter()
    for member in members:
        plan = member.plan
        disk_bytes.update(plan.estimate.get("disk_bytes", {}))
        remarks.add(member.name, *plan.warnings)
        problems.add(member.name, *components.problems_of_components(plan))
        alike = str((plan.setups, plan.transport, plan.fluid_ranks, plan.commands))
        try:
            if alike not in memory_of:
                memory_of[alike] = estimate.memory_of(plan)
            bytes_of.append(sum(part.total for part in memory_of[alike]))
            remarks.add(member.name, *estimate.warnings(memory_of[alike]))
        except Stop as refusal:
            problems.add(member.name, refusal.refused())
    warnings = remarks.lines() + estimate.disk_warnings(disk_bytes, "runs")
    if len(members) > _MANY_RUNS:
        warnings.append(f"warning: {len(members)} runs are many (each has a folder of its own). Fewer values may do.")
    memory = sum(sorted(bytes_of, reverse=True)[:jobs])
    return Check(
        name,
        sum(member.plan.steps for member in members),
        _rows_of_items(members) | _rows_of_needs(members, memory, disk_bytes, jobs),
        {"at once": memory},
        dict(disk_bytes),
        warnings,
        problems.lines(),
        len(members),
    )


def _rows_of_items(members: Sequence[Member]) -> dict[str, str]:
    """What each sweep varies; how many cases are not of a sweep."""
    rows = {}
    for item in dict.fromkeys(member.item for member in members if member.parameters):
        own = [member for member in members if member.item == item]
        spans = []  # «lag_deg 30 to 150 (5 values)»
        for key, head in swept_keys(own).items():
            texts = list(dict.fromkeys(value_text(member.parameters[key]) for member in own))
            several = f" to {texts[-1]} ({len(texts)} values)" if len(texts) > 1 else ""
            spans.append(f"{head} {texts[0]}{several}")
        rows[item] = f"{len(own)} runs: " + "; ".join(spans)
    single = sum(not member.parameters for member in members)
    return rows | ({"cases without a sweep": str(single)} if single else {})


def _rows_of_needs(members: Sequence[Member], memory: int, disk_bytes: Mapping[str, int], jobs: int) -> dict[str, str]:
    """Cell updates, memory, disk and time of the whole."""
    updates = sum(float(member.plan.estimate.get("cell_updates") or 0.0) for member in members)
    ranks = max(1, len(os.sched_getaffinity(0)) // jobs)
    times = []  # of each run, at the speed that this machine has shown; None if it has not shown any
    for plan in (member.plan for member in members):
        shared = replace(plan, fluid_ranks=ranks) if plan.estimate.get("cell_updates") else plan
        times.append(estimate.time_of(shared)[0] or estimate.time_of(plan)[0])
    known = [time for time in times if time is not None]
    texts = [f"about {elapsed_text(last_end([0.0] * jobs, known))}, {jobs} at once"] if known else []
    if len(known) < len(times):
        texts.append(f"{f'{len(times) - len(known)} runs ' if known else ''}{_UNKNOWN}")
    rows = {
        "cell updates": number_text(updates) if updates else "",
        "memory": f"{memory / 2**20:.0f} MiB at most, for {jobs} at once" if memory else "",
        "disk": estimate.disk_text(disk_bytes) if disk_bytes else "",
        "time": "; ".join(texts),
    }
    return {name: text for name, text in rows.items() if text}
