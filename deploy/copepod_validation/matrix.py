"""The matrix of schemes and cases: what runs, as a campaign, and the page made of it."""

import datetime
import json
import platform
import re
import textwrap
from argparse import Namespace
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from string import Template
from typing import Any

from copepod_campaign import campaign
from copepod_report.trajectory import Trajectory
from copepod_run.errors import BadCase
from copepod_run.figures import markdown_table
from copepod_validation.experiment import SCHEMES, CaseDict, Experiment, Overview, Section, experiments

# Each has points (see `experiments`), case_of(point), evaluate(trajectory, point) and section(results); accuracy.md
# has what it compares with.
_CASES = (
    *("sphere_array", "wall", "slow_bodies", "shapes", "resistance", "shear", "oscillating_sphere", "sudden_start"),
    *("inertial_drag", "settling_sphere", "crossing_sphere", "frames", "light_bodies"),
)
CASES = {name: import_module(f"copepod_validation.{name}") for name in _CASES}
FOLDER = Path("runs/validation")
_TEXT = Path(__file__).with_name("accuracy.md").read_text()  # what it is about, what each case compares with, and notes


def run(options: Namespace, again: str) -> dict[str, Section]:
    """Runs what is left to do and evaluates it; sections by case. `again`: the command line that continues.

    Raises Stop(2) for an unknown name, or as a campaign does.
    """
    cases, schemes = options.cases or list(CASES), options.schemes or list(SCHEMES)
    for what, names, known in (("case", cases, list(CASES)), ("scheme", schemes, list(SCHEMES))):
        if unknown := [name for name in names if name not in known]:
            raise BadCase(f"{unknown[0]} is not a {what} of the matrix. Choose from: {', '.join(known)}.")
    chosen = {
        case: [one for scheme in schemes for one in experiments(CASES[case], scheme, options.fast)] for case in cases
    }
    items = [_written(experiment, options.fluid) for found in chosen.values() for experiment in found]
    fixed = Namespace(out=FOLDER, rerun_other_builds=True, keep_going=True, json=False)
    campaign.run_items("validation", items, options.jobs, fixed, again, lambda all: f"{len(all)} runs")

    def measured(case: str, one: Experiment) -> Any:
        return CASES[case].evaluate(Trajectory(FOLDER / one.name, may_be_empty=True), one.point)  # arrays of obstacles

    return {
        case: CASES[case].section([(one.scheme, one.point, measured(case, one)) for one in found])
        for case, found in chosen.items()
        if found
    }


def _written(experiment: Experiment, fluid: str | None) -> dict[str, Any]:
    """The experiment as a case file in the folder, and as an item of a campaign; our own components in one process."""
    case: CaseDict = {"case": experiment.name, **experiment.case}
    if fluid:
        case["fluid"] = {**case["fluid"], "solver": {"command": fluid}}
    elif "body" not in case:
        case["services"] = {"transport": "in_process"}
    path = FOLDER / "cases" / f"{experiment.name}.yaml"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(case, indent=1) + "\n")
    return {"name": experiment.name, "file": str(path), "set": []}


def write_page(folder: Path, sections: Mapping[str, Section], command: str, build: str, part: str) -> Path:
    """accuracy.md, with what to choose, an overview and a section per case, and its figures; returns its path.

    `part`: what of the matrix it leaves out, or nothing.
    """
    overview: Overview = {}
    for section in sections.values():
        overview |= section.overview
        for name, content in section.figures.items():
            (folder / name).write_bytes(content)
    schemes = list(dict.fromkeys(scheme for scheme, _ in overview))
    heads = dict.fromkeys(head for scheme in schemes for one, head in overview if one == scheme)
    columns = ["", *(f"`{scheme}`" for scheme in schemes)]
    rows = [["keys", *(", ".join(f"`{value}`" for value in SCHEMES[scheme].values()) for scheme in schemes)]]
    rows += [[head, *(overview.get((scheme, head), "–") for scheme in schemes)] for head in heads]
    head, *texts = _TEXT.split("\n## ")
    text_of = dict(text.split("\n\n", 1) for text in texts)
    written = f"This command wrote the page on {datetime.date.today()} ({processor()}; programs {build}). It holds the "
    written += f"cases {', '.join(sections)} with the schemes {', '.join(schemes)}{part}."
    parts = [head.format(command=command), *_wrapped(written), f"## What to choose\n\n{text_of['What to choose']}"]
    parts += ["## Overview", markdown_table(" | ".join(columns), map(" | ".join, rows))]
    for case, section in sections.items():
        title = case.replace("_", " ").capitalize()
        parts += [f"## {title}", *_wrapped(_filled(text_of[title], section.values))]
    path = folder / "accuracy.md"
    path.write_text("\n\n".join(part.strip() for part in parts) + "\n")
    return path


def _filled(text: str, values: Mapping[str, Any]) -> str:
    """With the values of «$name» in it. Where a value that is a paragraph is missing, what follows is left out, too."""
    paragraphs, has_value = [], True
    for paragraph in text.split("\n\n"):
        has_value = paragraph[1:] in values if paragraph.startswith("$") else has_value
        paragraphs += [Template(paragraph).substitute(values)] if has_value else []
    return "\n\n".join(paragraphs)


def _wrapped(markdown: str) -> list[str]:
    """Paragraphs of Markdown; prose in lines of 120 columns."""
    paragraphs = markdown.strip().split("\n\n")
    return [part if part[0] in "#|`!" else textwrap.fill(part, 120, break_on_hyphens=False) for part in paragraphs]


def processor() -> str:
    """As in lscpu."""
    found = re.search(r"model name\s*:\s*(.+)", Path("/proc/cpuinfo").read_text())
    return found[1] if found else platform.machine()
