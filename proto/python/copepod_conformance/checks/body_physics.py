"""What every body solver does: a = F/m, α = T/I, nothing without a load; weight, springs and drive where announced."""

import numpy as np

from copepod_conformance.cases import (
    FORCE_N,
    INERTIA_KG_M2,
    MASS_KG,
    POSITIONS_M,
    RADIUS_M,
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
    "a body under a constant force F accelerates with F/m; without a force it keeps its velocity",
)
_EULER = Rule("What a role implies", "a sphere under a constant torque T gains the angular velocity T t / I")
_WEIGHT = Rule("What a role implies", "a body that announces gravity falls with g where there is no fluid")
_SPRING = Rule("What a role implies", "a stretched spring pulls both its bodies towards each other alike")
_DRIVE = Rule(
    "What a role implies",
    "an actuator acts along its current direction: that of a pair force turns with the line between the bodies, "
    "that of a body force or torque with the body, that of a world force or torque never",
)
_NO_NET_LOAD = Rule("What a role implies", "a pair force has no net force and no net torque in any step")
_BEND = Rule(
    "What a role implies",
    "a bend turns the arms at its body towards the rest angle, without net force and without net torque",
)
_REBOUND = Rule(
    "What a role implies",
    "a body that hits a wall or another body rebounds with the restitution of the setup, within 2 %",
)
_RESTING = Rule("What a role implies", "a body that lies on a wall under its weight stays there")
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
    """State of the bodies; arrays of shape (bodies, 3)."""

    def __init__(self, kinematics, bodies):
        self.position_m = rows(kinematics, "position_m", bodies=bodies)
        self.velocity_m_per_s = rows(kinematics, "velocity_m_per_s", bodies=bodies)
        self.spin_rad_per_s = rows(kinematics, "angular_velocity_rad_per_s", bodies=bodies)
        self.orientation_wxyz = rows(kinematics, "orientation_wxyz", width=4, bodies=bodies)


def _motions(trial, change=None, force=ZERO, torque=ZERO, values=(), steps=_STEPS):
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
        yield _Motion(reply.envelope.kinematics, bodies)


def _move(trial, *arguments, **named):
    """The last of _motions."""
    *_, motion = _motions(trial, *arguments, **named)
    return motion


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


def _under_force(trial):
    force = FORCE_N * _DIRECTION
    motion = _move(trial, force=force)
    _expect_acceleration(motion, 0, force / MASS_KG)
    _expect_acceleration(motion, 1, np.zeros(3))


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


def _accuracy(trial, first_order):
    """How far the mean direction over _STEPS steps may be off, for one that turns by `first_order` within a step."""
    fourth = trial.subject.can("integrator:runge_kutta_4")
    return 0.01 * first_order if fourth else first_order


_SPIN_PER_STEP_RAD = 0.05
_SPUN = {
    "body_force": "turns with its body",
    "body_torque": "turns with its body",
    "world_force": "keeps its direction",
    "world_torque": "keeps its direction",
}


def _on_a_spinning_body(name):
    """An actuator along x, of the body or of the world, while the body turns about z by half a radian."""
    force, turns = name.endswith("force"), name.startswith("body")

    def run(trial):
        trial.require(f"actuator:{name}")
        spin = _SPIN_PER_STEP_RAD / STEP_S

        def drive(content):
            content.bodies[0].angular_velocity_rad_per_s[:] = (0.0, 0.0, spin)
            kind = getattr(setup, f"ACTUATOR_KIND_{name.upper()}")
            content.actuators.add(kind=kind, direction=(1.0, 0.0, 0.0), anchor_A_m=ZERO, anchor_B_m=ZERO)

        motion = _move(trial, drive, values=[FORCE_N if force else TORQUE_N_M])
        angle = spin * _TIME_S if turns else 0.0
        mean = np.array([np.sin(angle), 1.0 - np.cos(angle), 0.0]) / angle if turns else np.array([1.0, 0.0, 0.0])
        gained = (FORCE_N / MASS_KG if force else TORQUE_N_M / INERTIA_KG_M2) * _TIME_S
        start = _START_M_PER_S if force else np.array([0.0, 0.0, spin])
        found = motion.velocity_m_per_s if force else motion.spin_rad_per_s
        # A small torque leaves the axis of the spin as it is, but for about gained/spin.
        tolerance = _accuracy(trial, _SPIN_PER_STEP_RAD) + (0.0 if force else gained / spin) if turns else _ROUNDING
        what = "velocity [m/s]" if force else "angular velocity [rad/s]"
        _expect(f"{what} of body 0", found[0], start + gained * mean, tolerance * gained + _ROUNDING * abs(start).max())

    return run


