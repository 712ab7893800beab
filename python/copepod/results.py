"""Results of runs and campaigns as tables, fields and samples, also while a run continues."""

import functools
import json
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from copepod.case import Case
from copepod.errors import Error, required, stops_as_errors
from copepod_report.run_status import state_of
from copepod_report.trajectory import COLUMNS, GrowingTrajectory, Trajectory, trajectory_in
from copepod_run import build
from copepod_run.figures import result_table
from copepod_run.plan import plan_of

if TYPE_CHECKING:
    import pandas
    import xarray

_LOOK_EVERY_S = 0.2  # at a run that continues


def load(directory: str | Path) -> Any:
    """A `Run` from its run directory, finished or not; a `Campaign` from the folder of a sweep or campaign.

    Nothing is read before it is asked for.

    @throws Error if the folder holds neither
    """
    path = Path(directory)
    if (path / "results.json").exists():
        return Campaign(path)
    if not (path / "case.yaml").exists():
        raise Error(f"{path} is neither a run nor a campaign (no case.yaml, no results.json). Give a run directory.", 2)
    return Run(path)


class Run:
    """A run by its directory. Each property holds what was there when it was read first; `load` again to see more."""

    def __init__(self, directory: str | Path) -> None:
        self.directory = Path(directory)

    @property
    def status(self) -> str:
        """finished, running, stopped (by a signal), failed, or interrupted (ended without a record), at this moment."""
        return state_of(self.directory)[0]

    @functools.cached_property
    def summary(self) -> dict[str, Any]:
        """summary.json: speeds, arms, efficiency, Reynolds numbers, timing, digest; before the end, what is known.

        @throws Error if a file is damaged
        """
        if self.status == "finished":
            return dict(self._file("summary.json", lambda path: json.loads(path.read_text())))
        return dict(self._record.summary)

    @functools.cached_property
    def case(self) -> Case:
        """The resolved case with every default; it gives the same run."""
        return Case(self._record.case)

    @functools.cached_property
    def trajectory(self) -> "pandas.DataFrame":
        """Samples of every body, index (body, step), columns of trajectory.csv: time_s, x_m, …, drive_fz_N.

        Positions, velocities, orientation (quaternion w, x, y, z), load of the fluid, force of the drive, in the world;
        docs/conventions.md defines them. `run.trajectory.loc["swimmer.B1"]` is one body's.
        """
        return self._samples(trajectory_in(self.directory).name)

    @functools.cached_property
    def obstacles(self) -> "pandas.DataFrame":
        """Loads on the obstacles that have `loads: true`, in the form of `trajectory`; torques are about `position_m`.

        @throws Error if the case has none
        """
        return self._samples(trajectory_in(self.directory, "obstacles").name)

    @functools.cached_property
    def flow(self) -> "pandas.DataFrame":
        """Samples of `output.flow`, index step, columns of flow.csv: totals, probes and faces.

        @throws Error if the case has none
        """
        read_csv = required("pandas").read_csv
        return self._file("flow.csv", lambda path: read_csv(path, index_col="step", float_precision="round_trip"))

    def _samples(self, name: str) -> "pandas.DataFrame":
        pandas = required("pandas")
        table = self._file(name, lambda path: Trajectory(path, may_be_empty=True))
        index = pandas.MultiIndex.from_product([table.bodies, table.steps], names=["body", "step"])
        return pandas.DataFrame(table.columns().reshape(len(index), len(COLUMNS)), index, COLUMNS)

    @functools.cached_property
    def cycles(self) -> "pandas.DataFrame":
        """Every full cycle of every swimmer, index (swimmer, cycle), columns of cycles.csv; empty without a drive."""
        pandas = required("pandas")
        from copepod_report.cycles import read_cycles

        tables = {name: pandas.DataFrame(columns) for name, columns in self._file("cycles.csv", read_cycles).items()}
        if not tables:
            return pandas.DataFrame()
        table = pandas.concat(tables, names=["swimmer"]).reset_index("swimmer")
        return table.astype({"cycle": int, "start_step": int}).set_index(["swimmer", "cycle"])

    @property
    def fields(self) -> "xarray.Dataset":
        """Snapshots of the fluid, dimensions (time, z, y, x[, component]), coordinates in s and m (cell centres).

        Values are read when they are used, a slice at a time; units are in `attrs["units"]`.

        @throws Error if the run has written none (output.fields.every_steps)
        """
        from copepod.fields import snapshots

        return snapshots(self.directory)

    @property
    def mean_fields(self) -> "xarray.Dataset":
        """Mean over a window of steps, like `fields` without the time.

        @throws Error without output.fields.mean_over_steps
        """
        from copepod.fields import mean

        return mean(self.directory)

    def __str__(self) -> str:
        return result_table(self.summary, self.directory)

    def __repr__(self) -> str:
        return f"<copepod.Run {self.directory}, {self.status}>"

    def _file(self, name: str, reader: Callable[[Path], Any]) -> Any:
        from copepod_report.run_record import read_file

        with stops_as_errors():
            return read_file(self.directory / name, reader)

    @functools.cached_property
    def _record(self) -> Any:
        from copepod_report.run_record import RunRecord  # loads matplotlib

        with stops_as_errors():
            build.ensure_programs()  # the coupler reads the case
            return RunRecord(self.directory, lambda path: plan_of(path).case)


