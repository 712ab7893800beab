"""Everything that a report needs of one run directory."""

import json
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from copepod_report.cycles import Cycles, kinematics_so_far, read_cycles
from copepod_report.run_status import RunStatus, state_of, status_of
from copepod_report.scene import BEADS, Body, bead_names, bodies_of
from copepod_report.trajectory import Trajectory, trajectory_in
from copepod_run.errors import BadCase, StorageFailed
from copepod_run.figures import at, measured, quantity_text

ReadCase = Callable[[Path], dict[str, Any]]  # from the path of a case file to the resolved case
_Content = TypeVar("_Content")


@dataclass(frozen=True)
class Sweep:
    """What makes a run a member of a sweep, by swept key; empty for others."""

    name: str = ""
    values: dict[str, Any] = field(default_factory=dict)
    scales: dict[str, str] = field(default_factory=dict)  # «linear» or «logarithmic»


@dataclass(eq=False)
class RunResult:
    """What tables and figures of several runs take of each."""

    directory: Path
    name: str
    sweep: Sweep
    status: RunStatus
    summary: Any  # as in summary.json


class RunRecord(RunResult):
    """A run: `status`, `summary`, resolved `case` as the coupler reads it, `trajectory`, `cycles` by swimmer.

    Of a run that has not finished they hold what there is so far, and the summary what follows from its cycles.
    """

    def __init__(self, directory: str | Path, read_case: ReadCase, sweep: Sweep | None = None) -> None:
        """`sweep`: of which it is a member.

        Raises Stop(2) if the folder does not hold a run, Stop(73) if one of its files is damaged.
        """
        self.directory = Path(directory)
        self.label = self.directory.resolve().name  # among other runs of its case
        self.sweep = sweep or Sweep()
        state = state_of(self.directory)
        trajectory = trajectory_in(self.directory)
        needed = ("case.yaml", "summary.json", trajectory.name) if state[0] == "finished" else ("case.yaml",)
        for name in needed:
            if not (self.directory / name).is_file():
                raise BadCase(f"{directory} has no {name} (it is not a run). Give run directories.")
        if state[0] == "finished":
            self.summary = read_file(self.directory / "summary.json", _read_summary)
        self.case = read_case(self.directory / "case.yaml")
        may_be_empty = state[0] != "finished" or not (self.case.get("bodies") or self.case.get("swimmers"))
        self.trajectory = read_file(trajectory, lambda path: Trajectory(path, may_be_empty))
        self.cycles: dict[str, Cycles] = read_file(self.directory / "cycles.csv", read_cycles)
        self.status = status_of(self.directory, self.case, state, int(self.trajectory.steps[-1:].sum()))
        if not self.status.is_finished:
            self.summary = self._summary_so_far()
        self.cell_size_m = self.summary.get("cell_size_m")
        parameters = self.summary.get("parameter_set")
        self.name = f"{self.summary['case']} ({parameters})" if parameters else self.summary["case"]

    def _summary_so_far(self) -> dict[str, Any]:
        """Keys of summary.json as far as they are known before the end."""
        steps, time_s = self.trajectory.steps[-1:], self.trajectory.time_s[-1:]
        step_s = float(time_s[0] / steps[0]) if steps.any() else self.case.get("step_s")
        cell_size_m = at(self.case, "fluid.cell_size_m") or None
        entries: dict[str, list[dict[str, Any]]] = {"swimmers": [], "groups": []}
        swimmers = {section["name"] for section in self.case.get("swimmers") or []}
        for name in dict.fromkeys([*swimmers, *self.cycles]):
            figures = kinematics_so_far(self.cycles[name]) if name in self.cycles else {}
            entries["swimmers" if name in swimmers else "groups"].append({"name": name, "kinematics": figures})
        return {
            "case": self.case.get("case") or self.label,
            "parameter_set": self.case.get("parameter_set"),
            "status": self.status.state,
            "steps": self.status.step,
            "step_s": step_s,
            "cell_size_m": cell_size_m,
            **entries,
        }

    @property
    def length_unit(self) -> tuple[float, str]:
        """(metres per unit, name): cells where there is a lattice, else micrometres."""
        return (self.cell_size_m, "cells") if self.cell_size_m else (1e-6, "µm")

    @property
    def domain_m(self) -> np.ndarray:
        """Lengths of the domain along x, y and z; without a lattice they are zero."""
        return np.array(at(self.case, "fluid.domain_cells") or (0, 0, 0)) * (self.cell_size_m or 0.0)

    @property
    def is_periodic(self) -> list[bool]:
        """Along x, y and z."""
        return [self.case["fluid"]["boundaries"][axis]["low"] == "periodic" for axis in "xyz"]

    def arms_of(self, name: str) -> list[str]:
        """The ends of each arm of a swimmer or group: «A–B»."""
        arms = [at(entry, "kinematics.arms") or [] for entry in measured(self.summary) if entry["name"] == name]
        ends = [arm["bodies"] for arm in (arms or [[]])[0] if "bodies" in arm]
        return ["–".join(body.removeprefix(f"{name}.") for body in pair) for pair in ends]

    @cached_property
    def bodies(self) -> list[Body]:
        """Those that are in the trajectory, in its order."""
        known = bodies_of(self.case)
        return [known[name] for name in self.trajectory.bodies if name in known]

    def parameters(self) -> str:
        """What a caption has to give: case, radius, cell size, step, relaxation time, period, Reynolds number."""
        radii = sorted({radius for body in self.bodies if (radius := body.surface.radius_m)})
        periods = {swimmer.period for swimmer in self.swimmers if swimmer.period}
        reynolds = [at(entry, "Re_swim") or at(entry, "kinematics.Re") for entry in measured(self.summary)]
        step_s, relaxation_time = self.summary.get("step_s"), at(self.case, "fluid.relaxation_time")
        entries = [
            ("radius", " to ".join(dict.fromkeys(quantity_text(r, "m") for r in (radii[:1] + radii[-1:])))),
            ("cell", quantity_text(self.cell_size_m, "m") if self.cell_size_m else ""),
            ("step", quantity_text(step_s, "s") if step_s else ""),
            ("relaxation time", f"{relaxation_time:.4g}" if relaxation_time else ""),
            ("period", quantity_text(periods.pop() * step_s, "s") if len(periods) == 1 and step_s else ""),
            ("Re", f"{reynolds[0]:.2g}" if len(reynolds) == 1 and reynolds[0] else ""),
        ]
        return ", ".join([self.name, *(f"{what} {text}" for what, text in entries if text)])

    @cached_property
    def swimmers(self) -> "list[SwimmerRecord]":
        return [SwimmerRecord(self, section) for section in self.case.get("swimmers") or []]