_ARM_M = np.subtract(POSITIONS_M[1], POSITIONS_M[0])
_ARM_LENGTH_M = float(np.linalg.norm(_ARM_M))
_TURN_PER_STEP_RAD = 0.02
_SLOW_TURN_PER_STEP_RAD = 5e-4  # its fourth power, the error of Runge-Kutta methods, is below _NET
_NET = 1e-12  # of the amplitude


def _turning_pair(turn_per_step_rad):
    """A pair force on two spheres that move past each other, so that the line between them turns."""

    def change(content):
        speed = 0.5 * turn_per_step_rad * _ARM_LENGTH_M / STEP_S
        content.bodies[0].velocity_m_per_s[:] = (0.0, -speed, 0.0)
        content.bodies[1].velocity_m_per_s[:] = (0.0, speed, 0.0)
        content.actuators.add(
            kind=setup.ACTUATOR_KIND_PAIR_FORCE, body_B=2, direction=(0.0, 0.0, 1.0), anchor_A_m=ZERO, anchor_B_m=ZERO
        )

    return change


def _on_a_turning_arm(trial):
    """Against the motion computed here in steps a hundred times shorter."""
    trial.require("actuator:pair_force")
    motion = _move(trial, _turning_pair(_TURN_PER_STEP_RAD), values=[FORCE_N])
    arm = _ARM_M.copy()
    rate = np.array([0.0, _TURN_PER_STEP_RAD * _ARM_LENGTH_M / STEP_S, 0.0])
    start, parts = rate.copy(), 100
    for _ in range(_STEPS * parts):
        middle = arm + 0.5 * STEP_S / parts * rate
        rate = rate + 2 * FORCE_N / MASS_KG * STEP_S / parts * middle / np.linalg.norm(middle)
        arm = arm + STEP_S / parts * rate
    found = motion.velocity_m_per_s[1] - motion.velocity_m_per_s[0] - start
    gained = 2 * FORCE_N / MASS_KG * _TIME_S
    tolerance = _accuracy(trial, _TURN_PER_STEP_RAD) * gained
    _expect("relative velocity [m/s] gained from the pair force", found, rate - start, tolerance)


def _without_net_load(trial):
    """Momentum and angular momentum about the origin do not change in any step."""
    trial.require("actuator:pair_force")

    def momenta(motion):
        """Both in units of what one of the forces gives in a step."""
        linear = MASS_KG * motion.velocity_m_per_s
        turning = np.cross(motion.position_m, linear) + INERTIA_KG_M2 * motion.spin_rad_per_s
        unit = FORCE_N * STEP_S
        return {"momentum": linear.sum(axis=0) / unit, "angular momentum": turning.sum(axis=0) / (unit * _ARM_LENGTH_M)}

    states = [momenta(motion) for motion in _motions(trial, _turning_pair(_SLOW_TURN_PER_STEP_RAD), values=[FORCE_N])]
    for step, (before, after) in enumerate(zip(states, states[1:]), 1):
        for what, amount in after.items():
            change = float(np.abs(amount - before[what]).max())
            if change > _NET:
                raise Violation(f"{what} changed by {change:.1g} of what one of the forces gives, in step {step}")


