"""What a run will need: memory, as its components estimate it; disk; time, at the speed that this machine has shown."""

import json
import os
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from copepod_run import components
from copepod_run.checkout import CACHE, PREFIX, chosen_programs, program
from copepod_run.errors import BadCase
from copepod_run.figures import prefix_of
from copepod_run.messages import elapsed_text
from copepod_run.plan import Plan
from copepod_run.run_directory import read_object

_SPEEDS = CACHE / "measured_speed.json"
_ANSWER_WITHIN_S = 60
_FEWEST_STEPS = 100  # of a run that shows a speed
_MOMENT_S = 0.2
# Bodies whose computation takes as long as the exchange of a step, and the power that the computation grows with.
_GROWTH = {"stokes": (15.0, 2.4)}
_LINEAR = (20.0, 1.0)


@dataclass(frozen=True)
class Memory:
    """Of one component; `warning`: its own remark about the setup, or nothing."""

    name: str
    processes: int
    bytes_per_process: int
    warning: str = ""

    @property
    def total(self) -> int:
        return self.processes * self.bytes_per_process

    def text(self) -> str:
        """«fluid 2 × 512», in MiB."""
        times = f"{self.processes} × " if self.processes > 1 else ""
        return f"{self.name} {times}{self.bytes_per_process / 2**20:.0f}"


def memory_of(plan: Plan) -> list[Memory]:
    """Estimates of the coupler and of the components that announce `estimate`, before anything is started.

    Raises Stop(2) with the component's sentence if it cannot handle the setup, its ranks for instance.
    """
    known = plan.estimate.get("memory_of", {})
    coupler = [Memory("coupler", 1, known["coupler_bytes"])] if known.get("coupler_bytes") else []
    if plan.transport == components.IN_PROCESS:  # the coupler's figure is the whole process but what ranks add
        ranks = _ask(plan, "fluid", [str(program("in_process_run"))])
        return ([ranks] if ranks.total else []) + coupler
    found = []
    for role in components.ROLES:
        command = components.program_of(plan, role)
        # The services of this build estimate; asking them for their capabilities first would take longer than that.
        is_ours = role not in plan.commands and not chosen_programs()
        if role not in plan.unasked and (is_ours or components.announces(command, "estimate")):
            found.append(_ask(plan, role, command))
    return found + coupler


def _ask(plan: Plan, role: str, command: Sequence[str]) -> Memory:
    processes = plan.fluid_ranks if role == "fluid" else 1
    words = [*command, "--estimate", "--ranks", str(processes)]
    try:
        read, code, errors = components.run_to_answer(words, _ANSWER_WITHIN_S, bytes.fromhex(plan.setups[role]))
        if code == 0:
            return Memory(role, processes, int(read["memory_bytes"]), str(read.get("problem", "")))
    except (OSError, ValueError, KeyError, TypeError, subprocess.TimeoutExpired) as problem:
        raise BadCase(
            f"the {role} component announces estimates, but its answer cannot be read ({problem}). "
            "See docs/protocol.md, Estimates."
        ) from None
    reasons = [line.removeprefix("error: ") for line in errors.splitlines() if line.startswith("error: ")]
    reason = reasons[0] if reasons else f"the {role} component refuses the case (exit code {code})."
    if reason.startswith("A message was refused"):  # by a kit of another protocol: the setup has what that one lacks
        reason += f" Build the {role} component with the kit of this release: docs/moving_to_a_newer_kit.md."
    raise BadCase(reason)


def size_text(size_bytes: float) -> str:
    """«1.2 MB», «460 GB»."""
    power, prefix = prefix_of(size_bytes / 0.9995, least=3, most=12)  # 999.5 kB is 1 MB
    return f"{size_bytes / 10**power:.3g} {prefix}B"


