"""The matrix of schemes and cases: what runs, as a campaign, and the page made of it."""

import json
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

from copepod_campaign import campaign
from copepod_run.errors import ExitCode, Stop
from copepod_validation import crossing_sphere, frames, inertial_drag, light_bodies, oscillating_sphere
from copepod_validation import resistance, settling_sphere, shear, slow_bodies, sphere_array, sudden_start, wall
from copepod_validation.experiment import SCHEMES, CaseDict, Experiment, Section, experiments

# Each has points (see `experiments`), case_of(point), evaluate(folder, point) and section(results); accuracy.md has
# what it compares with.
_CASES = (
    sphere_array,
    wall,
    slow_bodies,
    resistance,
    shear,
    oscillating_sphere,
    sudden_start,
    inertial_drag,
    settling_sphere,
    crossing_sphere,
    frames,
    light_bodies,
)
CASES: dict[str, ModuleType] = {module.__name__.rpartition(".")[2]: module for module in _CASES}
FOLDER = Path("runs/validation")


def run(
    cases: Sequence[str], schemes: Sequence[str], fast: bool, fluid: str | None, jobs: int | None, again: str
) -> dict[str, Section]:
    """Runs what is left to do and evaluates it; sections by case. `fluid`: a command that replaces the fluid service;
    `again`: the command line that continues.

    Raises Stop(2) for an unknown name, or as a campaign does.
    """
    _require(cases, CASES, "case")
    _require(schemes, SCHEMES, "scheme")
    chosen = {case: [one for scheme in schemes for one in experiments(CASES[case], scheme, fast)] for case in cases}
    items = [_written(experiment, fluid) for found in chosen.values() for experiment in found]
    options = Namespace(out=FOLDER, rerun_other_builds=True, keep_going=True, json=False)
    campaign.run_items("validation", items, jobs, options, lambda _: again, lambda all: f"{len(all)} runs")
    return {
        case: CASES[case].section(
            [(one.scheme, one.point, CASES[case].evaluate(FOLDER / one.name, one.point)) for one in found]
        )
        for case, found in chosen.items()
        if found
    }


def _require(names: Sequence[str], known: dict[str, Any], what: str) -> None:
    for name in names:
        if name not in known:
            raise Stop(ExitCode.BAD_CASE, f"{name} is not a {what} of the matrix. Choose from: {', '.join(known)}.")


def _written(experiment: Experiment, fluid: str | None) -> dict[str, Any]:
    """The experiment as a case file in the folder, and as an item of a campaign."""
    case: CaseDict = {"case": experiment.name, **experiment.case}
    if fluid:
        case["fluid"] = {**case["fluid"], "solver": {"command": fluid}}
    path = FOLDER / "cases" / f"{experiment.name}.yaml"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(case, indent=1) + "\n")
    return {"name": experiment.name, "file": str(path), "set": []}
