"""trajectory.csv and trajectory.npy as arrays, whole or as they grow. The only place that reads them."""

import csv
import itertools
import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

_QUANTITIES = {
    "time_s": ("time_s",),
    "position_m": ("x_m", "y_m", "z_m"),
    "orientation_wxyz": ("qw", "qx", "qy", "qz"),
    "velocity_m_per_s": ("vx_m_per_s", "vy_m_per_s", "vz_m_per_s"),
    "angular_velocity_rad_per_s": ("wx_rad_per_s", "wy_rad_per_s", "wz_rad_per_s"),
    "force_N": ("fx_N", "fy_N", "fz_N"),
    "torque_N_m": ("tx_N_m", "ty_N_m", "tz_N_m"),
    "driving_N": ("drive_fx_N", "drive_fy_N", "drive_fz_N"),
}
_FIELDS = {quantity: quantity for quantity in _QUANTITIES} | {"driving_N": "drive_N"}  # of trajectory.npy
_SUFFIX = ".npy"
_MOST_VALUES = 100_000_000  # of a quantity that is read whole for the sake of one body
_TRACE_BYTES = 64  # before our place in a file, to see whether it is still the same file

COLUMNS = tuple(itertools.chain(*_QUANTITIES.values()))  # beside step and body


def trajectory_in(directory: Path, name: str = "trajectory") -> Path:
    """The file of a run directory, whichever form it has; trajectory.csv if there is none yet."""
    compact = directory / f"{name}{_SUFFIX}"
    return compact if compact.is_file() else directory / f"{name}.csv"


class _Replaced(Exception):
    """The file has lost what was read of it: a resumed run cuts it at its checkpoint and writes on from there."""