def disk_text(parts: Mapping[str, int]) -> str:
    """What is written: «56 MB (fields 36 MB, trajectory 1.2 MB, checkpoints 19 MB)»."""
    shown = ", ".join(f"{name} {size_text(part)}" for name, part in parts.items() if part)
    return f"{size_text(sum(parts.values()))} ({shown})"


def disk_warnings(parts: Mapping[str, int], folder: str) -> list[str]:
    """If what is written does not fit where `folder` is or will be made."""
    needed = sum(parts.values())
    place = Path(folder).absolute()
    while not os.path.exists(place):  # Path.exists fails for a name that the system does not take
        place = place.parent
    free = shutil.disk_usage(place).free
    if needed <= free:
        return []
    return [
        f"warning: the run writes about {disk_text(parts)}, and {size_text(free)} are free in {place}. Write fewer "
        "fields (output.fields) or samples (output.trajectory), or choose --out on another disk."
    ]


def warnings(memory: Sequence[Memory]) -> list[str]:
    """What the components remark, and what this machine cannot provide."""
    found = [f"warning: {part.name}: {part.warning}" for part in memory if part.warning]
    needed = sum(part.total for part in memory)
    present = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    if needed > 0.9 * present:
        found.append(
            f"warning: the run needs {needed / 2**30:.1f} GiB (this machine has {present / 2**30:.1f} GiB). Use fewer "
            "cells, symmetry_planes or precision: single."
        )
    return found


def remember(plan: Plan, summary: Mapping[str, Any]) -> None:
    """Keeps the speed of a finished run: MLUPS by precision and ranks, or seconds per step by solver and bodies.

    One that took a moment shows how long processes take to start, and is left out.
    """
    if plan.steps < _FEWEST_STEPS or summary.get("wall_s", 0.0) < _MOMENT_S:
        return
    speeds = read_object(_SPEEDS)
    if summary.get("mlups"):
        speeds.setdefault(summary.get("precision", ""), {})[str(summary.get("ranks", 1))] = summary["mlups"]
    elif summary.get("wall_s") and not summary.get("resumed_from_step"):
        seconds = summary["wall_s"] / plan.steps
        speeds[_solver_of(plan)] = {str(plan.estimate.get("bodies", 1)): seconds}  # of the latest run only
    with suppress(OSError):  # a read-only checkout; only an estimate is lost
        if PREFIX:
            CACHE.mkdir(parents=True, exist_ok=True)
        _SPEEDS.write_text(json.dumps(speeds, indent=2) + "\n")


def time_text(plan: Plan) -> str:
    """How long a run will take, as far as this machine has shown it."""
    time_s, source = time_of(plan)
    if time_s is None:
        return f"unknown: no {source} has finished on this machine yet"
    return f"about {elapsed_text(time_s)}, {source}"


def time_of(plan: Plan) -> tuple[float | None, str]:
    """Of a run [s], and at which speed; None, and what would have shown one."""
    if updates := plan.estimate.get("cell_updates"):
        precision = plan.case.get("fluid", {}).get("precision", "double")
        of_what = f"{precision} run on {plan.fluid_ranks} rank(s)"
        if mlups := read_object(_SPEEDS).get(precision, {}).get(str(plan.fluid_ranks)):
            return updates / (mlups * 1e6), f"at the {mlups:.0f} MLUPS of the last {of_what}"
    else:
        of_what = f"run with {_solver_of(plan)} fluid"
        for bodies, seconds in read_object(_SPEEDS).get(_solver_of(plan), {}).items():
            many, power = _GROWTH.get(_solver_of(plan), _LINEAR)
            now, then = (1.0 + (n / many) ** power for n in (plan.estimate.get("bodies", 1), int(bodies)))
            of_bodies = f"{bodies} bod{'y' if bodies == '1' else 'ies'}"
            return plan.steps * seconds * now / then, f"from the last {of_what}, of {of_bodies}"
    return None, of_what


def _solver_of(plan: Plan) -> str:
    return str(plan.case.get("fluid", {}).get("solver", "other"))
