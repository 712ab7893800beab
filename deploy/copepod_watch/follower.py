"""What a run directory holds, read again and again while the run writes it."""

import os
from pathlib import Path
from typing import Any

import numpy as np

from copepod_report.cycles import read_cycles
from copepod_report.run_status import state_of, status_of
from copepod_report.scene import Samples, most_frames, scene_of
from copepod_report.trajectory import GrowingTrajectory
from copepod_run.figures import MOST_TABLES
from copepod_run.progress import figures
from copepod_run.run_directory import read_object

_SHOWN = slice(0, 11)  # of the columns: time, position, orientation, velocity


class TrajectoryFollower:
    """The samples of a growing trajectory, thinned to what a view shows."""

    def __init__(self, directory: Path) -> None:
        self._trajectory = GrowingTrajectory(directory)
        self._start_again()

    def _start_again(self) -> None:
        self._restarts = self._trajectory.restarts
        self._every = 1
        self._kept: list[tuple[int, np.ndarray]] = []  # step and values, shape (bodies, columns), every `_every`-th
        self._newest: tuple[int, np.ndarray] | None = None

    @property
    def count(self) -> int:
        """Complete samples in the file."""
        return self._trajectory.count

    def update(self) -> None:
        """Reads what the file has gained."""
        newest = None
        for newest in self._trajectory.look():
            if self._restarts != self._trajectory.restarts:
                self._start_again()
            if (self.count - 1) % self._every == 0:
                self._kept.append((newest[0], newest[1]()[:, _SHOWN]))
            if len(self._kept) > 2 * most_frames(len(self._trajectory.bodies)):
                self._kept = self._kept[::2]
                self._every *= 2
        if newest:
            self._newest = (newest[0], newest[1]()[:, _SHOWN])

    def samples(self) -> Samples | None:
        """All that is kept, and the newest; None before the first."""
        if self._newest is None:
            return None
        is_kept = self._newest[0] == self._kept[-1][0]
        steps, kept = zip(*self._kept, *([] if is_kept else [self._newest]))
        values = np.array(kept)
        speed = np.linalg.norm(values[..., 8:11], axis=-1)
        time_s, position_m, orientation_wxyz = values[:, 0, 0], values[..., 1:4], values[..., 4:8]
        return Samples(self._trajectory.bodies, np.array(steps), time_s, position_m, orientation_wxyz, speed)


class RunFollower:
    """State, progress, speeds and motion of one run."""

    def __init__(self, directory: Path, case: dict[str, Any], cells: int) -> None:
        """`case`: as the coupler resolves it; `cells`: of the lattice, 0 without one."""
        self.directory = directory
        self.case = case
        self.name: str = case.get("case") or directory.resolve().name
        self._cells = cells
        self._trajectory = TrajectoryFollower(directory)

    def content(self, known: str = "") -> dict[str, Any]:
        """What the page shows, as JSON; the scene only if it differs from the version that is `known`."""
        state = state_of(self.directory)  # first: what a finished run wrote is then complete
        self._trajectory.update()
        samples = self._trajectory.samples()
        event = read_object(self.directory / "logs" / "progress.json")  # empty before the first
        last = int(samples.steps[-1]) if samples else 0
        status = status_of(self.directory, self.case, state, last)
        is_running = state[0] == "running"
        version = f"{id(self)}-{self._trajectory.count}"
        scene = None
        if samples and version != known:
            cell = (self.case.get("fluid") or {}).get("cell_size_m")
            scene = {**scene_of(self.name, self.case, cell, samples), "flow": None}
        return {
            "state": state[0],
            "sentence": status.sentences(),
            "phase": event.get("phase", "") if is_running else "",
            "step": status.step,
            "steps": status.steps,
            "figures": figures(event, self._cells) if is_running and event.get("steps_per_s") else [],
            "speeds": self._speeds(),
            "version": version,
            "scene": scene,
        }

    def state(self) -> str:
        """«running», «finished», …"""
        return state_of(self.directory)[0]

    def _speeds(self) -> list[dict[str, Any]]:
        """Velocity along and across the own axis [m/s] by cycle, of each swimmer, or the mean of a swarm."""
        cycles = read_cycles(self.directory / "cycles.csv")
        columns = {"along_m_per_s": "u_along_m_per_s", "across_m_per_s": "u_across_m_per_s"}
        if len(cycles) > MOST_TABLES:
            count = min(len(values["cycle"]) for values in cycles.values())
            of_all = (
                np.mean([values[name][:count] for values in cycles.values()], axis=0) for name in columns.values()
            )
            cycles = {f"mean of {len(cycles)}": dict(zip(columns.values(), of_all))} if count else {}
        return [
            {"name": name, **{key: values[column].tolist() for key, column in columns.items()}}
            for name, values in cycles.items()
        ]


def runs_in(directory: Path) -> dict[str, Path]:
    """The run in a folder by the name «», or those in the folder of a campaign by the names of their folders."""
    if (directory / "case.yaml").is_file():
        return {"": directory}
    with os.scandir(directory) as entries:
        folders = sorted(entry.name for entry in entries if entry.is_dir())
    return {name: directory / name for name in folders if (directory / name / "case.yaml").is_file()}
