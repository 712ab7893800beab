"""The runs below the folders that a report is asked for: a run, a campaign, or a sweep."""

import json
import re
from dataclasses import dataclass, field
from pathlib import Path

from copepod_report.run_record import RunRecord


@dataclass
class Sweep:
    """Runs of one case that differ in the stiffness of its swimmer, in vacuum."""

    name: str
    runs: list


@dataclass
class Collection:
    runs: list = field(default_factory=list)
    sweeps: list = field(default_factory=list)


def collect(directory, read_case):
    """Collection of a run directory, or of the finished cases in the folder of a campaign or sweep.

    Members of a sweep («name_01», «name_02», …) in vacuum become a Sweep. Raises Stop(2) for a folder without a run.
    """
    directory = Path(directory)
    if not (directory / "results.json").exists():
        return Collection([RunRecord(directory, read_case)])
    cases = json.loads((directory / "results.json").read_text())["cases"]
    found, sweeps = Collection(), {}
    for case in cases:
        if case["summary"] is None:
            continue
        run = RunRecord(directory / case["name"], read_case)
        match = re.fullmatch(r"(.+)_\d\d+", case["name"])
        if match and run.case["fluid"]["solver"] == "vacuum":
            sweeps.setdefault(match[1], []).append(run)
        else:
            found.runs.append(run)
    found.sweeps = [Sweep(name, runs) for name, runs in sweeps.items()]
    return found
