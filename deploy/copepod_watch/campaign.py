"""The runs of a campaign or sweep while they go on: how far each is, and the figure that grows with them."""

import re
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
from markupsafe import Markup

from copepod_report.cycles import read_cycles
from copepod_report.page import HTML
from copepod_report.run_record import Member, RunResult, Sweep, members_of
from copepod_report.run_status import RunStatus, state_of
from copepod_report.sweeps import axes_of
from copepod_run.figures import number_text
from copepod_run.progress import figures
from copepod_run.run_directory import read_object
from copepod_watch.follower import runs_in

_REDRAW_S = 3.0  # between two figures
_NUMBER = re.compile(r"(\d+(?:\.\d+)?(?:e[-+]?\d+)?)")

Draw = Callable[[Sequence[RunResult]], list[str]]


class CampaignFollower:
    """State, progress and last speed of every run of a folder, and the figures of those that have finished."""

    def __init__(self, directory: Path, draw: Draw, clock: Callable[[], float] = time.monotonic) -> None:
        """`draw(runs)`: HTML of the figures that show what has finished."""
        self._directory = directory
        self._draw = draw
        self._clock = clock
        self._next = 0.0
        self._version = ""
        self._figures = ""
        self._speeds: dict[Path, tuple[int, str]] = {}  # by table: when it was written, and what it said

    def content(self, known: str = "") -> dict[str, Any]:
        """What the page shows, as JSON; the figures only if they differ from the version that is `known`."""
        runs = [self._result(member) for member in _members(self._directory)]
        self._redraw([run for run in runs if run.summary])
        states = [run.status.state for run in runs]
        words = [f"{states.count('finished')} of {len(runs)} finished"]
        words += [f"{states.count(state)} {state}" for state in dict.fromkeys(states) if state != "finished"]
        return {
            "sentence": f"{', '.join(words)}.",
            "share": sum(_share(run.status) for run in runs) / max(len(runs), 1),
            "table": self._table(runs),
            "version": self._version,
            "figures": self._figures if self._version != known else None,
        }

    def _result(self, member: Member) -> RunResult:
        folder = self._directory / member.name
        state, reason = state_of(folder)
        if state == "interrupted" and not (folder / "case.yaml").is_file():
            state = "failed" if member.has_failed else "to do"
        summary = read_object(folder / "summary.json") if state == "finished" else {}
        event = summary or read_object(folder / "logs" / "progress.json")
        step = int(event.get("step") or 0)
        status = RunStatus(state, step, int(event.get("steps") or 0), reason)
        return RunResult(folder, member.name, member.sweep, status, summary)

    def _redraw(self, finished: Sequence[RunResult]) -> None:
        """Only when there is something new to see."""
        written = [(run.directory / "summary.json").stat().st_mtime_ns for run in finished]
        version = f"{len(written)}-{max(written, default=0)}"
        if version == self._version or self._clock() < self._next:
            return
        self._figures = "".join(self._draw(finished)) if len(finished) > 1 else ""
        self._version = version
        self._next = self._clock() + _REDRAW_S

    def _table(self, runs: Sequence[RunResult]) -> str:
        swept = axes_of(runs).values()
        heads = ["run", "state", "progress", "speed in last cycle [µm/s]", *(axis.label for axis in swept)]
        rows = []
        for number, run in enumerate(runs):
            name: str = run.name
            if (run.directory / "case.yaml").is_file():
                name = Markup('<a href="{}/">{}</a>').format(quote(run.name), run.name)
            event = read_object(run.directory / "logs" / "progress.json") if run.status.state == "running" else {}
            left = figures(event, 0)[:1] if event.get("steps_per_s") else []
            share = _share(run.status)
            bar = Markup('<progress value="{:.3f}"></progress> {:.0f} %').format(share, 100 * share)
            parameters = [axis.number(axis.places[number]) for axis in swept]
            speed = self._speed(run.directory / "cycles.csv")
            rows.append([name, run.status.state, (bar, *left), speed, *parameters])
        return str(HTML.table(heads, rows, "dense"))

    def _speed(self, path: Path) -> str:
        """Along the own axis in the last cycle, the mean of several swimmers; empty before the first."""
        written = path.stat().st_mtime_ns if path.is_file() else 0
        if written != self._speeds.get(path, (0, ""))[0]:
            last = [values["u_along_m_per_s"][-1] for values in read_cycles(path).values()]
            self._speeds[path] = written, number_text(1e6 * float(np.mean(last))) if last else ""
        return self._speeds.get(path, (0, ""))[1]


def _share(status: RunStatus) -> float:
    return 1.0 if status.is_finished else min(1.0, status.step / max(status.steps, 1))


def _members(directory: Path) -> list[Member]:
    """In the order of the campaign; of a folder that is not one, by name, numbers in it by value."""
    if (directory / "results.json").is_file():
        return members_of(directory)
    names = sorted(runs_in(directory), key=_with_numbers)
    return [Member(name, Sweep(), has_begun=True, has_failed=False) for name in names]


def _with_numbers(name: str) -> list[Any]:
    return [float(part) if place % 2 else part for place, part in enumerate(_NUMBER.split(name))]
