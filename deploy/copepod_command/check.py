"""`copepod check`: everything about a case that can be known before it runs."""

import os
import shlex

from copepod_run import build, capabilities, components, exit_codes, speed
from copepod_run.errors import Stop
from copepod_run.plan import request_plan
from copepod_run.stages import elapsed_text


def check(options):
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
    problems = _problems_of_components(plan)
    for problem in problems:
        print(f"error: {problem}")
    if problems:
        raise Stop(exit_codes.BAD_CASE)
    print("ok")
    return exit_codes.FINISHED


def _estimate_rows(plan):
    """Memory and time of the run."""
    rows = []
    memory = plan.estimate.get("memory_bytes")
    if memory:
        rows.append(("memory", f"{memory / 2**20:.0f} MiB{_shares(plan.estimate.get('memory_of', {}))}"))
    updates = plan.estimate.get("cell_updates")
    if updates:
        precision = plan.case.get("fluid", {}).get("precision", "double")
        mlups = speed.remembered(precision, plan.fluid_ranks)
        rows.append(
            (
                "time",
                f"about {elapsed_text(updates / (mlups * 1e6))}, at the {mlups:.0f} MLUPS of the last "
                f"{precision} run on {plan.fluid_ranks} rank(s)"
                if mlups
                else f"unknown: no {precision} run on {plan.fluid_ranks} rank(s) was made here yet",
            )
        )
    return rows


def _shares(memory_of):
    """How the memory is shared out, in brackets; nothing where the coupler does not tell."""
    shares = []
    if memory_of.get("fluid_rank_bytes"):
        shares.append(f"fluid {memory_of['fluid_ranks']} × {memory_of['fluid_rank_bytes'] / 2**20:.0f}")
    shares += [
        f"{name} {memory_of[key] / 2**20:.0f}"
        for name, key in (("bodies", "body_bytes"), ("coupler", "coupler_bytes"))
        if memory_of.get(key)
    ]
    return f" ({', '.join(shares)})" if shares else ""


def _resource_warnings(plan):
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


def _problems_of_components(plan):
    """What keeps the two components from taking part in the run, as sentences."""
    return [
        problem
        for role, own, command in (
            ("fluid", plan.fluid_command is None, components.fluid_program(plan)),
            ("body", plan.body_command is None, components.body_program(plan)),
        )
        for problem in _problems_of(role, own, command, plan.requires.get(role, {}))
    ]


def _problems_of(role, own, command, required):
    """What the component says about itself is nothing, of another role, or less than the case needs."""
    announced = capabilities.announced(command)
    if announced is None and own:  # a folder of programs for runs in one process need not hold it
        return
    if announced is None:
        yield (
            f"the {role} component {shlex.join(command)} is none (it does not answer --capabilities with JSON). "
            "Give the command of a component, see docs/adding_a_component.md."
        )
        return
    if announced.get("role", role) != role:
        yield f"{announced.get('name', shlex.join(command))} is no {role} component (it says so). Use --{announced['role']}."
        return
    features = announced.get("features", [])
    for feature, kind in required.items():
        waived = kind == "method" and "solver:external" in features
        neglected = f"neglects:{feature}" in features or f"neglects:{feature.partition(':')[0]}" in features
        if not (feature in features or waived or neglected):
            yield (
                f"the case needs «{feature}» ({announced.get('name', role)} cannot do it). "
                f"Change the case, or use another --{role} component."
            )
