"""trajectory.csv and trajectory.h5 as arrays. The only place that reads them."""

import csv
import functools
import io
import itertools
import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

_VECTORS = {
    "position_m": ("x_m", "y_m", "z_m"),
    "orientation_wxyz": ("qw", "qx", "qy", "qz"),
    "velocity_m_per_s": ("vx_m_per_s", "vy_m_per_s", "vz_m_per_s"),
    "angular_velocity_rad_per_s": ("wx_rad_per_s", "wy_rad_per_s", "wz_rad_per_s"),
    "force_N": ("fx_N", "fy_N", "fz_N"),
    "torque_N_m": ("tx_N_m", "ty_N_m", "tz_N_m"),
    "driving_N": ("drive_fx_N", "drive_fy_N", "drive_fz_N"),
}
_MOTION = ("position_m", "orientation_wxyz", "velocity_m_per_s", "driving_N")  # what a report draws: one pass for all
_DATASETS = {quantity: quantity for quantity in _VECTORS} | {"driving_N": "drive_N"}  # of trajectory.h5
_SUFFIX = ".h5"
_MOST_VALUES = 100_000_000  # of a quantity that is read whole for the sake of one body
_TRACE_BYTES = 64  # before our place in a file, to see whether it is still the same file

COLUMNS = ("time_s", *itertools.chain(*_VECTORS.values()))  # beside step and body


def trajectory_in(directory: Path) -> Path:
    """The file of a run directory, whichever form it has; trajectory.csv if there is none yet."""
    compact = directory / f"trajectory{_SUFFIX}"
    return compact if compact.is_file() else directory / "trajectory.csv"


class Trajectory:
    """Samples of all bodies.

    steps               shape (samples,)
    time_s              shape (samples,)
    of(body)            mapping from quantities to arrays, shape (samples, 3); orientations (samples, 4)
    all_of(quantity)    the same of all bodies, shape (samples, bodies, 3)
    """

    def __init__(self, path: Path, may_be_empty: bool = False) -> None:
        """Reads the file, or that of a run directory; an incomplete last sample (of a run that was killed, or
        continues) is left out. Of trajectory.h5 it reads a quantity once it is asked for.

        Raises OSError, ValueError or KeyError if it does not hold such a table, with at least one sample unless
        `may_be_empty`.
        """
        path = trajectory_in(path) if path.is_dir() else path
        self._table: _CsvTable | _Hdf5Table
        self._table = _Hdf5Table(path) if path.suffix == _SUFFIX else _CsvTable(path, may_be_empty)
        self.bodies = self._table.bodies
        self._number = {body: number for number, body in enumerate(self.bodies)}
        self.steps, self.time_s = self._table.steps, self._table.time_s
        self._values: dict[str, np.ndarray] = {}
        if len(self) == 0 and not may_be_empty:
            raise ValueError("it holds no sample")

    def of(self, body: str) -> Mapping[str, np.ndarray]:
        return _OfBody(self, self._number[body])

    def all_of(self, quantity: str) -> np.ndarray:
        if quantity not in self._values:
            self._values[quantity] = self._table.quantity(quantity)
        return self._values[quantity]

    def some_of(self, quantity: str, samples: np.ndarray) -> np.ndarray:
        """The same in some samples only, given by their numbers, which ascend."""
        return self._values[quantity][samples] if quantity in self._values else self._table.some(quantity, samples)

    def of_one(self, quantity: str, number: int) -> np.ndarray:
        """The same of one body."""
        is_large = len(self) * len(self.bodies) * len(_VECTORS[quantity]) > _MOST_VALUES
        if is_large and quantity not in self._values:
            return self._table.one(quantity, number)
        return self.all_of(quantity)[:, number]

    def columns(self) -> np.ndarray:
        """All numbers, in the order of `COLUMNS`, shape (bodies, samples, columns)."""
        values = np.empty((len(self.bodies), len(self), len(COLUMNS)))
        values[..., 0] = self.time_s
        first = 1
        for quantity, names in _VECTORS.items():
            values[..., first : first + len(names)] = self._table.quantity(quantity).swapaxes(0, 1)
            first += len(names)
        return values

    def __len__(self) -> int:
        return len(self.steps)


