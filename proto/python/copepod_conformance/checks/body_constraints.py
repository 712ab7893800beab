"""Contacts and joints of body solvers that announce them: a rebound has the restitution of the setup; a joint, free or
driven, is closed after every step, whatever the loads."""

from functools import partial

import numpy as np

from copepod_conformance.cases import FORCE_N, INERTIA_KG_M2, MASS_KG, POSITIONS_M, RADIUS_M, SPEED_M_PER_S, STEP_S
from copepod_conformance.cases import TORQUE_N_M, ZERO, actuator, spheres
from copepod_conformance.checks.body_physics import NEARLY, STEPS, motions_of, move, under_loads
from copepod_conformance.verdicts import Check, Violation, implied

_REBOUND = implied("a body that hits a wall or another body rebounds with the restitution of the setup, within 2 %")
_RESTING = implied("a body that lies on a wall under its weight stays there")
_LEAVES = implied("a body whose bounding ball reaches an exit is behind it, and rests there from the next step on")
_CLOSED = implied("joints are closed in every reply, while their bodies move and turn")
_SPRING = implied("a spring in a hinge turns both its bodies alike, towards where it is relaxed")
_LIMIT = implied("a slider that is pressed against its limit stays there")
_DRIVEN = implied("a driven joint has moved by the value of its actuator since step 0")

_CONTACT_STEPS = 50  # the shortest contact lasts that long
_FALL_STEPS = 5
_RESTITUTION = 0.5
_STIFFNESS_OF_CONTACT_N_PER_M = 0.5 * MASS_KG * (np.pi / (_CONTACT_STEPS * STEP_S)) ** 2
_GAP_M = _FALL_STEPS * STEP_S * SPEED_M_PER_S
_FLOOR = {"point_m": ZERO, "normal": (0.0, 0.0, 1.0), "velocity_m_per_s": ZERO}


def _in_contact(change):
    """Fields of a setup with contacts: both spheres at rest, but for the change of sphere 0."""
    contact = {"stiffness_N_per_m": _STIFFNESS_OF_CONTACT_N_PER_M, "restitution": _RESTITUTION, "friction": 0.0}
    resting = {"velocity_m_per_s": ZERO}
    return {"contact": contact, "bodies": spheres({**resting, **change}, resting)}


def _rebounding(trial, where):
    """Sphere 0 hits a wall, or sphere 1."""
    hits_wall = where == "the wall"
    trial.subject.require("contact", *(["walls"] if hits_wall else []))
    axis = 2 if hits_wall else 0
    start_m, velocity_m_per_s = np.array(POSITIONS_M[0]), np.zeros(3)
    start_m[axis] = RADIUS_M + _GAP_M if hits_wall else POSITIONS_M[1][0] - 2 * RADIUS_M - _GAP_M
    velocity_m_per_s[axis] = -SPEED_M_PER_S if hits_wall else SPEED_M_PER_S
    changes = _in_contact({"position_m": start_m, "velocity_m_per_s": velocity_m_per_s})
    walls, steps = [_FLOOR] if hits_wall else [], _FALL_STEPS + 3 * _CONTACT_STEPS
    first, other = move(trial, walls=walls, steps=steps, **changes).velocity_m_per_s[:, axis]
    found = (first if hits_wall else other - first) / SPEED_M_PER_S
    if not abs(found - _RESTITUTION) <= 0.02 * _RESTITUTION:
        raise Violation(f"{found:.4g} of the speed is left after a rebound from {where}, not {_RESTITUTION}")


