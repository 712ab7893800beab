"""What every body solver does: a = F/m, α = T/I, nothing without a load; springs and weight where announced."""

import numpy as np

from copepod_conformance.cases import (
    FORCE_N,
    INERTIA_KG_M2,
    MASS_KG,
    POSITIONS_M,
    SPEED_M_PER_S,
    SPIN_RAD_PER_S,
    STEP_S,
    TORQUE_N_M,
    ZERO,
    rows,
)
from copepod_conformance.protocol import setup
from copepod_conformance.verdicts import Check, NotApplicable, Rule, Violation

_NEWTON = Rule(
    "What a role implies",
    "a body under a constant force F accelerates with F/m, a driving force counts alike; "
    "without a force it keeps its velocity",
)
_EULER = Rule("What a role implies", "a sphere under a constant torque T gains the angular velocity T t / I")
_WEIGHT = Rule("What a role implies", "a body that announces gravity falls with g where there is no fluid")
_SPRING = Rule("What a role implies", "a stretched spring pulls both its bodies towards each other alike")
_FIXED = Rule("What a role implies", "a fixed body stays where it is, whatever the loads")

_STEPS = 10
_TIME_S = _STEPS * STEP_S
_ROUNDING = 1e-6  # of the expected change
_DIRECTION = np.array([0.5, -1.0, 0.25])
_START_M_PER_S = np.array([SPEED_M_PER_S, 0.0, 0.0])
_GRAVITY_M_PER_S2 = _DIRECTION * FORCE_N / MASS_KG
_EXTENSION_M = 1e-6
_STIFFNESS_N_PER_M = FORCE_N / _EXTENSION_M


class _Motion:
    """State of the bodies after _STEPS steps; arrays of shape (bodies, 3)."""

    def __init__(self, kinematics):
        self.position_m = rows(kinematics, "position_m")
        self.velocity_m_per_s = rows(kinematics, "velocity_m_per_s")
        self.spin_rad_per_s = rows(kinematics, "angular_velocity_rad_per_s")
        self.orientation_wxyz = rows(kinematics, "orientation_wxyz", width=4)


def _move(trial, change=None, force=ZERO, torque=ZERO, driving=ZERO):
    """The bodies after some steps, body 0 under these constant loads; `change` is done to the setup before."""
    trial.reach("greeted")
    request = trial.case.setup_request()
    if change:
        change(request.body_setup)
    trial.request(request)
    for step in range(_STEPS):
        reply = trial.request(trial.case.loads_request(step, (force, ZERO), (torque, ZERO), (driving, ZERO)))
    return _Motion(reply.envelope.kinematics)


def _expect(what, found, expected, tolerance):
    if not np.all(np.abs(found - expected) <= tolerance):
        raise Violation(f"{what} {found} instead of {expected} (± {tolerance:.1g}) after {_STEPS} steps")


def _expect_acceleration(motion, body, acceleration_m_per_s2):
    """v = v₀ + a t within rounding; x = x₀ + v₀ t + a t²/2 within what a first-order integrator may be off."""
    scale_m_per_s = max(float(np.abs(acceleration_m_per_s2).max()) * _TIME_S, SPEED_M_PER_S)
    _expect(
        f"velocity [m/s] of body {body}",
        motion.velocity_m_per_s[body],
        _START_M_PER_S + acceleration_m_per_s2 * _TIME_S,
        _ROUNDING * scale_m_per_s,
    )
    _expect(
        f"position [m] of body {body}",
        motion.position_m[body],
        POSITIONS_M[body] + _START_M_PER_S * _TIME_S + 0.5 * acceleration_m_per_s2 * _TIME_S**2,
        scale_m_per_s * STEP_S,
    )


def _under_force(kind):
    def run(trial):
        force = FORCE_N * _DIRECTION
        motion = _move(trial, **{kind: force})
        _expect_acceleration(motion, 0, force / MASS_KG)
        _expect_acceleration(motion, 1, np.zeros(3))

    return run


def _unloaded(trial):
    motion = _move(trial)
    for body in (0, 1):
        _expect_acceleration(motion, body, np.zeros(3))
        _expect(
            f"angular velocity [rad/s] of body {body}",
            motion.spin_rad_per_s[body],
            np.zeros(3),
            _ROUNDING * SPIN_RAD_PER_S,
        )


def _under_torque(trial):
    if trial.subject.can("neglects:torques"):
        raise NotApplicable("it announces neglects:torques")
    torque = TORQUE_N_M * _DIRECTION
    motion = _move(trial, torque=torque)
    gained = torque / INERTIA_KG_M2 * _TIME_S
    _expect(
        "angular velocity [rad/s] of body 0", motion.spin_rad_per_s[0], gained, _ROUNDING * float(np.abs(gained).max())
    )
    _expect("angular velocity [rad/s] of body 1", motion.spin_rad_per_s[1], np.zeros(3), _ROUNDING * SPIN_RAD_PER_S)
    _expect("norm of the orientation of body 0", np.linalg.norm(motion.orientation_wxyz[0]), 1.0, 1e-9)


def _falling(trial):
    trial.require("gravity")
    motion = _move(trial, lambda content: content.gravity_m_per_s2.__setitem__(slice(None), _GRAVITY_M_PER_S2))
    for body in (0, 1):
        _expect_acceleration(motion, body, _GRAVITY_M_PER_S2)


def _on_a_spring(trial):
    """A time so short that the spring's force is nearly constant."""
    trial.require("springs")

    def join(content):
        distance = POSITIONS_M[1][0] - POSITIONS_M[0][0]
        content.springs.add(
            body_A=0,
            body_B=1,
            stiffness_N_per_m=_STIFFNESS_N_PER_M,
            rest_length_m=distance - _EXTENSION_M,
            anchor_A_m=ZERO,
            anchor_B_m=ZERO,
        )

    motion = _move(trial, join)
    gained = FORCE_N / MASS_KG * _TIME_S * np.array([1.0, 0.0, 0.0])
    for body, sign in ((0, 1), (1, -1)):
        _expect(
            f"velocity [m/s] of body {body}",
            motion.velocity_m_per_s[body],
            _START_M_PER_S + sign * gained,
            0.05 * float(gained.max()),
        )
    _expect(
        "sum of velocities [m/s]", motion.velocity_m_per_s.sum(axis=0), 2 * _START_M_PER_S, _ROUNDING * SPEED_M_PER_S
    )


def _fixed(trial):
    trial.require("motion:fixed")

    def fix(content):
        body = content.bodies[0]
        body.motion, body.velocity_m_per_s[:] = setup.MOTION_KIND_FIXED, ZERO

    motion = _move(trial, fix, force=FORCE_N * _DIRECTION)
    _expect("position [m] of body 0", motion.position_m[0], np.array(POSITIONS_M[0]), 1e-9 * POSITIONS_M[0][0])


def checks(subject):
    if subject.role != "body":
        return []
    return [
        Check("physics", "no load: the velocity stays", _NEWTON, _unloaded),
        Check("physics", "hydrodynamic force: a = F/m", _NEWTON, _under_force("force")),
        Check("physics", "driving force: a = F/m", _NEWTON, _under_force("driving")),
        Check("physics", "torque: ω = T t / I", _EULER, _under_torque),
        Check("physics", "weight: a = g", _WEIGHT, _falling),
        Check("physics", "a stretched spring pulls", _SPRING, _on_a_spring),
        Check("physics", "a fixed body stays", _FIXED, _fixed),
    ]
