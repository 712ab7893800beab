"""trajectory.csv as arrays."""

import csv
import io
import itertools
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

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


class Trajectory:
    """Samples of all bodies.

    steps               shape (samples,)
    time_s              shape (samples,)
    of(body)            mapping from quantities to arrays, shape (samples, 3); orientations (samples, 4)
    all_of(quantity)    the same of all bodies, shape (samples, bodies, 3)
    names               of all columns of the file
    """

    def __init__(self, path: Path, may_be_empty: bool = False) -> None:
        """Reads the file; an incomplete last sample (of a run that was killed, or continues) is left out.

        Raises ValueError or KeyError if it does not hold such a table, with at least one sample unless `may_be_empty`.
        """
        text = path.read_text() if path.exists() or not may_be_empty else ""
        self._text = text[: text.rfind("\n") + 1]  # a row may be half written
        header: list[str] = next(csv.reader(io.StringIO(self._text[: self._text.find("\n") + 1])), [])
        self._column = {name: number for number, name in enumerate(header)}
        self.names = header
        self.bodies = _first_names(self._text, self._column["body"]) if header else []
        widths = [len(_VECTORS[quantity]) for quantity in _MOTION]
        columns = [column for quantity in _MOTION for column in _VECTORS[quantity]]
        values = self.columns(("step", "time_s", *columns))
        if len(values) == 0 and not may_be_empty:
            raise ValueError("it holds no sample")
        self.steps = values[:, :1, 0].ravel().astype(np.int64)
        self.time_s = values[:, :1, 1].ravel()
        parts = np.split(values[..., 2:], np.cumsum(widths)[:-1], axis=2)
        self._values: dict[str, np.ndarray] = dict(zip(_MOTION, parts))

    def of(self, body: str) -> Mapping[str, np.ndarray]:
        return _OfBody(self, self.bodies.index(body))

    def all_of(self, quantity: str) -> np.ndarray:
        if quantity not in self._values:
            self._values[quantity] = self.columns(_VECTORS[quantity])
        return self._values[quantity]

    def __len__(self) -> int:
        return len(self.steps)

    def columns(self, names: Sequence[str]) -> np.ndarray:
        """Columns, shape (samples, bodies, columns); a quantity is parsed when it is asked for."""
        if not self.bodies:
            return np.empty((0, 0, len(names)))
        places = [self._column[name] for name in names]
        rows = io.StringIO(self._text)
        values = np.loadtxt(rows, delimiter=",", skiprows=1, usecols=places, quotechar='"', comments=None, ndmin=2)
        samples = len(values) // len(self.bodies)
        return values[: samples * len(self.bodies)].reshape(samples, len(self.bodies), len(names))


class _OfBody(Mapping[str, np.ndarray]):
    """The values of one body by quantity."""

    def __init__(self, trajectory: Trajectory, number: int) -> None:
        self._trajectory = trajectory
        self._number = number

    def __getitem__(self, quantity: str) -> np.ndarray:
        return self._trajectory.all_of(quantity)[:, self._number]

    def __iter__(self) -> Iterator[str]:
        return iter(_VECTORS)

    def __len__(self) -> int:
        return len(_VECTORS)


def _first_names(text: str, column: int) -> list[str]:
    """The bodies of the first sample, which every sample repeats."""
    rows = itertools.islice(csv.reader(io.StringIO(text)), 1, None)
    names: dict[str, None] = {}
    for row in rows:
        if row[column] in names:
            break
        names[row[column]] = None
    return list(names)