class _OfBody(Mapping[str, np.ndarray]):
    """The values of one body by quantity."""

    def __init__(self, trajectory: Trajectory, number: int) -> None:
        self._trajectory = trajectory
        self._number = number

    def __getitem__(self, quantity: str) -> np.ndarray:
        return self._trajectory.of_one(quantity, self._number)

    def __iter__(self) -> Iterator[str]:
        return iter(_VECTORS)

    def __len__(self) -> int:
        return len(_VECTORS)


class _CsvTable:
    def __init__(self, path: Path, may_be_empty: bool) -> None:
        text = path.read_text() if path.exists() or not may_be_empty else ""
        self._text = text[: text.rfind("\n") + 1]  # a row may be half written
        header: list[str] = next(csv.reader(io.StringIO(self._text[: self._text.find("\n") + 1])), [])
        self._column = {name: number for number, name in enumerate(header)}
        self.bodies = _first_names(self._text, self._column["body"]) if header else []
        self._values: dict[str, np.ndarray] = {}
        times = self._parse(("step", "time_s"), _MOTION)
        self.steps = times[:, :1, 0].ravel().astype(np.int64)
        self.time_s = times[:, :1, 1].ravel()

    def quantity(self, quantity: str) -> np.ndarray:
        if quantity not in self._values:
            self._parse((), [other for other in _VECTORS if other not in self._values])
        return self._values[quantity]

    def some(self, quantity: str, samples: np.ndarray) -> np.ndarray:
        return self.quantity(quantity)[samples]

    def one(self, quantity: str, number: int) -> np.ndarray:
        return self.quantity(quantity)[:, number]

    def _parse(self, names: Sequence[str], quantities: Sequence[str]) -> np.ndarray:
        """Quantities, in one pass; returns other columns, shape (samples, bodies, columns)."""
        groups = [names, *(_VECTORS[quantity] for quantity in quantities)]
        places = [self._column[name] for name in itertools.chain(*groups)] if self.bodies else []
        values = np.empty((0, 0, sum(map(len, groups))))
        if self.bodies:
            rows = io.StringIO(self._text)
            table = np.loadtxt(rows, delimiter=",", skiprows=1, usecols=places, quotechar='"', comments=None, ndmin=2)
            samples = len(table) // len(self.bodies)
            values = table[: samples * len(self.bodies)].reshape(samples, len(self.bodies), len(places))
        others, *parts = np.split(values, np.cumsum([len(group) for group in groups])[:-1], axis=2)
        self._values |= dict(zip(quantities, parts))
        return others


def _first_names(text: str, column: int) -> list[str]:
    """The bodies of the first sample, which every sample repeats."""
    rows = itertools.islice(csv.reader(io.StringIO(text)), 1, None)
    names: dict[str, None] = {}
    for row in rows:
        if row[column] in names:
            break
        names[row[column]] = None
    return list(names)


class _Hdf5Table:
    """The samples that were there at first; the file may grow meanwhile."""

    def __init__(self, path: Path) -> None:
        self._path = path
        with _opened(path) as file:
            self.bodies = _names(file)
            self.steps = file["step"][:]
            self.time_s = file["time_s"][: len(self.steps)]

    def quantity(self, quantity: str) -> np.ndarray:
        with _opened(self._path) as file:
            return np.asarray(file[_DATASETS[quantity]][: len(self.steps)])

    def some(self, quantity: str, samples: np.ndarray) -> np.ndarray:
        with _opened(self._path) as file:
            values = file[_DATASETS[quantity]]
            return np.array([values[sample] for sample in samples]).reshape(-1, *values.shape[1:])

    def one(self, quantity: str, number: int) -> np.ndarray:
        with _opened(self._path) as file:
            return np.asarray(file[_DATASETS[quantity]][: len(self.steps), number])


def _opened(path: Path) -> Any:
    """A run that writes at this moment may have made the file longer than HDF5 found it a moment before."""
    import h5py  # which trajectory.csv does not need

    for _ in range(20):
        try:
            return h5py.File(path, "r", locking=False)
        except FileNotFoundError:
            raise
        except OSError:
            time.sleep(0.01)
    return h5py.File(path, "r", locking=False)


def _names(file: Any) -> list[str]:
    return [name.decode() for name in file["body"][:]]


