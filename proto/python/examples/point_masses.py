#!/usr/bin/env python3
"""A body component in Python: point masses on springs, semi-implicit Euler.

    v(n+1) = v(n) + (F + F_drive + F_spring) h / m,   x(n+1) = x(n) + h v(n+1)
    F_spring on A = (k (|d| - l0) + c d'.e) e,   d = x_B - x_A,  e = d/|d|,  d' = v_B - v_A

First order in the step h: off by half the distance of a step. Spheres of motion `free` only; torques, anchors away from
the centre and gravity are refused, contacts are ignored. Run a case with it:
    deploy/copepod run CASE.yaml --body "python3 proto/python/examples/point_masses.py"
"""

import hashlib
import sys
import zipfile

import numpy as np

from copepod_component import (
    Capabilities,
    Kinematics,
    SolverError,
    StorageError,
    Summary,
    run_body_component,
)


class Springs:
    """All springs of a case at once; arrays have one row per spring."""

    def __init__(self, springs):
        if any(any(spring.anchor_A_m) or any(spring.anchor_B_m) for spring in springs):
            raise SolverError(
                "A spring is not attached to the centre of its body (a point mass has nothing else). "
                "Use the body service of Copepod."
            )
        self._body_A = np.array([spring.body_A for spring in springs], dtype=int)
        self._body_B = np.array([spring.body_B for spring in springs], dtype=int)
        self._stiffness_N_per_m = np.array([spring.stiffness_N_per_m for spring in springs])
        self._damping_N_s_per_m = np.array([spring.damping_N_s_per_m for spring in springs])
        self._rest_length_m = np.array([spring.rest_length_m for spring in springs])

    def add_forces(self, position_m, velocity_m_per_s, force_N):
        """Adds the force of every spring to both of its bodies; arrays (bodies, 3)."""
        between_m = position_m[self._body_B] - position_m[self._body_A]
        length_m = np.sqrt((between_m**2).sum(axis=1))
        if not length_m.all():
            raise SolverError("The ends of a spring coincide (its force has no direction). Start its ends apart.")
        direction = between_m / length_m[:, None]
        stretching_m_per_s = ((velocity_m_per_s[self._body_B] - velocity_m_per_s[self._body_A]) * direction).sum(axis=1)
        tension_N = (
            self._stiffness_N_per_m * (length_m - self._rest_length_m) + self._damping_N_s_per_m * stretching_m_per_s
        )
        on_A_N = tension_N[:, None] * direction
        np.add.at(force_N, self._body_A, on_A_N)
        np.subtract.at(force_N, self._body_B, on_A_N)


class PointMasses:
    def __init__(self, setup, context):
        if any(setup.gravity_m_per_s2):
            raise SolverError(
                "The case has gravity (which these point masses neglect). Use the body service of Copepod."
            )
        self._springs = Springs(setup.springs)
        self._step_s = setup.step_s
        self._mass_kg = np.array([body.mass_kg for body in setup.bodies])[:, None]
        self._state = Kinematics(
            0,
            np.array([body.position_m for body in setup.bodies]),
            np.array([body.orientation_wxyz for body in setup.bodies]),
            np.array([body.velocity_m_per_s for body in setup.bodies]),
            np.array([body.angular_velocity_rad_per_s for body in setup.bodies]),
        )

    def driving_nodes(self):
        return [0.0]

    def kinematics(self):
        return self._state

    def step(self, applied):
        force_N = applied.force_N + applied.driving_N[0]
        self._springs.add_forces(self._state.position_m, self._state.velocity_m_per_s, force_N)
        self._state.velocity_m_per_s = self._state.velocity_m_per_s + self._step_s * force_N / self._mass_kg
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
    sys.exit(
        run_body_component(
            PointMasses,
            Capabilities(
                "Point masses in Python",
                "1.0",
                ["motion:free", "shape:sphere", "springs", "checkpoint", "neglects:torques", "neglects:periodic"],
            ),
        )
    )
