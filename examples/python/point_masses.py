#!/usr/bin/env python3
"""A body component in Python: driven point masses on springs, semi-implicit Euler.

    v(n+1) = v(n) + (F + F_drive + F_spring) h / m,   x(n+1) = x(n) + h v(n+1)
    F_spring on A = (k (|d| - l0) + c d'.e) e,   d = x_B - x_A,  e = d/|d|,  d' = v_B - v_A
    F_drive = s e on B and -s e on A of a pair force, s a of a force in the direction a fixed in the world
    F_bend on A = k (angle - rest) t/|a|,   a = x_A - x_B,  t across a towards C; likewise on C; the opposite on B

First order in the step h: off by half the distance of a step. Spheres of motion `free` only; torques, anchors away from
the centre and gravity are refused, contacts are ignored. Run a case with it:
    deploy/copepod run CASE.yaml --body "python3 examples/python/point_masses.py"
"""

import hashlib
import sys

import numpy as np

from copepod_component import Capabilities, Kinematics, SolverError, Summary, run_body_component
from copepod_component.messages import setup as schema


def _length_m(vectors_m, what):
    """Of each row, shape (rows, 1)."""
    length_m = np.sqrt((vectors_m**2).sum(axis=1))
    if not length_m.all():
        raise SolverError(f"The ends of a {what} coincide (its force has no direction). Start its ends apart.")
    return length_m[:, None]


def _numbers(entries, name):
    return np.array([getattr(entry, name) for entry in entries], dtype=int)


def _require_centres(entries, what):
    if any(any(entry.anchor_A_m) or any(entry.anchor_B_m) for entry in entries):
        raise SolverError(
            f"A {what} is not attached to the centre of its body (a point mass has nothing else). "
            "Use the body service of Copepod."
        )


class Springs:
    """All springs of a case at once; arrays have one row per spring."""

    def __init__(self, springs):
        _require_centres(springs, "spring")
        self._body_A, self._body_B = _numbers(springs, "body_A"), _numbers(springs, "body_B")
        self._stiffness_N_per_m = np.array([spring.stiffness_N_per_m for spring in springs])
        self._damping_N_s_per_m = np.array([spring.damping_N_s_per_m for spring in springs])
        self._rest_length_m = np.array([spring.rest_length_m for spring in springs])

    def add_forces(self, position_m, velocity_m_per_s, force_N):
        """Adds the force of every spring to both of its bodies; arrays (bodies, 3)."""
        between_m = position_m[self._body_B] - position_m[self._body_A]
        length_m = _length_m(between_m, "spring")
        direction = between_m / length_m
        stretching_m_per_s = ((velocity_m_per_s[self._body_B] - velocity_m_per_s[self._body_A]) * direction).sum(axis=1)
        tension_N = (
            self._stiffness_N_per_m * (length_m[:, 0] - self._rest_length_m)
            + self._damping_N_s_per_m * stretching_m_per_s
        )
        on_A_N = tension_N[:, None] * direction
        np.add.at(force_N, self._body_A, on_A_N)
        np.subtract.at(force_N, self._body_B, on_A_N)


class Bends:
    """All bends of a case at once; arrays have one row per bend."""

    def __init__(self, bends):
        self._bodies = [_numbers(bends, name) for name in ("body_A", "body_B", "body_C")]
        self._stiffness_N_m = np.array([bend.stiffness_N_m_per_rad for bend in bends])[:, None]
        self._rest_rad = np.array([bend.rest_angle_rad for bend in bends])[:, None]

    def add_forces(self, position_m, force_N):
        A, B, C = self._bodies
        arms_m = position_m[A] - position_m[B], position_m[C] - position_m[B]
        length_a_m, length_c_m = (_length_m(arm_m, "bend") for arm_m in arms_m)
        a, c = arms_m[0] / length_a_m, arms_m[1] / length_c_m
        cosine = (a * c).sum(axis=1, keepdims=True)
        sine = np.linalg.norm(np.cross(a, c), axis=1, keepdims=True)
        excess_rad = (np.pi - self._rest_rad) - np.arctan2(sine, -cosine)
        if ((sine < 1e-12) & (abs(excess_rad) > 1e-9)).any():
            raise SolverError("The arms of a bend are parallel (its forces have no direction). Start at an angle.")
        moment_N_m = np.divide(self._stiffness_N_m * excess_rad, sine, out=np.zeros_like(sine), where=sine != 0)
        on_A_N = moment_N_m / length_a_m * (c - cosine * a)
        on_C_N = moment_N_m / length_c_m * (a - cosine * c)
        for bodies, on_them_N in ((A, on_A_N), (C, on_C_N), (B, -(on_A_N + on_C_N))):
            np.add.at(force_N, bodies, on_them_N)