@dataclass(frozen=True)
class NewSample:
    """A sample that has just come; `values` of all bodies, columns as `COLUMNS`, are read when they are asked for."""

    number: int
    step: int
    is_newest: bool
    _read: Callable[[], Any]

    def values(self) -> np.ndarray:
        """Shape (bodies, columns); only before the next sample is taken."""
        return np.asarray(self._read())


class GrowingTrajectory:
    """The trajectory of a run that may continue: each look takes the samples that are new.

    A run that is resumed shortens the file first: then it is read anew, and `restarts` counts that.
    """

    def __init__(self, directory: Path) -> None:
        self._directory = directory
        self.restarts = -1
        self._start_again()

    def _start_again(self) -> None:
        self.restarts += 1
        self.bodies: list[str] = []
        self.count = 0  # complete samples so far
        self._offset = 0  # the others: of trajectory.csv
        self._trace = b""
        self._rest: list[str] = []  # rows of the sample that is not complete
        self._columns: dict[str, int] = {}

    def look(self, is_last: bool = False) -> Iterator[NewSample]:
        """New samples. `is_last`: no more will come, so that what there is of the first is all of it.

        Raises ValueError or LookupError if the file is not such a table; the next look begins anew.
        """
        path = trajectory_in(self._directory)
        try:
            yield from self._of_hdf5(path) if path.suffix == _SUFFIX else self._of_csv(path, is_last)
        except FileNotFoundError:  # not there yet
            return
        except (ValueError, LookupError):  # not such a table, or another file that begins in the same way
            self._start_again()
            raise

    def _of_hdf5(self, path: Path) -> Iterator[NewSample]:
        with _opened(path) as file:
            steps = file["step"][:]
            if len(steps) < self.count:
                self._start_again()
            self.bodies = self.bodies or _names(file)
            for number in range(self.count, len(steps)):
                self.count += 1
                read = functools.partial(_values_of, file, number)
                yield NewSample(number, int(steps[number]), number == len(steps) - 1, read)

    def _of_csv(self, path: Path, is_last: bool) -> Iterator[NewSample]:
        lines = self._new_lines(path)
        if not self._columns and lines:
            self._columns = {name: number for number, name in enumerate(next(csv.reader(lines[:1])))}
            lines = lines[1:]
        rows = self._rest + lines
        if not self.bodies and rows:
            self.bodies = self._bodies_of_first_sample(rows, is_last)
        size = len(self.bodies)
        whole = len(rows) // size * size if size else 0
        self._rest = rows[whole:]
        for start in range(0, whole, max(size, 1)):
            self.count += 1
            sample = rows[start : start + size]
            step = int(next(csv.reader(sample[:1]))[self._columns["step"]])
            yield NewSample(self.count - 1, step, start + size == whole, functools.partial(self._parsed, sample))

    def _parsed(self, rows: Sequence[str]) -> list[list[float]]:
        places = [self._columns[name] for name in COLUMNS]
        return [[float(row[place]) for place in places] for row in csv.reader(rows)]

    def _new_lines(self, path: Path) -> list[str]:
        """Whole lines that have come since."""
        with open(path, "rb") as file:
            file.seek(self._offset - len(self._trace))
            if file.read(len(self._trace)) != self._trace:
                self._start_again()
            file.seek(self._offset)
            received = file.read()
        complete = received[: received.rfind(b"\n") + 1]
        self._offset += len(complete)
        self._trace = (self._trace + complete)[-_TRACE_BYTES:]
        return complete.decode(errors="replace").splitlines()

    def _bodies_of_first_sample(self, rows: Sequence[str], is_complete: bool) -> list[str]:
        """Empty while the first sample may be incomplete: until the next one has begun or the run has ended."""
        names: list[str] = []
        for row in csv.reader(rows):
            if row[self._columns["body"]] in names:
                return names
            names.append(row[self._columns["body"]])
        return names if is_complete else []


def _values_of(file: Any, number: int) -> np.ndarray:
    time_s = np.full((len(file["body"]), 1), file["time_s"][number])
    return np.hstack([time_s, *(file[_DATASETS[quantity]][number] for quantity in _VECTORS)])


def chosen_samples(count: int, most: int) -> np.ndarray:
    """Numbers of at most `most` samples at equal distances, and of the last one."""
    chosen = np.arange(0, count, max(1, math.ceil(count / most)))
    return np.append(chosen, count - 1) if count and chosen[-1] != count - 1 else chosen
