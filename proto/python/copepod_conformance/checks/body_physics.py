"""What every body solver does: a = F/m, α = T/I, nothing without a load; weight, springs and drive where announced."""

from functools import partial

import numpy as np

from copepod_component.messages import setup
from copepod_component.solvers import WIDTHS, Kinematics
from copepod_conformance.cases import AT_CENTRES, DIRECTION, FORCE_N, INERTIA_KG_M2, MASS_KG, OTHER_SHAPES, POSITIONS_M
from copepod_conformance.cases import SPEED_M_PER_S, SPIN_RAD_PER_S, STEP_S, TORQUE_N_M, ZERO
from copepod_conformance.cases import actuator, give_shape, rows, spheres
from copepod_conformance.verdicts import Check, NotApplicable, Violation, implied

_NEWTON = implied("a body under a constant force F accelerates with F/m; without a force it keeps its velocity")
_EULER = implied("a sphere under a constant torque T gains the angular velocity T t / I")
_TENSOR = implied("a body of another shape turns under a torque by its inertia tensor")
_WEIGHT = implied("a body that announces gravity falls with g where there is no fluid")
_SPRING = implied("a stretched spring pulls both its bodies towards each other alike")
_DRIVE = implied(
    "an actuator acts along its current direction: that of a pair force turns with the line between the bodies, "
    "that of a body force or torque with the body, that of a world force or torque never"
)
_NO_NET_LOAD = implied("a pair force has no net force and no net torque in any step")
_BEND = implied("a bend turns the arms at its body towards the rest angle, without net force and without net torque")
_FIXED = implied("a fixed body stays where it is, whatever the loads")

STEPS = 10
_TITLES = {
    "position_m": "position [m]",
    "velocity_m_per_s": "velocity [m/s]",
    "angular_velocity_rad_per_s": "angular velocity [rad/s]",
}
_TIME_S = STEPS * STEP_S
_ROUNDING = 1e-6  # of the expected change
_PAIR_FORCE = ("actuator:pair_force",)
NEARLY = 0.05  # of what changes under forces that are nearly constant for a short time
_START_M_PER_S = np.array([SPEED_M_PER_S, 0.0, 0.0])
_GRAVITY_M_PER_S2 = DIRECTION * FORCE_N / MASS_KG
_EXTENSION_M = 1e-6


def motions_of(trial, force=ZERO, torque=ZERO, values=(), steps=STEPS, **changes):
    """The bodies after each step, body 0 under these constant loads; `changes`: fields of the setup that differ."""
    trial.reach("greeted")
    request = trial.case.setup_request(**{"actuators": [], **changes})
    bodies = len(request.body_setup.bodies)
    trial.request(request)
    rest = [ZERO] * (bodies - 1)
    for step in range(steps):
        reply = trial.request(trial.case.loads_request(step, [force, *rest], [torque, *rest], values))
        found = (rows(reply.envelope.kinematics, name, width, bodies) for name, width in WIDTHS.items())
        yield Kinematics(step + 1, *found)


def move(trial, **how):
    """The last of motions_of."""
    *_, motion = motions_of(trial, **how)
    return motion


def expect_of(motion, body, name, expected, tolerance):
    """Raises Violation if an attribute of a body is not the expected one."""
    expect(f"{_TITLES[name]} of body {body}", getattr(motion, name)[body], expected, tolerance)


def expect(what, found, expected, tolerance):
    if not np.all(np.abs(found - expected) <= tolerance):
        raise Violation(f"{what} {found} instead of {expected} (± {tolerance:.1g}) after {STEPS} steps")


def under_loads(trial, force=ZERO, torque=ZERO, accelerates=(), gains=(), within=_ROUNDING, **changes):
    """The accelerations that bodies must have, and the angular velocities that they must have gained.

    v = v₀ + a t, without net momentum where the accelerations have none; x = x₀ + v₀ t + a t²/2 of the two spheres of
    every case, within what a first-order integrator may be off.
    """
    if np.any(torque) and trial.subject.can("neglects:torques"):
        raise NotApplicable("it announces neglects:torques")
    motion = move(trial, force=force, torque=torque, **changes)
    for body, acceleration_m_per_s2 in enumerate(accelerates):
        scale_m_per_s = max(float(np.abs(acceleration_m_per_s2).max()) * _TIME_S, SPEED_M_PER_S)
        velocity = _START_M_PER_S + acceleration_m_per_s2 * _TIME_S
        expect_of(motion, body, "velocity_m_per_s", velocity, within * scale_m_per_s)
        if body < len(POSITIONS_M):
            position = POSITIONS_M[body] + _START_M_PER_S * _TIME_S + 0.5 * acceleration_m_per_s2 * _TIME_S**2
            expect_of(motion, body, "position_m", position, scale_m_per_s * STEP_S)
    if len(accelerates) and not np.any(np.sum(accelerates, axis=0)):
        total = motion.velocity_m_per_s.sum(axis=0)
        expect("sum of velocities [m/s]", total, len(accelerates) * _START_M_PER_S, _ROUNDING * SPEED_M_PER_S)
    for body, gained in enumerate(gains):
        tolerance = within * float(np.abs(gained).max() or SPIN_RAD_PER_S)
        expect_of(motion, body, "angular_velocity_rad_per_s", gained, tolerance)
    if np.any(torque):
        expect("norm of the orientation of body 0", np.linalg.norm(motion.orientation_wxyz[0]), 1.0, 1e-9)


