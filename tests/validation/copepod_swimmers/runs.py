"""Runs of a campaign by name, and their last cycles."""

from pathlib import Path

import numpy as np

from copepod import Run
from copepod_report.run_record import members_of


def members(campaign: Path, name: str) -> list[Run]:
    """The finished run NAME of a campaign, or the members of the sweep NAME in the order of their values."""
    found = members_of(campaign)
    return [Run(campaign / run) for run, sweep, case in found if name in (run, sweep.name) and case["summary"]]


def radii_m(run: Run) -> np.ndarray:
    """Of all beads in the order of the case."""
    return np.array([bead["radius_m"] for swimmer in run.case["swimmers"] for bead in swimmer["beads"]])


def period_s(run: Run, swimmer: str) -> float:
    """Of a swimmer's cycles."""
    return float(np.diff(run.cycles.loc[swimmer]["start_s"])[0])


def last_cycle(run: Run, swimmer: str, columns: str = "{}_m") -> np.ndarray:
    """A vector of the trajectory, by its columns of x, y and z, in the last full cycle without its end, shape (beads,
    samples, 3)."""
    before, start = run.cycles.loc[swimmer]["start_step"].iloc[-2:]
    samples = run.trajectory[[columns.format(axis) for axis in "xyz"]]
    beads = [body for body in samples.index.unique("body") if body.startswith(f"{swimmer}.")]
    return np.array([samples.loc[bead].loc[start : 2 * start - before - 1] for bead in beads])


def turn_fraction(angle: float) -> float:
    """The angle in one turn that starts just below zero, so that nothing is not mistaken for a whole turn [rad]."""
    return float((angle + 0.1) % (2 * np.pi) - 0.1)
