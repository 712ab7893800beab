"""What the broken components are made of: the component kit of Python and two plain solvers without any other fault."""

import hashlib
import pathlib
import zipfile

import numpy as np

from copepod_component import Capabilities, Kinematics, StorageError, Summary

FLUID = Capabilities("Broken fluid", "1.0", ["solver:external", "shape:sphere", "checkpoint"])
BODY = Capabilities("Broken bodies", "1.0", ["motion:free", "shape:sphere", "checkpoint", "neglects:torques"])


class Drag:
    """F = −v, T = −ω in units of 1 N s/m and 1 N m s."""

    def __init__(self, setup, context):
        self.steps = 0

    def exchange(self, kinematics):
        return -kinematics.velocity_m_per_s, -kinematics.angular_velocity_rad_per_s

    def advance(self):
        self.steps += 1

    def save(self, path):
        try:
            pathlib.Path(path).write_text(f"{self.steps} steps\n")
        except OSError as error:
            raise StorageError(f"The file {path} cannot be written ({error}). Choose another one.") from error

    def restore(self, path):
        try:
            self.steps = int(pathlib.Path(path).read_text().split()[0])
        except (OSError, ValueError, IndexError) as error:
            raise StorageError(f"The file {path} cannot be read ({error}). Choose another one.") from error

    def summarise(self):
        return Summary(digest=self.steps)


class Masses:
    """Point masses, v(n+1) = v(n) + h F/m."""

    def __init__(self, setup, context):
        self.step_s = setup.step_s
        self.mass_kg = np.array([body.mass_kg for body in setup.bodies])[:, None]
        self.state = Kinematics(
            0,
            *(
                np.array([list(getattr(body, name)) for body in setup.bodies])
                for name in ("position_m", "orientation_wxyz", "velocity_m_per_s", "angular_velocity_rad_per_s")
            ),
        )

    def driving_nodes(self):
        return [0.0]

    def kinematics(self):
        return self.state

    def step(self, applied):
        state = self.state
        force_N = applied.force_N + self.drive_N(applied)
        state.velocity_m_per_s = state.velocity_m_per_s + self.step_s * force_N / self.mass_kg
        state.position_m = state.position_m + self.step_s * state.velocity_m_per_s
        state.step = applied.step + 1
        return state

    def drive_N(self, applied):
        """Forces of actuators and bends, which only some of the broken components have."""
        return 0.0

    def save(self, path):
        try:
            with open(path, "wb") as file:
                np.savez(file, step=self.state.step, x=self.state.position_m, v=self.state.velocity_m_per_s)
        except OSError as error:
            raise StorageError(f"The file {path} cannot be written ({error}). Choose another one.") from error

    def restore(self, path):
        try:
            with np.load(path) as saved:
                self.state.step, self.state.position_m, self.state.velocity_m_per_s = (
                    int(saved["step"]),
                    saved["x"],
                    saved["v"],
                )
        except (OSError, EOFError, ValueError, zipfile.BadZipFile) as error:
            raise StorageError(f"The file {path} cannot be read ({error}). Choose another one.") from error

    def summarise(self):
        bits = self.state.position_m.tobytes() + self.state.velocity_m_per_s.tobytes()
        return Summary(digest=int.from_bytes(hashlib.sha256(bits).digest()[:8], "little"))