def _of_shape(trial, name):
    """Pushed along one principal axis, turned about another."""
    factors = np.array([1.0, 1.5, 2.0])
    changed = setup.BodySetup(bodies=spheres({"shape": {}, "inertia_kg_m2": (*INERTIA_KG_M2 * factors, 0, 0, 0)}, {}))
    give_shape(changed, changed.bodies[0].shape, name)
    loads = {"force": np.array([0.0, FORCE_N, 0.0]), "torque": np.array([0.0, 0.0, TORQUE_N_M])}
    due = {"accelerates": [loads["force"] / MASS_KG], "gains": [loads["torque"] / (INERTIA_KG_M2 * factors) * _TIME_S]}
    under_loads(trial, bodies=changed.bodies, meshes=changed.meshes, **loads, **due)


def _on_a_spring(trial):
    stretched = {"stiffness_N_per_m": FORCE_N / _EXTENSION_M, "rest_length_m": _ARM_LENGTH_M - _EXTENSION_M}
    spring: dict = {"body_A": 0, "body_B": 1, **stretched, **AT_CENTRES}
    pulled = FORCE_N / MASS_KG * np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
    under_loads(trial, springs=[spring], accelerates=pulled, within=NEARLY)


def _accuracy(trial, first_order):
    """How far the mean direction over STEPS steps may be off, for one that turns by `first_order` within a step."""
    fourth = trial.subject.can("integrator:runge_kutta_4")
    return 0.01 * first_order if fourth else first_order


_SPIN_PER_STEP_RAD = 0.05
_SPUN = {
    "body_force": "turns with its body",
    "body_torque": "turns with its body",
    "world_force": "keeps its direction",
    "world_torque": "keeps its direction",
}


def _on_a_spinning_body(trial, name):
    """An actuator along x, of the body or of the world, while the body turns about z by half a radian."""
    force, turns = name.endswith("force"), name.startswith("body")
    spin = _SPIN_PER_STEP_RAD / STEP_S
    spinning = spheres({"angular_velocity_rad_per_s": (0.0, 0.0, spin)}, {})
    along_x = actuator(name, direction=(1.0, 0.0, 0.0))
    motion = move(trial, bodies=spinning, actuators=[along_x], values=[FORCE_N if force else TORQUE_N_M])
    angle = spin * _TIME_S if turns else 0.0
    mean = np.array([np.sin(angle), 1.0 - np.cos(angle), 0.0]) / angle if turns else np.array([1.0, 0.0, 0.0])
    gained = (FORCE_N / MASS_KG if force else TORQUE_N_M / INERTIA_KG_M2) * _TIME_S
    start = _START_M_PER_S if force else np.array([0.0, 0.0, spin])
    # A small torque leaves the axis of the spin as it is, but for about gained/spin.
    tolerance = _accuracy(trial, _SPIN_PER_STEP_RAD) + (0.0 if force else gained / spin) if turns else _ROUNDING
    what = "velocity_m_per_s" if force else "angular_velocity_rad_per_s"
    expect_of(motion, 0, what, start + gained * mean, tolerance * gained + _ROUNDING * abs(start).max())


_ARM_M = np.subtract(POSITIONS_M[1], POSITIONS_M[0])
_ARM_LENGTH_M = float(np.linalg.norm(_ARM_M))
_TURN_PER_STEP_RAD = 0.02
_SLOW_TURN_PER_STEP_RAD = 5e-4  # its fourth power, the error of Runge-Kutta methods, is below _NET
_NET = 1e-12  # of the amplitude


def _turning_pair(turn_per_step_rad):
    """A pair force on two spheres that move past each other, so that the line between them turns."""
    speed = 0.5 * turn_per_step_rad * _ARM_LENGTH_M / STEP_S
    bodies = spheres(*({"velocity_m_per_s": (0.0, side * speed, 0.0)} for side in (-1, 1)))
    return {"bodies": bodies, "actuators": [actuator("pair_force", body_B=2)], "values": [FORCE_N]}