def _resting(trial):
    sinking = 1e-4  # of the radius
    weight_per_mass = _STIFFNESS_OF_CONTACT_N_PER_M * sinking * RADIUS_M / MASS_KG
    changes = _in_contact({"position_m": (*POSITIONS_M[0][:2], RADIUS_M)})
    changes.update(walls=[_FLOOR], gravity_m_per_s2=(0.0, 0.0, -weight_per_mass))
    depth = 0.0
    for motion in motions_of(trial, steps=20 * _CONTACT_STEPS, **changes):
        depth = 1.0 - motion.position_m[0][2] / RADIUS_M
        if not -0.01 * sinking <= depth <= 2.1 * sinking:
            raise Violation(f"a sphere on the floor is {depth:.3g} of its radius below its place")
    if not depth <= 1.01 * sinking:
        raise Violation(f"a sphere on the floor came to rest {depth:.3g} of its radius deep, not {sinking:.3g}")
    if not np.abs(motion.velocity_m_per_s[0]).max() <= 1e-3 * sinking * RADIUS_M / STEP_S:
        raise Violation("a sphere on the floor does not come to rest")


def _leaves(trial):
    """Sphere 0 moves to an exit, and is there in the third step; along it, it is pushed all the time."""
    moves = {"position_m": (*POSITIONS_M[0][:2], RADIUS_M + 2.5 * STEP_S * SPEED_M_PER_S)}
    moves["velocity_m_per_s"] = (0.0, 0.0, -SPEED_M_PER_S)
    exits = [dict(_FLOOR, removes_bodies=True)]
    motions = [*motions_of(trial, force=(FORCE_N, 0.0, 0.0), walls=exits, bodies=spheres(moves, {}))]
    for motion in motions:
        if (motion.position_m[0][2] < 0.0) != (motion.step >= 3):
            raise Violation(f"the sphere reaches the exit in step 3; after step {motion.step} it is on the wrong side")
    behind = motions[3:]
    if any(np.any(one.velocity_m_per_s[0]) or np.any(one.position_m[0] != behind[0].position_m[0]) for one in behind):
        raise Violation("a body behind an exit moves")


_STEPS = 20
_TURN_PER_STEP_RAD = 0.02
_LENGTH_M = POSITIONS_M[1][0] - POSITIONS_M[0][0]
_OPEN = 1e-9  # of a radius, and of directions
_STOP = 0.02  # of a limit: engines have soft ones
_AXIS = np.array([0.0, 0.6, 0.8])
_ANCHOR_M = np.array([0.5 * _LENGTH_M, 0.0, 0.0])  # from the centre of sphere 0; from that of sphere 1 the opposite
_VALUE = {"hinge": 0.01, "slider": 0.01 * RADIUS_M, "distance": 0.01 * RADIUS_M}  # per step, of a driven joint


def _joined(kind, driven):
    """Fields of a setup with a joint in the middle between both spheres, which turn together."""
    spin = _TURN_PER_STEP_RAD / STEP_S
    turning = (
        {"angular_velocity_rad_per_s": (0.0, 0.0, spin), "velocity_m_per_s": (SPEED_M_PER_S, side * spin, 0.0)}
        for side in (-0.5 * _LENGTH_M, 0.5 * _LENGTH_M)
    )
    anchor_m = ZERO if kind == "distance" else _ANCHOR_M
    joint = _joint(kind, anchor_m, -np.asarray(anchor_m), body_B=2)
    actuators = [actuator("joint_motion", body_B=2, joint=1)] if driven else []
    return {"bodies": spheres(*turning), "joints": [joint], "actuators": actuators}


def _joint(kind, anchor_A_m, anchor_B_m, **fields):
    anchors = {"anchor_A_m": anchor_A_m, "anchor_B_m": anchor_B_m}
    return {"kind": f"JOINT_KIND_{kind.upper()}", "body_A": 0, **anchors, "axis": _AXIS, **fields}


def _matrix(q_WB):
    """R_WB of a unit quaternion (w, r)."""
    cross = np.cross(np.eye(3), q_WB[1:])  # times a vector: r × v
    return np.eye(3) + 2 * (q_WB[0] * cross + cross @ cross)


