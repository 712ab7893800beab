"""The runs of a campaign or sweep while they continue: how far each is, and the figure that grows with them."""

import re
from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
from markupsafe import Markup

from copepod_report.cycles import read_cycles
from copepod_report.page import HTML
from copepod_report.run_record import RunResult, Sweep, members_of
from copepod_report.run_status import RunStatus, state_of
from copepod_report.sweeps import axes_of
from copepod_run.figures import number_text
from copepod_run.progress import figures
from copepod_run.run_directory import read_object
from copepod_watch.follower import runs_in

_NUMBER = re.compile(r"(\d+(?:\.\d+)?(?:e[-+]?\d+)?)")
_HEADS = ("run", "state", "progress", "speed in last cycle [µm/s]")
Draw = Callable[[Sequence[RunResult]], list[str]]


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
        rows.append(
            [name, run.status.state, (bar, *left), speed, *(axis.number(axis.places[number]) for axis in swept)]
        )
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