def collect(directory: str | Path, read_case: ReadCase) -> list[RunRecord]:
    """The run in a run directory, or those in the folder of a campaign or sweep."""
    directory = Path(directory)
    if not (directory / "results.json").exists():
        return [RunRecord(directory, read_case)]
    return [
        RunRecord(directory / name, read_case, sweep)
        for name, sweep, case in members_of(directory)
        if case["summary"] is not None or (directory / name / "case.yaml").is_file()
    ]


def name_apart(runs: Sequence[RunRecord]) -> None:
    """Runs of one case get their labels for names, or their directories where labels are the same, too."""
    for rename in (lambda run: run.label, lambda run: str(run.directory)):
        times = Counter(run.name for run in runs)
        for run in runs:
            if times[run.name] > 1:
                run.name = rename(run)


DAMAGE = (ArithmeticError, AttributeError, LookupError, RuntimeError, TypeError, ValueError)  # what it may lead to


def read_file(path: Path, reader: Callable[[Path], _Content]) -> _Content:
    """What `reader` makes of a file, which need not exist. Raises Stop(73) if it is damaged, or something else."""
    try:
        if path.exists() and not path.is_file():
            raise ValueError("it is not a file")
        return reader(path)
    except (OSError, *DAMAGE) as problem:
        raise StorageFailed(f"{path} cannot be read (cut off or damaged: {problem}). Run the case again.") from None


def _read_summary(path: Path) -> Any:
    summary = json.loads(path.read_text())
    names = [summary["case"], *(entry["name"] for entry in measured(summary))]
    if not all(isinstance(name, str) for name in names):
        raise ValueError("a name in it is not a text")
    return summary


def members_of(directory: Path) -> list[tuple[str, Sweep, dict[str, Any]]]:
    """Name, sweep and record of every case of a campaign. Raises Stop(73) if results.json is damaged."""
    return read_file(directory / "results.json", _read_members)


def _read_members(path: Path) -> list[tuple[str, Sweep, dict[str, Any]]]:
    content = json.loads(path.read_text())
    scales = {parameter["key"]: parameter["scale"] for parameter in content.get("parameters", [])}
    return [
        (case["name"], Sweep(case.get("member_of") or "", case.get("parameters", {}), scales), case)
        for case in content["cases"]
    ]


def rotated(vectors: ArrayLike, orientation_wxyz: ArrayLike) -> np.ndarray:
    """Vectors v of the frame of a body or swimmer in the world, shape (…, 3), from its unit quaternions (w, r).

    v + 2 r × (r × v + w v)
    """
    v, wr = np.array(vectors, float), np.array(orientation_wxyz, float)
    w, r = wr[..., :1], wr[..., 1:]
    return v + 2 * np.cross(r, np.cross(r, v) + w * v)


class SwimmerRecord:
    """One swimmer of a run. The motion is that of three beads in a row, along the swimmer's axis at the start."""

    def __init__(self, run: RunRecord, section: dict[str, Any]) -> None:
        self.run = run
        self.section = section
        self.name = section["name"]
        self.axis = rotated([0.0, 0.0, 1.0], section["orientation_wxyz"])
        self.bead_names = bead_names(section)
        stroke = section.get("stroke") or {}
        self.is_three_beads = bool(stroke)  # in a row, as in the paper
        self.period = int(stroke.get("period_steps", 0))
        self.cycles = int(stroke.get("cycles", 0))

    def last_period(self) -> np.ndarray:
        """Mask of the samples in the last driven period; empty if the run ended before.

        Of a run that has not finished: the last full one so far.
        """
        steps = self.run.trajectory.steps
        cycles = self.cycles if self.run.status.is_finished else min(self.cycles, int(steps[-1]) // self.period)
        start, stop = (cycles - 1) * self.period, cycles * self.period
        mask = (steps >= start) & (steps <= stop)
        return mask if steps[-1] >= stop > 0 and mask.sum() > 8 else np.zeros_like(mask)

    def along_axis(self, quantity: str) -> np.ndarray:
        """Component of a vector of each bead along the swimmer's axis, shape (3, samples)."""
        of = self.run.trajectory.of
        return np.array([of(f"{self.name}.{bead}")[quantity] @ self.axis for bead in BEADS])


def fit_arm(phase: np.ndarray, length: np.ndarray) -> tuple[float, float, float]:
    """Least-squares fit l(t) = l̄ + d cos(ωt + φ)   [paper, eq. (27)].

    @param phase  ωt of the samples [rad]
    @return (l̄, d, φ)
    """
    matrix = np.column_stack([np.ones_like(phase), np.cos(phase), np.sin(phase)])
    mean, cosine, sine = np.linalg.lstsq(matrix, length, rcond=None)[0]
    return mean, np.hypot(cosine, sine), np.arctan2(-sine, cosine)