class Drive:
    """Pair forces and forces of fixed direction; arrays have one row per actuator."""

    def __init__(self, actuators):
        _require_centres(actuators, "pair force")
        self._is_pair = np.array([actuator.kind == schema.ACTUATOR_KIND_PAIR_FORCE for actuator in actuators], bool)
        self._body_A = _numbers(actuators, "body_A")
        self._body_B = _numbers(actuators, "body_B") - 1  # 0 on the wire: none
        self._direction = np.array([list(actuator.direction) for actuator in actuators]).reshape(-1, 3)

    def add_forces(self, position_m, values_N, force_N):
        pair = self._is_pair & (values_N != 0)
        A, B = self._body_A[pair], self._body_B[pair]
        between_m = position_m[B] - position_m[A]
        on_B_N = values_N[pair, None] * (between_m / _length_m(between_m, "pair force"))
        np.subtract.at(force_N, A, on_B_N)
        np.add.at(force_N, B, on_B_N)
        world = ~self._is_pair
        np.add.at(force_N, self._body_A[world], values_N[world, None] * self._direction[world])


class PointMasses:
    def __init__(self, setup, context):
        if any(setup.gravity_m_per_s2):
            raise SolverError(
                "The case has gravity (which these point masses neglect). Use the body service of Copepod."
            )
        self._springs, self._bends, self._drive = Springs(setup.springs), Bends(setup.bends), Drive(setup.actuators)
        self._step_s = setup.step_s
        self._mass_kg = np.array([body.mass_kg for body in setup.bodies])[:, None]
        self._state = Kinematics(
            0,
            np.array([body.position_m for body in setup.bodies], float).reshape(-1, 3),  # there may be none
            np.array([body.orientation_wxyz for body in setup.bodies], float).reshape(-1, 4),
            np.array([body.velocity_m_per_s for body in setup.bodies], float).reshape(-1, 3),
            np.array([body.angular_velocity_rad_per_s for body in setup.bodies], float).reshape(-1, 3),
        )

    def driving_nodes(self):
        return [0.0]

    def kinematics(self):
        return self._state

    def step(self, applied):
        force_N = np.zeros_like(self._state.position_m)
        self._drive.add_forces(self._state.position_m, applied.actuation[0], force_N)
        force_N += applied.force_N
        self._bends.add_forces(self._state.position_m, force_N)
        self._springs.add_forces(self._state.position_m, self._state.velocity_m_per_s, force_N)
        self._state.velocity_m_per_s = self._state.velocity_m_per_s + self._step_s * force_N / self._mass_kg
        self._state.position_m = self._state.position_m + self._step_s * self._state.velocity_m_per_s
        self._state.step = applied.step + 1
        return self._state

    def save(self, path):
        with open(path, "wb") as file:
            np.savez(file, step=self._state.step, x=self._state.position_m, v=self._state.velocity_m_per_s)

    def restore(self, path):
        with np.load(path) as saved:  # what is raised here is a damaged file to the kit
            self._state.step = int(saved["step"])
            self._state.position_m, self._state.velocity_m_per_s = saved["x"], saved["v"]

    def summarise(self):
        bits = self._state.position_m.tobytes() + self._state.velocity_m_per_s.tobytes()
        return Summary(digest=int.from_bytes(hashlib.sha256(bits).digest()[:8], "little"))


FEATURES = [
    "motion:free",
    "shape:sphere",
    "springs",
    "bends",
    "actuator:pair_force",
    "actuator:world_force",
    "checkpoint",
    "snapshots",
    "neglects:torques",
    "neglects:periodic",
]

if __name__ == "__main__":
    sys.exit(run_body_component(PointMasses, Capabilities("Point masses in Python", "1.0", FEATURES)))