def _errors(kind, motion, value):
    """How far a joint is from what it keeps, and from the value of its drive if it has one; without units."""
    R_A, R_B = (_matrix(q) for q in motion.orientation_wxyz)
    p_A, p_B = motion.position_m
    anchor_m = ZERO if kind == "distance" else _ANCHOR_M
    apart = (p_A + R_A @ anchor_m - p_B + R_B @ np.asarray(anchor_m)) / RADIUS_M
    axis = R_B @ _AXIS
    turned = R_B.T @ R_A
    along = apart @ axis
    if kind == "distance":
        return {"length": np.linalg.norm(apart) - (_LENGTH_M + (value or 0.0)) / RADIUS_M}
    errors = {"ends": apart - along * axis if kind == "slider" else apart}
    if kind == "hinge":
        errors["axes"] = R_A @ _AXIS - axis
        if value is not None:
            errors["angle"] = turned - _matrix((np.cos(value / 2), *np.sin(value / 2) * _AXIS))
    elif kind != "ball":
        errors["directions"] = turned - np.eye(3)
    if kind == "slider" and value is not None:
        errors["place on the axis"] = along - value / RADIUS_M
    return errors


def _stays_closed(trial, kind, driven=False):
    trial.subject.require(f"joint:{kind}", *(["actuator:joint_motion"] if driven else []))
    loads = {"force": FORCE_N * _AXIS, "torque": TORQUE_N_M * np.array([1.0, -0.5, 0.25])}
    drive = (lambda time_steps: [_VALUE[kind] * time_steps]) if driven else (lambda time_steps: [])
    moved = motions_of(trial, steps=_STEPS, values=drive, **loads, **_joined(kind, driven))
    for step, motion in enumerate(moved, 1):
        for what, error in _errors(kind, motion, _VALUE[kind] * step if driven else None).items():
            if not np.abs(error).max() <= _OPEN:
                raise Violation(f"{what} off by {np.abs(error).max():.3g} (radii, radians) after {step} steps")
    if not np.abs(motion.orientation_wxyz[0] - (1.0, 0.0, 0.0, 0.0)).max() > 1e-3:
        raise Violation("nothing has turned")


def _spring_turns(trial):
    """Both spheres, by opposite torques, for a time so short that these are constant; the hinge exerts no force."""
    hinge = _joint("hinge", _ANCHOR_M, -_ANCHOR_M, body_B=2, stiffness=TORQUE_N_M, rest=1.0)
    gained = TORQUE_N_M / INERTIA_KG_M2 * STEPS * STEP_S * _AXIS
    under_loads(trial, joints=[hinge], gains=[gained, -gained], within=NEARLY)


def _limit_holds(trial):
    """Sphere 0 is pushed along a rail in the world, which ends after a two-hundredth of its radius."""
    limit_m = 0.005 * RADIUS_M
    resting = {"velocity_m_per_s": ZERO, "angular_velocity_rad_per_s": ZERO}
    rail = _joint("slider", ZERO, POSITIONS_M[0], lowest=-0.1 * limit_m, highest=limit_m)
    motion = move(trial, steps=60, force=FORCE_N * _AXIS, bodies=spheres(resting, {}), joints=[rail])
    moved = (motion.position_m[0] - POSITIONS_M[0]) @ _AXIS / limit_m
    if not abs(moved - 1.0) <= _STOP:
        raise Violation(f"it has moved {moved:.6g} times the limit")


def checks(subject):
    kinds = ("ball", "hinge", "slider", "fixed", "distance")
    check = partial(Check, "physics")
    return [
        check("a body rebounds with the restitution of the setup", _REBOUND, _rebounding, ("the wall",)),
        check("spheres rebound from each other", _REBOUND, _rebounding, ("each other",)),
        check("a body on the floor stays", _RESTING, _resting, needs=("contact", "walls", "gravity")),
        check("a body that reaches an exit leaves", _LEAVES, _leaves, needs=("removal",)),
        *(check(f"a {kind} joint stays closed", _CLOSED, _stays_closed, (kind,)) for kind in kinds),
        check("a spring in a hinge turns both bodies", _SPRING, _spring_turns, needs=("joint:hinge", "joint:springs")),
        check("a slider stays at its limit", _LIMIT, _limit_holds, needs=("joint:slider", "joint:limits")),
        *(check(f"a driven {kind} joint follows", _DRIVEN, _stays_closed, (kind, True)) for kind in _VALUE),
    ]
