"""What a run will need: memory, as its components estimate it, and time, at the speed that this machine has shown."""

import json
import os
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from copepod_run import components
from copepod_run.checkout import BUILD, chosen_programs
from copepod_run.errors import ExitCode, Stop
from copepod_run.plan import Plan

_SPEEDS = BUILD / "measured_speed.json"
_ANSWER_WITHIN_S = 60


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
    services = [
        ("fluid", components.fluid_program(plan), plan.fluid_ranks, plan.fluid_command is None),
        ("body", components.body_program(plan), 1, plan.body_command is None),
    ]
    found = []
    for role, command, processes, is_ours in services if plan.transport != components.IN_PROCESS else []:
        if role in plan.unasked:
            continue
        # The services of this build estimate; asking them for their capabilities first would take longer than that.
        estimates = (is_ours and not chosen_programs()) or components.announces(command, "estimate")
        if estimates:
            setup = bytes.fromhex(plan.setups[role])
            found.append(_ask(role, [*command, "--estimate", "--ranks", str(processes)], setup, processes))
    return found + ([Memory("coupler", 1, known["coupler_bytes"])] if known.get("coupler_bytes") else [])


def _ask(role: str, command: Sequence[str], setup: bytes, processes: int) -> Memory:
    try:
        read, code, errors = components.run_to_answer(command, _ANSWER_WITHIN_S, setup)
        if code == 0:
            return Memory(role, processes, int(read["memory_bytes"]), str(read.get("problem", "")))
    except (OSError, ValueError, KeyError, TypeError, subprocess.TimeoutExpired) as problem:
        raise Stop(
            ExitCode.BAD_CASE,
            f"the {role} component announces estimates, but its answer cannot be read ({problem}). "
            "See docs/protocol.md, Estimates.",
        ) from None
    reasons = [line.removeprefix("error: ") for line in errors.splitlines() if line.startswith("error: ")]
    raise Stop(
        ExitCode.BAD_CASE, reasons[0] if reasons else f"the {role} component refuses the case (exit code {code})."
    )


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


def remember(summary: Mapping[str, Any]) -> None:
    """Keeps MLUPS by precision and ranks of a finished run."""
    mlups = summary.get("mlups")
    if not mlups:
        return
    speeds = _read_speeds()
    speeds.setdefault(summary.get("precision", ""), {})[str(summary.get("ranks", 1))] = mlups
    try:
        _SPEEDS.write_text(json.dumps(speeds, indent=2) + "\n")
    except OSError:  # a read-only checkout; only an estimate is lost
        pass


def remembered(precision: str, ranks: int) -> float | None:
    """MLUPS of the last run with this precision and number of ranks."""
    return _read_speeds().get(precision, {}).get(str(ranks))


def _read_speeds() -> dict[str, dict[str, float]]:
    try:
        speeds: dict[str, dict[str, float]] = json.loads(_SPEEDS.read_text())
        return speeds
    except (OSError, ValueError):
        return {}
