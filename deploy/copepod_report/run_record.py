"""Everything that a report needs of one run directory."""

import json
from pathlib import Path

import numpy as np

from copepod_run.errors import ExitCode, Stop
from copepod_report.trajectory import Trajectory

BEADS = ("B2", "B1", "B3")  # trailing, middle, leading


class RunRecord:
    """A run: `summary`, the resolved `case` (as the coupler reads it), `trajectory`, and derived figures."""

    def __init__(self, directory, read_case):
        """`read_case`: function from the path of a case file to the resolved case.

        Raises Stop(2) if the folder holds no finished run, Stop(73) if one of its files is damaged.
        """
        self.directory = Path(directory)
        for name in ("summary.json", "case.yaml", "trajectory.csv"):
            if not (self.directory / name).exists():
                raise Stop(
                    ExitCode.BAD_CASE,
                    f"{directory} has no {name} (no run, or one that did not finish). "
                    "Give run directories of finished runs.",
                )
        self.summary = _read(self.directory / "summary.json", lambda path: json.loads(path.read_text()))
        self.case = read_case(self.directory / "case.yaml")
        self.trajectory = _read(self.directory / "trajectory.csv", Trajectory)
        self.cell_size_m = self.summary.get("cell_size_m")

    @property
    def name(self):
        parameters = self.summary.get("parameter_set")
        return f"{self.summary['case']} ({parameters})" if parameters else self.summary["case"]

    @property
    def length_unit(self):
        """(metres per unit, name): cells where there is a lattice, else micrometres."""
        return (self.cell_size_m, "cells") if self.cell_size_m else (1e-6, "µm")

    def swimmers(self):
        return [SwimmerRecord(self, section) for section in self.case.get("swimmers") or []]


def _read(path, reader):
    """What `reader` makes of a file."""
    try:
        return reader(path)
    except (ValueError, KeyError) as problem:
        raise Stop(
            ExitCode.STORAGE_FAILED, f"{path} cannot be read (cut off or damaged: {problem}). Run the case again."
        ) from None


class SwimmerRecord:
    """One swimmer of a run; lengths in the run's length unit, along the swimmer's axis."""

    def __init__(self, run, section):
        self.run = run
        self.section = section
        self.name = section["name"]
        self.axis = np.array(section["axis"], float)
        self.axis /= np.linalg.norm(self.axis)
        self.center_m = np.array(section["center_m"], float)
        self.beads = section["beads"]
        self.period = int(section["stroke"]["period_steps"])
        self.cycles = int(section["stroke"]["cycles"])
        self.figures = next((entry for entry in run.summary.get("swimmers") or [] if entry["name"] == self.name), {})

    def positions(self):
        """Of the beads from the middle bead's start, shape (3, samples)."""
        unit = self.run.length_unit[0]
        return np.array([(self._body(bead)["position_m"] - self.center_m) @ self.axis / unit for bead in BEADS])

    def displacements_m(self):
        """Of the beads along the axis from where they were in the first sample, shape (3, samples)."""
        moved = [self._body(bead)["position_m"] - self._body(bead)["position_m"][0] for bead in BEADS]
        return np.array([path @ self.axis for path in moved])

    def driving_N(self):
        """Driving forces, shape (3, samples)."""
        return np.array([self._body(bead)["driving_N"] @ self.axis for bead in BEADS])

    def periods(self):
        """Time in periods of the stroke, shape (samples,)."""
        return self.run.trajectory.steps / self.period

    def last_period(self):
        """Mask of the samples in the last driven period; empty if the run ended before."""
        steps = self.run.trajectory.steps
        start, stop = (self.cycles - 1) * self.period, self.cycles * self.period
        mask = (steps >= start) & (steps <= stop)
        return mask if steps[-1] >= stop and mask.sum() > 8 else np.zeros_like(mask)

    def mean_positions_m(self, start_step, stop_step):
        """World positions of the beads averaged over [start_step, stop_step), shape (3, 3)."""
        steps = self.run.trajectory.steps
        mask = (steps >= start_step) & (steps < stop_step)
        mask = mask if mask.any() else np.ones_like(mask)
        return np.array([self._body(bead)["position_m"][mask].mean(axis=0) for bead in BEADS])

    def _body(self, bead):
        return self.run.trajectory.of(f"{self.name}.{bead}")


def fit_arm(phase, length):
    """Least-squares fit l(t) = l̄ + d cos(ωt + φ)   [paper, eq. (27)].

    @param phase  ωt of the samples [rad]
    @return (l̄, d, φ)
    """
    matrix = np.column_stack([np.ones_like(phase), np.cos(phase), np.sin(phase)])
    mean, cosine, sine = np.linalg.lstsq(matrix, length, rcond=None)[0]
    return mean, np.hypot(cosine, sine), np.arctan2(-sine, cosine)
