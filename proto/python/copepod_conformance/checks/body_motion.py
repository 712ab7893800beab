"""Bodies that move under constant loads, for the checks of physics."""

import numpy as np

from copepod_conformance.cases import ZERO, rows
from copepod_conformance.verdicts import Violation

STEPS = 10
_TITLES = {
    "position_m": "position [m]",
    "velocity_m_per_s": "velocity [m/s]",
    "spin_rad_per_s": "angular velocity [rad/s]",
}


class Motion:
    """State of the bodies; arrays of shape (bodies, 3)."""

    def __init__(self, kinematics, bodies):
        self.position_m = rows(kinematics, "position_m", bodies=bodies)
        self.velocity_m_per_s = rows(kinematics, "velocity_m_per_s", bodies=bodies)
        self.spin_rad_per_s = rows(kinematics, "angular_velocity_rad_per_s", bodies=bodies)
        self.orientation_wxyz = rows(kinematics, "orientation_wxyz", width=4, bodies=bodies)

    def expect(self, name, body, expected, tolerance):
        """Raises Violation if an attribute of a body is not the expected one."""
        expect(f"{_TITLES[name]} of body {body}", getattr(self, name)[body], expected, tolerance)


def motions_of(trial, change=None, force=ZERO, torque=ZERO, values=(), steps=STEPS):
    """The bodies after each step, body 0 under these constant loads; `change` is done to the setup before."""
    trial.reach("greeted")
    request = trial.case.setup_request()
    del request.body_setup.actuators[:]
    if change:
        change(request.body_setup)
    bodies = len(request.body_setup.bodies)
    trial.request(request)
    rest = [ZERO] * (bodies - 1)
    for step in range(steps):
        reply = trial.request(trial.case.loads_request(step, [force, *rest], [torque, *rest], values))
        yield Motion(reply.envelope.kinematics, bodies)


def move(trial, *arguments, **named):
    """The last of motions_of."""
    *_, motion = motions_of(trial, *arguments, **named)
    return motion


def expect(what, found, expected, tolerance):
    if not np.all(np.abs(found - expected) <= tolerance):
        raise Violation(f"{what} {found} instead of {expected} (± {tolerance:.1g}) after {STEPS} steps")
