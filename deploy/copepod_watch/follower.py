"""What a run directory holds, read again and again while the run writes it."""

import csv
import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from copepod_report.cycles import read_cycles
from copepod_report.run_status import state_of, status_of
from copepod_report.scene import Samples, most_frames, scene_of
from copepod_run.figures import MOST_TABLES
from copepod_run.progress import figures

_COLUMNS = ("step", "time_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz", "vx_m_per_s", "vy_m_per_s", "vz_m_per_s")
_TRACE_BYTES = 64  # before our place in the file, to see whether it is still the same file


class TrajectoryFollower:
    """The samples of a growing trajectory.csv, thinned to what a view shows.

    Each update reads only what is new. A run that is resumed shortens the file first: then it is read anew.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._start_again()

    def _start_again(self) -> None:
        self._offset = 0
        self._trace = b""
        self._rest: list[str] = []  # rows of the sample that is not complete
        self._columns: list[int] = []
        self._name_column = 0
        self.bodies: list[str] = []
        self.count = 0  # complete samples in the file
        self._every = 1
        self._kept: list[np.ndarray] = []  # shape (bodies, columns), every `_every`-th
        self._newest: np.ndarray | None = None

    def update(self) -> None:
        """Reads what the file has gained; rows that are not complete wait for the next time."""
        try:
            with open(self._path, "rb") as file:
                if not self._is_same(file):
                    self._start_again()
                file.seek(self._offset)
                received = file.read()
        except OSError:  # not there yet
            return
        complete = received[: received.rfind(b"\n") + 1]
        self._offset += len(complete)
        self._trace = (self._trace + complete)[-_TRACE_BYTES:]
        try:
            self._take(complete.decode(errors="replace").splitlines())
        except (ValueError, LookupError):  # not such a table, or another file that begins in the same way
            self._start_again()
            raise

    def samples(self) -> Samples | None:
        """All that is kept, and the newest; None before the first."""
        if self._newest is None:
            return None
        kept = self._kept if self._newest is self._kept[-1] else [*self._kept, self._newest]
        values = np.array(kept)
        speed = np.linalg.norm(values[..., 9:12], axis=-1)
        steps, time_s = values[:, 0, 0].astype(np.int64), values[:, 0, 1]
        return Samples(self.bodies, steps, time_s, values[..., 2:5], values[..., 5:9], speed)

    def _is_same(self, file: Any) -> bool:
        file.seek(self._offset - len(self._trace))
        return file.read(len(self._trace)) == self._trace

    def _take(self, lines: list[str]) -> None:
        if not self._columns and lines:
            header = next(csv.reader(lines[:1]))
            self._columns = [header.index(name) for name in _COLUMNS]
            self._name_column = header.index("body")
            lines = lines[1:]
        rows = self._rest + lines
        if not self.bodies:
            self.bodies = self._bodies_of_first_sample(rows)
        if not self.bodies:
            self._rest = rows
            return
        size = len(self.bodies)
        whole = len(rows) // size * size
        for start in range(0, whole, size):
            self._add(rows[start : start + size], is_newest=start + size == whole)
        self._rest = rows[whole:]

    def _bodies_of_first_sample(self, rows: list[str]) -> list[str]:
        """Empty until the next sample has begun."""
        names: list[str] = []
        for row in csv.reader(rows):
            if row[self._name_column] in names:
                return names
            names.append(row[self._name_column])
        return []

    def _add(self, rows: list[str], is_newest: bool) -> None:
        is_kept = self.count % self._every == 0
        self.count += 1
        if not (is_kept or is_newest):
            return
        fields = list(csv.reader(rows))
        self._newest = np.array([[float(row[column]) for column in self._columns] for row in fields])
        if is_kept:
            self._kept.append(self._newest)
        if len(self._kept) > 2 * most_frames(len(self.bodies)):
            self._kept = self._kept[::2]
            self._every *= 2


class RunFollower:
    """State, progress, speeds and motion of one run."""

    def __init__(self, directory: Path, case: dict[str, Any], cells: int) -> None:
        """`case`: as the coupler resolves it; `cells`: of the lattice, 0 without one."""
        self.directory = directory
        self.case = case
        self.name: str = case.get("case") or directory.resolve().name
        self._cells = cells
        self._trajectory = TrajectoryFollower(directory / "trajectory.csv")

    def content(self, known: str = "") -> dict[str, Any]:
        """What the page shows, as JSON; the scene only if it differs from the version that is `known`."""
        state = state_of(self.directory)  # first: what a finished run wrote is then complete
        self._trajectory.update()
        samples = self._trajectory.samples()
        event = self.last_event()
        last = int(samples.steps[-1]) if samples else 0
        status = status_of(self.directory, self.case, state, max(last, event.get("step", 0)))
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

    def last_event(self) -> dict[str, Any]:
        """What the command recorded of the coupler's events; empty before the first, and for runs of old releases."""
        try:
            event = json.loads((self.directory / "logs" / "progress.json").read_text())
        except (OSError, ValueError):
            return {}
        return event if isinstance(event, dict) else {}

    def _speeds(self) -> list[dict[str, Any]]:
        """Velocity along and across the own axis [m/s] by cycle, of each swimmer, or the mean of a swarm."""
        cycles = read_cycles(self.directory / "cycles.csv")
        names = ("u_along_m_per_s", "u_across_m_per_s")
        if len(cycles) > MOST_TABLES:
            count = min(len(values["cycle"]) for values in cycles.values())
            means = [np.mean([values[name][:count] for values in cycles.values()], axis=0) for name in names]
            return [_speed(f"mean of {len(cycles)}", *means)] if count else []
        return [_speed(name, *(values[column] for column in names)) for name, values in cycles.items()]


def _speed(name: str, along: np.ndarray, across: np.ndarray) -> dict[str, Any]:
    return {"name": name, "along_m_per_s": along.tolist(), "across_m_per_s": across.tolist()}


def runs_in(directory: Path) -> dict[str, Path]:
    """The run in a folder by the name «», or those in the folder of a campaign by the names of their folders."""
    if (directory / "case.yaml").is_file():
        return {"": directory}
    with os.scandir(directory) as entries:
        folders = sorted(entry.name for entry in entries if entry.is_dir())
    return {name: directory / name for name in folders if (directory / name / "case.yaml").is_file()}