def _on_a_turning_arm(trial):
    """Against the motion computed here in steps a hundred times shorter."""
    motion = move(trial, **_turning_pair(_TURN_PER_STEP_RAD))
    arm = _ARM_M.copy()
    rate = np.array([0.0, _TURN_PER_STEP_RAD * _ARM_LENGTH_M / STEP_S, 0.0])
    start, parts = rate.copy(), 100
    for _ in range(STEPS * parts):
        middle = arm + 0.5 * STEP_S / parts * rate
        rate = rate + 2 * FORCE_N / MASS_KG * STEP_S / parts * middle / np.linalg.norm(middle)
        arm = arm + STEP_S / parts * rate
    found = motion.velocity_m_per_s[1] - motion.velocity_m_per_s[0] - start
    gained = 2 * FORCE_N / MASS_KG * _TIME_S
    tolerance = _accuracy(trial, _TURN_PER_STEP_RAD) * gained
    expect("relative velocity [m/s] gained from the pair force", found, rate - start, tolerance)


def _without_net_load(trial):
    """Momentum and angular momentum about the origin do not change in any step."""

    def momenta(motion):
        """Both in units of what one of the forces gives in a step."""
        linear = MASS_KG * motion.velocity_m_per_s
        turning = np.cross(motion.position_m, linear) + INERTIA_KG_M2 * motion.angular_velocity_rad_per_s
        return np.array([linear.sum(axis=0), turning.sum(axis=0) / _ARM_LENGTH_M]) / (FORCE_N * STEP_S)

    states = [momenta(motion) for motion in motions_of(trial, **_turning_pair(_SLOW_TURN_PER_STEP_RAD))]
    for step, changes in enumerate(np.abs(np.diff(states, axis=0)).max(axis=-1), 1):
        for what, change in zip(("momentum", "angular momentum"), changes):
            if change > _NET:
                raise Violation(f"{what} changed by {change:.1g} of what one of the forces gives, in step {step}")


def _on_a_bend(trial):
    """Three spheres at a right angle whose rest angle is smaller."""
    rest_rad = 1.2
    stiffness_N_m = FORCE_N * _ARM_LENGTH_M / (np.pi / 2 - rest_rad)
    first, second = spheres({}, {})
    third = {**first, "name": "sphere 2", "position_m": np.add(POSITIONS_M[0], (0.0, _ARM_LENGTH_M, 0.0))}
    bend = {"body_A": 1, "body_B": 0, "body_C": 2, "stiffness_N_m_per_rad": stiffness_N_m, "rest_angle_rad": rest_rad}
    turned = FORCE_N / MASS_KG * np.array([[-1.0, -1.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
    bodies = [first, second, third]
    under_loads(trial, bodies=bodies, bends=[bend], accelerates=turned, within=NEARLY)


def _fixed(trial):
    fixed = {"motion": setup.MOTION_KIND_FIXED, "velocity_m_per_s": ZERO}
    motion = move(trial, bodies=spheres(fixed, {}), force=FORCE_N * DIRECTION)
    expect_of(motion, 0, "position_m", np.array(POSITIONS_M[0]), 1e-9 * POSITIONS_M[0][0])


def checks(subject):
    shapes = [name for name in OTHER_SHAPES if subject.can(f"shape:{name}")]
    rest, force, torque = np.zeros((2, 3)), FORCE_N * DIRECTION, TORQUE_N_M * DIRECTION
    pushed = partial(under_loads, force=force, accelerates=[force / MASS_KG, rest[1]])
    turned = partial(under_loads, torque=torque, gains=[torque / INERTIA_KG_M2 * _TIME_S, rest[1]])
    weight = {"gravity_m_per_s2": _GRAVITY_M_PER_S2, "accelerates": 2 * [_GRAVITY_M_PER_S2]}
    check = partial(Check, "physics")
    return [
        check("no load: the velocity stays", _NEWTON, partial(under_loads, accelerates=rest, gains=rest)),
        check("hydrodynamic force: a = F/m", _NEWTON, pushed),
        check("torque: ω = T t / I", _EULER, turned),
        *(check(f"a {name} under force and torque", _TENSOR, _of_shape, (name,), ("inertia",)) for name in shapes),
        check("weight: a = g", _WEIGHT, partial(under_loads, **weight), needs=("gravity",)),
        check("a stretched spring pulls", _SPRING, _on_a_spring, needs=("springs",)),
        *(
            check(f"a {name.replace('_', ' ')} {follows}", _DRIVE, _on_a_spinning_body, (name,), (f"actuator:{name}",))
            for name, follows in _SPUN.items()
        ),
        check("a pair force follows the arm", _DRIVE, _on_a_turning_arm, needs=_PAIR_FORCE),
        check("a pair force has no net force and torque", _NO_NET_LOAD, _without_net_load, needs=_PAIR_FORCE),
        check("a bend turns its arms", _BEND, _on_a_bend, needs=("bends",)),
        check("a fixed body stays", _FIXED, _fixed, needs=("motion:fixed",)),
    ]
