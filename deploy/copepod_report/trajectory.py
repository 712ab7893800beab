"""trajectory.csv as arrays."""

import csv
from pathlib import Path

import numpy as np

_VECTORS = {
    "position_m": ("x_m", "y_m", "z_m"),
    "velocity_m_per_s": ("vx_m_per_s", "vy_m_per_s", "vz_m_per_s"),
    "angular_velocity_rad_per_s": ("wx_rad_per_s", "wy_rad_per_s", "wz_rad_per_s"),
    "force_N": ("fx_N", "fy_N", "fz_N"),
    "torque_N_m": ("tx_N_m", "ty_N_m", "tz_N_m"),
    "driving_N": ("drive_fx_N", "drive_fy_N", "drive_fz_N"),
}


class Trajectory:
    """Samples of all bodies.

    steps               shape (samples,)
    time_s              shape (samples,)
    of(body)            dictionary of arrays, shape (samples, 3): its values by quantity
    """

    def __init__(self, path: Path) -> None:
        """Reads the file; an incomplete last sample (of a run that was killed) is left out.

        Raises ValueError or KeyError if it does not hold such a table with at least one sample.
        """
        with open(path, newline="") as file:
            rows = csv.reader(file)
            header: list[str] = next(rows, [])
            complete = [row for row in rows if len(row) == len(header)]
        column = {name: number for number, name in enumerate(header)}
        self.bodies = list(dict.fromkeys(row[column["body"]] for row in complete))
        samples = len(complete) // max(len(self.bodies), 1)
        if samples == 0:
            raise ValueError("it holds no sample")
        complete = complete[: samples * len(self.bodies)]
        names = ["step", "time_s", *(name for columns in _VECTORS.values() for name in columns)]
        places = [column[name] for name in names]
        values = np.array([[float(row[place]) for place in places] for row in complete])
        values = values.reshape(samples, len(self.bodies), len(names))
        self.steps = values[:, 0, 0].astype(np.int64)
        self.time_s = values[:, 0, 1]
        self._values = {
            vector: values[:, :, [names.index(name) for name in columns]] for vector, columns in _VECTORS.items()
        }

    def of(self, body: str) -> dict[str, np.ndarray]:
        number = self.bodies.index(body)
        return {vector: array[:, number] for vector, array in self._values.items()}

    def __len__(self) -> int:
        return len(self.steps)