def _on_a_bend(trial):
    """Three spheres at a right angle whose rest angle is smaller, for a time so short that the forces are constant."""
    trial.require("bends")
    rest_rad = 1.2
    stiffness_N_m = FORCE_N * _ARM_LENGTH_M / (np.pi / 2 - rest_rad)

    def bend(content):
        third = content.bodies.add()
        third.CopyFrom(content.bodies[0])
        third.name, third.position_m[1] = "sphere 2", POSITIONS_M[0][1] + _ARM_LENGTH_M
        content.bends.add(body_A=1, body_B=0, body_C=2, stiffness_N_m_per_rad=stiffness_N_m, rest_angle_rad=rest_rad)

    gained = FORCE_N / MASS_KG * _TIME_S * np.array([[-1.0, -1.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
    motion = _move(trial, bend)
    for body in range(3):
        _expect(
            f"velocity [m/s] of body {body}",
            motion.velocity_m_per_s[body],
            _START_M_PER_S + gained[body],
            0.05 * float(gained.max()),
        )
    _expect(
        "sum of velocities [m/s]", motion.velocity_m_per_s.sum(axis=0), 3 * _START_M_PER_S, _ROUNDING * SPEED_M_PER_S
    )


_CONTACT_STEPS = 50  # the shortest contact lasts that long
_FALL_STEPS = 5
_RESTITUTION = 0.5
_STIFFNESS_OF_CONTACT_N_PER_M = 0.5 * MASS_KG * (np.pi / (_CONTACT_STEPS * STEP_S)) ** 2


def _with_contacts(change):
    """The setup with contacts, both spheres at rest."""

    def complete(content):
        content.contact.stiffness_N_per_m = _STIFFNESS_OF_CONTACT_N_PER_M
        content.contact.restitution, content.contact.friction = _RESTITUTION, 0.0
        for body in content.bodies:
            body.velocity_m_per_s[:] = ZERO
        change(content)

    return complete


_GAP_M = _FALL_STEPS * STEP_S * SPEED_M_PER_S


def _rebounding_from_wall(trial):
    trial.require("contact")
    trial.require("walls")

    def fall(content):
        content.walls.add(point_m=ZERO, normal=(0.0, 0.0, 1.0), velocity_m_per_s=ZERO)
        content.bodies[0].position_m[2] = RADIUS_M + _GAP_M
        content.bodies[0].velocity_m_per_s[2] = -SPEED_M_PER_S

    *_, motion = _motions(trial, _with_contacts(fall), steps=_FALL_STEPS + 3 * _CONTACT_STEPS)
    _expect_rebound("from the wall", motion.velocity_m_per_s[0][2])


def _rebounding_from_each_other(trial):
    trial.require("contact")

    def collide(content):
        content.bodies[0].position_m[0] = POSITIONS_M[1][0] - 2 * RADIUS_M - _GAP_M
        content.bodies[0].velocity_m_per_s[0] = SPEED_M_PER_S

    *_, motion = _motions(trial, _with_contacts(collide), steps=_FALL_STEPS + 3 * _CONTACT_STEPS)
    _expect_rebound("from each other", motion.velocity_m_per_s[1][0] - motion.velocity_m_per_s[0][0])


def _expect_rebound(where, velocity_m_per_s):
    found = velocity_m_per_s / SPEED_M_PER_S
    if not abs(found - _RESTITUTION) <= 0.02 * _RESTITUTION:
        raise Violation(f"{found:.4g} of the speed is left after a rebound {where}, not {_RESTITUTION}")


def _resting(trial):
    trial.require("contact")
    trial.require("walls")
    trial.require("gravity")
    sinking = 1e-4  # of the radius

    def lay_down(content):
        content.walls.add(point_m=ZERO, normal=(0.0, 0.0, 1.0), velocity_m_per_s=ZERO)
        content.gravity_m_per_s2[2] = -_STIFFNESS_OF_CONTACT_N_PER_M * sinking * RADIUS_M / MASS_KG
        content.bodies[0].position_m[2] = RADIUS_M

    depth = 0.0
    for motion in _motions(trial, _with_contacts(lay_down), steps=20 * _CONTACT_STEPS):
        depth = 1.0 - motion.position_m[0][2] / RADIUS_M
        if not -1e-9 <= depth <= 2.1 * sinking:
            raise Violation(f"a sphere on the floor is {depth:.3g} of its radius below its place")
    if not abs(depth - sinking) <= 0.01 * sinking:
        raise Violation(f"a sphere on the floor came to rest {depth:.3g} of its radius deep, not {sinking:.3g}")


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
        Check("physics", "hydrodynamic force: a = F/m", _NEWTON, _under_force),
        Check("physics", "torque: ω = T t / I", _EULER, _under_torque),
        Check("physics", "weight: a = g", _WEIGHT, _falling),
        Check("physics", "a stretched spring pulls", _SPRING, _on_a_spring),
        *(
            Check("physics", f"a {name.replace('_', ' ')} {follows}", _DRIVE, _on_a_spinning_body(name))
            for name, follows in _SPUN.items()
        ),
        Check("physics", "a pair force follows the arm", _DRIVE, _on_a_turning_arm),
        Check("physics", "a pair force has no net force and torque", _NO_NET_LOAD, _without_net_load),
        Check("physics", "a bend turns its arms", _BEND, _on_a_bend),
        Check("physics", "a body rebounds with the restitution of the setup", _REBOUND, _rebounding_from_wall),
        Check("physics", "spheres rebound from each other", _REBOUND, _rebounding_from_each_other),
        Check("physics", "a body on the floor stays", _RESTING, _resting),
        Check("physics", "a fixed body stays", _FIXED, _fixed),
    ]
