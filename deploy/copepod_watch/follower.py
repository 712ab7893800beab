"""What a run directory, or the folder of a campaign, holds: read again and again while the runs write it."""

import os
import re
from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
from markupsafe import Markup

from copepod_report.cycles import read_cycles
from copepod_report.page import HTML, templates
from copepod_report.run_record import RunResult, Sweep, members_of
from copepod_report.run_status import RunStatus, state_of, status_of
from copepod_report.scene import Samples, most_frames, scene_of
from copepod_report.sweeps import axes_of
from copepod_report.trajectory import GrowingTrajectory, chosen_samples
from copepod_run.figures import MOST_TABLES, number_text, quantity_text
from copepod_run.progress import figures
from copepod_run.run_directory import read_object

LIVE = templates(Path(__file__).with_name("live.html"))
_SHOWN = slice(0, 11)  # of the columns: time, position, orientation, velocity
_NUMBER = re.compile(r"(\d+(?:\.\d+)?(?:e[-+]?\d+)?)")
_HEADS = ("run", "state", "progress", "speed in last cycle [µm/s]")
Draw = Callable[[Sequence[RunResult]], list[str]]


class TrajectoryFollower(GrowingTrajectory):
    """The samples of a growing trajectory, thinned to what a view shows."""

    def start_again(self) -> None:
        super().start_again()
        self._every = 1
        self._kept: list[tuple[int, np.ndarray]] = []  # step and values, shape (bodies, columns), every `_every`-th
        self._newest: tuple[int, np.ndarray] | None = None

    def update(self) -> None:
        """Reads what the file has gained."""
        newest = None
        for newest in self.look():
            if (self.count - 1) % self._every == 0:
                self._kept.append((newest[0], newest[1]()[:, _SHOWN]))
            if len(self._kept) > 2 * most_frames(len(self.bodies)):
                self._kept = self._kept[::2]
                self._every *= 2
        if newest:
            self._newest = (newest[0], newest[1]()[:, _SHOWN])

    def samples(self) -> Samples | None:
        """What a view shows of all that is kept, and the newest; None before the first."""
        if self._newest is None:
            return None
        is_kept = self._newest[0] == self._kept[-1][0]
        steps, kept = zip(*self._kept, *([] if is_kept else [self._newest]))
        shown = chosen_samples(len(steps), most_frames(len(self.bodies)))
        values = np.array(kept)[shown]
        motion = (values[..., 1:4], values[..., 4:8], values[..., 8:11])
        return Samples(self.bodies, np.array(steps)[shown], values[:, 0, 0], *motion)


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
        status = status_of(self.directory, self.case, state, int(samples.steps[-1]) if samples else 0)
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

    def _speeds(self) -> str:
        """HTML of the velocity along and across the own axis of each swimmer, or of the mean of a swarm."""
        cycles = read_cycles(self.directory / "cycles.csv")
        speeds = {name: [values[f"u_{way}_m_per_s"] for way in ("along", "across")] for name, values in cycles.items()}
        if len(speeds) > MOST_TABLES:
            count = min(len(along) for along, _ in speeds.values())
            mean = np.mean([[values[:count] for values in both] for both in speeds.values()], axis=0)
            speeds = {f"mean of {len(speeds)}": list(mean)} if count else {}
        rows = [
            (name, *(quantity_text(values[-1], "m/s") for values in both), both[0].tolist())
            for name, both in speeds.items()
        ]
        return str(LIVE.speeds(rows))


def runs_in(directory: Path) -> dict[str, Path]:
    """The run in a folder by the name «», or those in the folder of a campaign by the names of their folders."""
    if (directory / "case.yaml").is_file():
        return {"": directory}
    with os.scandir(directory) as entries:
        folders = sorted(entry.name for entry in entries if entry.is_dir())
    return {name: directory / name for name in folders if (directory / name / "case.yaml").is_file()}


class CampaignFollower:
    """State, progress and last speed of every run of a folder, and the figures of those that have finished."""

    def __init__(self, directory: Path, draw: Draw) -> None:
        """`draw(runs)`: HTML of the figures that show what has finished."""
        self._directory = directory
        self._draw = draw
        self._version = ""
        self._figures = ""

    def content(self, known: str = "") -> dict[str, Any]:
        """What the page shows, as JSON; the figures only if they differ from the version that is `known`."""
        runs = self._results()
        finished = [run for run in runs if run.summary]
        newest = max(((run.directory / "summary.json").stat().st_mtime_ns for run in finished), default=0)
        if self._version != (version := f"{len(finished)}-{newest}"):
            self._figures = "".join(self._draw(finished)) if len(finished) > 1 else ""
            self._version = version
        states = [run.status.state for run in runs]
        others = (f", {states.count(state)} {state}" for state in dict.fromkeys(states) if state != "finished")
        return {
            "sentence": f"{states.count('finished')} of {len(runs)} finished{''.join(others)}.",
            "share": sum(map(_share, runs)) / max(len(runs), 1),
            "table": _table(runs),
            "version": version,
            "figures": self._figures if version != known else None,
        }

    def _results(self) -> list[RunResult]:
        """In the order of the campaign; of a folder that is not one, by name, numbers in it by value."""
        if (self._directory / "results.json").is_file():
            return [self._result(*member) for member in members_of(self._directory)]
        return [self._result(name, Sweep(), {}) for name in sorted(runs_in(self._directory), key=_with_numbers)]

    def _result(self, name: str, sweep: Sweep, case: dict[str, Any]) -> RunResult:
        folder = self._directory / name
        state, reason = state_of(folder)
        if state == "interrupted" and not (folder / "case.yaml").is_file():
            state = "failed" if case.get("state") == "failed" else "to do"
        summary = read_object(folder / "summary.json") if state == "finished" else {}
        event = summary or read_object(folder / "logs" / "progress.json")
        status = RunStatus(state, int(event.get("step") or 0), int(event.get("steps") or 0), reason)
        return RunResult(folder, name, sweep, status, summary)


def _table(runs: Sequence[RunResult]) -> str:
    swept, rows = axes_of(runs).values(), []
    for number, run in enumerate(runs):
        has_page, table = (run.directory / "case.yaml").is_file(), run.directory / "cycles.csv"
        name = Markup('<a href="{}/">{}</a>').format(quote(run.name), run.name) if has_page else run.name
        event = read_object(run.directory / "logs" / "progress.json") if run.status.state == "running" else {}
        left = figures(event, 0)[:1] if event.get("steps_per_s") else []
        bar = Markup('<progress value="{:.3f}"></progress> {:.0f} %').format(_share(run), 100 * _share(run))
        speed = _last_speed(table, table.stat().st_mtime_ns) if table.is_file() else ""
        parameters = (axis.number(axis.places[number]) for axis in swept)
        rows.append([name, run.status.state, (bar, *left), speed, *parameters])
    return str(HTML.table([*_HEADS, *(axis.label for axis in swept)], rows, "dense"))


@lru_cache(maxsize=10_000)
def _last_speed(table: Path, written_ns: int) -> str:
    """Along the own axis in the last cycle, the mean of several swimmers; empty before the first."""
    last = [1e6 * values["u_along_m_per_s"][-1] for values in read_cycles(table).values()]
    return number_text(float(np.mean(last))) if last else ""


def _share(run: RunResult) -> float:
    return 1.0 if run.status.is_finished else min(1.0, run.status.step / max(run.status.steps, 1))


def _with_numbers(name: str) -> list[Any]:
    return [float(part) if place % 2 else part for place, part in enumerate(_NUMBER.split(name))]