class _Csv:
    """Numbers of the samples that the last look has found."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.bodies: list[str] = []
        self._header: list[str] = []
        self._rows: list[str] = []  # of a sample that is not complete
        self._offset = 0  # of what has not been read
        self._trace = b""
        self._values = np.empty((0, 1, 1 + len(COLUMNS)))

    def look(self, is_last: bool) -> np.ndarray:
        """Steps of the complete samples that are new. `is_last`: no more will come, so that what there is of the first
        sample is all of it."""
        rows = self._rows + self._new_lines()
        if not self._header and rows:
            self._header = next(csv.reader([rows.pop(0)]))
        if not self.bodies and rows:
            self.bodies = self._bodies_of_first_sample(rows, is_last)
        size = len(self.bodies) or 1
        whole = len(rows) // size * size if self.bodies else 0
        self._rows = rows[whole:]
        self._values = np.empty((0, size, 1 + len(COLUMNS)))
        if whole:
            places = [self._header.index(name) for name in ("step", *COLUMNS)]
            table = np.loadtxt(rows[:whole], delimiter=",", usecols=places, quotechar='"', comments=None, ndmin=2)
            self._values = table.reshape(-1, size, len(places))
        return self._values[:, 0, 0].astype(np.int64)

    def sample(self, number: int) -> np.ndarray:
        """All numbers of one of the samples that the last look has found."""
        return self._values[number, :, 1:]

    def read(self, quantity: str, samples: Any = slice(None), body: Any = slice(None)) -> np.ndarray:
        first = 1 + COLUMNS.index(_QUANTITIES[quantity][0])
        return self._values[samples, body, first : first + len(_QUANTITIES[quantity])]

    def _new_lines(self) -> list[str]:
        """Whole lines that have come since; a row may be half written."""
        with open(self.path, "rb") as file:
            file.seek(self._offset - len(self._trace))
            if file.read(len(self._trace)) != self._trace:
                raise _Replaced
            received = file.read()
        complete = received[: received.rfind(b"\n") + 1]
        self._offset += len(complete)
        self._trace = (self._trace + complete)[-_TRACE_BYTES:]
        return complete.decode(errors="replace").splitlines()

    def _bodies_of_first_sample(self, rows: list[str], is_complete: bool) -> list[str]:
        """Every sample repeats them. Empty while the first may be incomplete: until the next one has begun."""
        place = self._header.index("body")
        names: dict[str, None] = {}
        for row in csv.reader(rows):
            if row[place] in names:
                return list(names)
            names[row[place]] = None
        return list(names) if is_complete else []


class _Npy:
    """An array of samples; quantities are read once they are asked for, and the file may grow meanwhile. It is not
    mapped into memory: a run that is resumed cuts it, which would end this process."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.bodies: list[str] = []
        self._known = self._count = 0  # samples at the last look but one, and at the last one

    def look(self, is_last: bool) -> np.ndarray:
        with open(self.path, "rb") as file:
            np.lib.format.read_magic(file)
            (count,), _, self._type = np.lib.format.read_array_header_1_0(file)
            self._first = file.tell()
            count = min(count, (os.fstat(file.fileno()).st_size - self._first) // self._type.itemsize)
        if count < self._count:
            raise _Replaced
        if not self.bodies:
            self.bodies = self.path.with_name(f"{self.path.stem}_names.txt").read_text().splitlines()
        self._known, self._count = self._count, count
        return self._values("step", range(self._known, count))

    def sample(self, number: int) -> np.ndarray:
        return np.hstack([self.read(quantity, [self._known + number])[0] for quantity in _QUANTITIES])

    def read(self, quantity: str, samples: Any = None, body: Any = slice(None)) -> np.ndarray:
        values = self._values(_FIELDS[quantity], range(self._count) if samples is None else samples)
        if quantity == "time_s":  # one for all bodies
            values = np.broadcast_to(values[:, None, None], (len(values), len(self.bodies), 1))
        return values[:, body]

    def _values(self, field: str, samples: Iterable[int]) -> np.ndarray:
        """Of a field in these samples, shape (samples, …)."""
        kind, place = self._type.fields[field][:2]
        with open(self.path, "rb") as file:
            starts = (self._first + place + int(sample) * self._type.itemsize for sample in samples)
            content = b"".join(os.pread(file.fileno(), kind.itemsize, start) for start in starts)
        return np.frombuffer(content, kind.base).reshape(-1, *kind.shape)


def _form_of(path: Path) -> _Csv | _Npy:
    return _Npy(path) if path.suffix == _SUFFIX else _Csv(path)


class Trajectory:
    """Samples of all bodies.

    steps               shape (samples,)
    time_s              shape (samples,)
    of(body)            mapping from quantities to arrays, shape (samples, 3); orientations (samples, 4)
    all_of(quantity)    the same of all bodies, shape (samples, bodies, 3)
    """

    def __init__(self, path: Path, may_be_empty: bool = False) -> None:
        """Reads the file, or that of a run directory; an incomplete last sample (of a run that was killed, or
        continues) is left out. Of trajectory.npy it reads a quantity once it is asked for.

        Raises OSError, ValueError or KeyError if it does not hold such a table, with at least one sample unless
        `may_be_empty`.
        """
        path = trajectory_in(path) if path.is_dir() else path
        self.directory = path.parent
        self._form = _form_of(path)
        self.steps = self.time_s = np.empty(0, np.int64)
        if path.exists() or not may_be_empty:
            self.steps = self._form.look(is_last=True)
            self.time_s = self._form.read("time_s")[:, 0, 0] if len(self) else self.time_s
        self.bodies = self._form.bodies
        self._values: dict[str, np.ndarray] = {}
        if len(self) == 0 and not may_be_empty:
            raise ValueError("it holds no sample")

    def of(self, body: str) -> Mapping[str, np.ndarray]:
        return _OfBody(self, self.bodies.index(body))

    def all_of(self, quantity: str) -> np.ndarray:
        if quantity not in self._values:
            self._values[quantity] = self._form.read(quantity)
        return self._values[quantity]

    def some_of(self, quantity: str, samples: np.ndarray) -> np.ndarray:
        """The same in some samples only, given by their numbers, which ascend."""
        return self._values[quantity][samples] if quantity in self._values else self._form.read(quantity, samples)

    def columns(self) -> np.ndarray:
        """All numbers, in the order of `COLUMNS`, shape (bodies, samples, columns)."""
        parts = map(self._form.read, _QUANTITIES) if len(self) else [np.empty((0, 0, len(COLUMNS)))]
        return np.concatenate(list(parts), axis=2).swapaxes(0, 1)

    def __len__(self) -> int:
        return len(self.steps)


class _OfBody(dict[str, np.ndarray]):
    """The values of one body by quantity, read once they are asked for."""

    def __init__(self, trajectory: Trajectory, number: int) -> None:
        self._trajectory = trajectory
        self._number = number

    def __missing__(self, quantity: str) -> np.ndarray:
        whole, number = self._trajectory, self._number
        is_large = len(whole) * len(whole.bodies) * len(_QUANTITIES[quantity]) > _MOST_VALUES
        if is_large and quantity not in whole._values:
            return whole._form.read(quantity, body=number)
        return whole.all_of(quantity)[:, number]


class GrowingTrajectory:
    """The trajectory of a run that may continue: each look takes the samples that are new.

    A run that is resumed shortens the file first: then it is read anew.
    """

    def __init__(self, directory: Path) -> None:
        self._directory = directory
        self.start_again()

    def start_again(self) -> None:
        """Forgets what has been read."""
        self._form = _form_of(trajectory_in(self._directory))
        self.count = 0  # complete samples so far

    @property
    def bodies(self) -> list[str]:
        return self._form.bodies

    def look(self, is_last: bool = False) -> Iterator[tuple[int, Callable[[], np.ndarray]]]:
        """Steps of the new samples; each with what reads the values of all bodies, shape (bodies, columns) as
        `COLUMNS`, until the next look. `is_last`: no more will come, so that what there is of the first is all of it.

        Raises ValueError or LookupError if the file is not such a table; the next look begins anew.
        """
        if self._form.path != (path := trajectory_in(self._directory)):  # there was none at the last look
            self._form = _form_of(path)
        try:
            try:
                steps = self._form.look(is_last)
            except _Replaced:
                self.start_again()
                steps = self._form.look(is_last)
        except FileNotFoundError:  # not there yet
            return
        except (ValueError, LookupError):  # not such a table, or another file that begins in the same way
            self.start_again()
            raise
        for number, step in enumerate(steps):
            self.count += 1
            yield int(step), partial(self._form.sample, number)


def chosen_samples(count: int, most: int) -> np.ndarray:
    """Numbers of at most `most` samples at equal distances, and of the last one."""
    chosen = np.arange(0, count, max(1, math.ceil(count / most)))
    return np.append(chosen, count - 1) if count and chosen[-1] != count - 1 else chosen
