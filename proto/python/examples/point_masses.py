#!/usr/bin/env python3
"""A body component in Python: point masses under hydrodynamic and driving forces, semi-implicit Euler.

    v(n+1) = v(n) + (F + F_drive) h / m,   x(n+1) = x(n) + h v(n+1)

Bodies of motion `free` only; springs, torques and contacts are neglected. Run a case with it:
    deploy/copepod run CASE.yaml --body "python3 proto/python/examples/point_masses.py"
"""

import hashlib
import pathlib
import sys
import zipfile

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from copepod_component import (Capabilities, Kinematics, SolverError, StorageError, Summary,  # noqa: E402
                               run_body_component)


class PointMasses:
    def __init__(self, setup):
        if setup.springs:
            raise SolverError("The case has springs (these bodies know none). Use the body service of Copepod.")
        self._step_s = setup.step_s
        self._mass_kg = np.array([body.mass_kg for body in setup.bodies])[:, None]
        self._state = Kinematics(
            0, np.array([body.position_m for body in setup.bodies]),
            np.array([body.orientation_wxyz for body in setup.bodies]),
            np.array([body.velocity_m_per_s for body in setup.bodies]),
            np.array([body.angular_velocity_rad_per_s for body in setup.bodies]))

    def driving_nodes(self):
        return [0.0]

    def kinematics(self):
        return self._state

    def step(self, applied):
        acceleration = (applied.force_N + applied.driving_N[0]) / self._mass_kg
        self._state.velocity_m_per_s = self._state.velocity_m_per_s + self._step_s * acceleration
        self._state.position_m = self._state.position_m + self._step_s * self._state.velocity_m_per_s
        self._state.step = applied.step + 1
        return self._state

    def save(self, path):
        try:
            with open(path, "wb") as file:
                np.savez(file, step=self._state.step, x=self._state.position_m, v=self._state.velocity_m_per_s)
        except OSError as error:
            raise StorageError(f"The file {path} cannot be written ({error.strerror}). Choose another path.") from error

    def restore(self, path):
        try:
            with np.load(path) as saved:
                self._state.step = int(saved["step"])
                self._state.position_m, self._state.velocity_m_per_s = saved["x"], saved["v"]
        except (OSError, EOFError, KeyError, ValueError, zipfile.BadZipFile) as error:
            raise StorageError(f"The file {path} cannot be read ({error}). Choose another checkpoint.") from error

    def summarise(self):
        bits = self._state.position_m.tobytes() + self._state.velocity_m_per_s.tobytes()
        return Summary(digest=int.from_bytes(hashlib.sha256(bits).digest()[:8], "little"))


if __name__ == "__main__":
    sys.exit(run_body_component(PointMasses, Capabilities(
        "Point masses in Python", "1.0", ["motion:free", "shape:sphere", "checkpoint", "neglects:torques"])))