class Campaign(Sequence[Run]):
    """The runs of a sweep or campaign by their number, and their results as a table."""

    def __init__(self, directory: str | Path) -> None:
        self.directory = Path(directory)

    @functools.cached_property
    def results(self) -> "pandas.DataFrame":
        """results.csv: a row for each swimmer of each run, the swept keys and the figures as columns.

        Names are texts even if they look like numbers or missing values.
        """
        texts = dict.fromkeys(("case", "swimmer", "group", "state", "builds", "digest"), str)
        return required("pandas").read_csv(
            self.directory / "results.csv", dtype=texts, keep_default_na=False, na_values=[""]
        )

    @functools.cached_property
    def names(self) -> list[str]:
        """Of the runs that have begun."""
        cases = json.loads((self.directory / "results.json").read_text())["cases"]
        return [case["name"] for case in cases if (self.directory / case["name"] / "case.yaml").exists()]

    def __getitem__(self, number: Any) -> Any:
        if isinstance(number, slice):
            return [self[place] for place in range(len(self))[number]]
        return Run(self.directory / self.names[number])

    def __len__(self) -> int:
        return len(self.names)

    def __repr__(self) -> str:
        return f"<copepod.Campaign {self.directory}, {len(self)} runs>"


@dataclass(frozen=True)
class Sample:
    """All bodies at one step: `bodies` has the columns of `Run.trajectory`, indexed by body."""

    step: int  #: coupling step
    time_s: float  #: since step 0
    bodies: "pandas.DataFrame"  #: a row for each body


def follow(run: Run | str | Path, wait_s: float = 10.0) -> Iterator[Sample]:
    """The samples of a run, those so far at once and the others as they come, until it ends; it may have ended already.

    Reading a run does not disturb it. Samples reach the disk within about a second; output.trajectory.every_steps
    decides how many there are.

    @param wait_s  longest time to wait for a run that is about to start
    @throws Error if there is no such run
    """
    directory = run.directory if isinstance(run, Run) else Path(run)
    deadline_s = time.monotonic() + wait_s
    begun = (directory / "case.yaml", directory / "results.json")  # a run, a campaign
    while not any(path.exists() for path in begun) and time.monotonic() < deadline_s:
        time.sleep(_LOOK_EVERY_S)
    if not isinstance(found := load(directory), Run):
        raise Error(
            f"{found.directory} is a campaign (its runs have trajectories of their own). Follow one of them.", 2
        )
    reader = TrajectoryReader(found.directory)
    while found.status == "running":
        yield from reader.read()
        time.sleep(_LOOK_EVERY_S)
    yield from reader.read(is_last=True)


class TrajectoryReader:
    """Reads a trajectory that grows, each sample once."""

    def __init__(self, directory: Path) -> None:
        self._trajectory = GrowingTrajectory(directory)
        self._last_step = -1

    def read(self, is_last: bool = False) -> Iterator[Sample]:
        """New samples, each made when it is asked for.

        A run that is resumed computes some again, with the same numbers: they are left out.
        """
        pandas = required("pandas")
        for step, values in self._trajectory.look(is_last):
            if step <= self._last_step:
                continue
            self._last_step = step
            bodies = pandas.DataFrame(values(), pandas.Index(self._trajectory.bodies, name="body"), COLUMNS)
            yield Sample(step, bodies["time_s"].iloc[0], bodies)
