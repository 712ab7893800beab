"""`copepod check`: everything about a case that can be known before it runs."""

import os
from argparse import Namespace

from copepod_run import build, components, estimate
from copepod_run.errors import ExitCode, Stop
from copepod_run.messages import elapsed_text
from copepod_run.plan import Plan, request_plan


def check(options: Namespace) -> int:
    """Prints the key figures of a case that can run; errors end in Stop(2)."""
    build.ensure_programs()
    plan = components.settled(request_plan(options), options)
    rows = [(note["what"], note["value"]) for note in plan.notes]
    rows += _estimate_rows(plan)
    width = max((len(name) for name, _ in rows), default=0) + 2
    print(f"{options.case}: {plan.name}, {plan.steps} steps")
    for name, value in rows:
        print(f"  {name:<{width}}{value}")
    for warning in [*plan.warnings, *_resource_warnings(plan)]:
        print(warning)
    problems = components.problems_of_components(plan)
    for problem in problems:
        print(f"error: {problem}")
    if problems:
        raise Stop(ExitCode.BAD_CASE)
    print("ok")
    return ExitCode.FINISHED


def _estimate_rows(plan: Plan) -> list[tuple[str, str]]:
    """Memory and time of the run."""
    rows = []
    memory = plan.estimate.get("memory_bytes")
    if memory:
        rows.append(("memory", f"{memory / 2**20:.0f} MiB{_shares(plan.estimate.get('memory_of', {}))}"))
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


def _shares(memory_of: dict[str, int]) -> str:
    """How the memory is shared out, in brackets; nothing where the coupler does not report it."""
    shares = []
    if memory_of.get("fluid_rank_bytes"):
        shares.append(f"fluid {memory_of['fluid_ranks']} × {memory_of['fluid_rank_bytes'] / 2**20:.0f}")
    shares += [
        f"{name} {memory_of[key] / 2**20:.0f}"
        for name, key in (("bodies", "body_bytes"), ("coupler", "coupler_bytes"))
        if memory_of.get(key)
    ]
    return f" ({', '.join(shares)})" if shares else ""


def _resource_warnings(plan: Plan) -> list[str]:
    warnings = []
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    if plan.estimate.get("memory_bytes", 0) > 0.9 * memory:
        warnings.append(
            f"warning: the run needs {plan.estimate['memory_bytes'] / 2**30:.1f} GiB (this machine has "
            f"{memory / 2**30:.1f} GiB). Use fewer cells, symmetry_planes or precision: single."
        )
    cores = len(os.sched_getaffinity(0))
    if plan.fluid_ranks > cores:
        warnings.append(
            f"warning: {plan.fluid_ranks} fluid ranks share {cores} core(s) (slower than one rank per core). "
            f"Use --ranks {cores}."
        )
    return warnings
