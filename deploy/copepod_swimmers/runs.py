"""Runs of a campaign by name, and their numbers."""

import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from copepod_report.cycles import read_cycles
from copepod_report.trajectory import Trajectory


@dataclass(frozen=True)
class Member:
    """A finished run of a campaign; `value` is what a sweep gave the first varied key, NaN outside a sweep."""

    folder: Path
    value: float

    def numbers(self, key: str) -> np.ndarray:
        """All numbers that the resolved case gives a key, in its order: a radius_m per bead."""
        text = (self.folder / "case.yaml").read_text()
        return np.array([float(word) for word in re.findall(rf'\b{key}"?: *([^\s,}}]+)', text)])

    def summary(self) -> dict[str, Any]:
        return json.loads((self.folder / "summary.json").read_text())

    def cycles(self, swimmer: str) -> dict[str, np.ndarray]:
        """Columns of cycles.csv, shape (cycles,) each, of one swimmer."""
        return read_cycles(self.folder / "cycles.csv")[swimmer]

    def last_cycle(self, swimmer: str, quantity: str = "position_m") -> np.ndarray:
        """A quantity of trajectory.csv in the last full cycle, without its end, shape (beads, samples, 3)."""
        trajectory = Trajectory(self.folder)
        start, stop = (self.cycles(swimmer)["start_step"][-2:] @ weights for weights in ((0, 1), (-1, 2)))
        window = (trajectory.steps >= start) & (trajectory.steps < stop)
        beads = [body for body in trajectory.bodies if body.startswith(f"{swimmer}.")]
        return np.array([trajectory.of(bead)[quantity][window] for bead in beads])


def members(campaign: Path, name: str) -> list[Member]:
    """The finished run NAME of a campaign, or the members of the sweep NAME in the order of their values."""
    cases = json.loads((campaign / "results.json").read_text())["cases"]
    return [
        Member(campaign / case["name"], float(next(iter(case["parameters"].values()), "nan")))
        for case in cases
        if name in (case["name"], case["member_of"]) and case["summary"]
    ]
