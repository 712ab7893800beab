"""Contacts of body solvers that announce them."""

import numpy as np

from copepod_conformance.cases import MASS_KG, POSITIONS_M, RADIUS_M, SPEED_M_PER_S, STEP_S, ZERO
from copepod_conformance.checks.body_physics import motions_of, move
from copepod_conformance.verdicts import Check, Violation, implied

_REBOUND = implied("a body that hits a wall or another body rebounds with the restitution of the setup, within 2 %")
_RESTING = implied("a body that lies on a wall under its weight stays there")

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
    trial.require("contact", "walls")

    def fall(content):
        content.walls.add(point_m=ZERO, normal=(0.0, 0.0, 1.0), velocity_m_per_s=ZERO)
        content.bodies[0].position_m[2] = RADIUS_M + _GAP_M
        content.bodies[0].velocity_m_per_s[2] = -SPEED_M_PER_S

    motion = move(trial, _with_contacts(fall), steps=_FALL_STEPS + 3 * _CONTACT_STEPS)
    _expect_rebound("from the wall", motion.velocity_m_per_s[0][2])


def _rebounding_from_each_other(trial):
    trial.require("contact")

    def collide(content):
        content.bodies[0].position_m[0] = POSITIONS_M[1][0] - 2 * RADIUS_M - _GAP_M
        content.bodies[0].velocity_m_per_s[0] = SPEED_M_PER_S

    motion = move(trial, _with_contacts(collide), steps=_FALL_STEPS + 3 * _CONTACT_STEPS)
    _expect_rebound("from each other", motion.velocity_m_per_s[1][0] - motion.velocity_m_per_s[0][0])


def _expect_rebound(where, velocity_m_per_s):
    found = velocity_m_per_s / SPEED_M_PER_S
    if not abs(found - _RESTITUTION) <= 0.02 * _RESTITUTION:
        raise Violation(f"{found:.4g} of the speed is left after a rebound {where}, not {_RESTITUTION}")


def _resting(trial):
    trial.require("contact", "walls", "gravity")
    sinking = 1e-4  # of the radius

    def lay_down(content):
        content.walls.add(point_m=ZERO, normal=(0.0, 0.0, 1.0), velocity_m_per_s=ZERO)
        content.gravity_m_per_s2[2] = -_STIFFNESS_OF_CONTACT_N_PER_M * sinking * RADIUS_M / MASS_KG
        content.bodies[0].position_m[2] = RADIUS_M

    depth = 0.0
    for motion in motions_of(trial, _with_contacts(lay_down), steps=20 * _CONTACT_STEPS):
        depth = 1.0 - motion.position_m[0][2] / RADIUS_M
        if not -0.01 * sinking <= depth <= 2.1 * sinking:
            raise Violation(f"a sphere on the floor is {depth:.3g} of its radius below its place")
    if not depth <= 1.01 * sinking:
        raise Violation(f"a sphere on the floor came to rest {depth:.3g} of its radius deep, not {sinking:.3g}")
    if not np.abs(motion.velocity_m_per_s[0]).max() <= 1e-3 * sinking * RADIUS_M / STEP_S:
        raise Violation("a sphere on the floor does not come to rest")


def checks(subject):
    return [
        Check("physics", "a body rebounds with the restitution of the setup", _REBOUND, _rebounding_from_wall),
        Check("physics", "spheres rebound from each other", _REBOUND, _rebounding_from_each_other),
        Check("physics", "a body on the floor stays", _RESTING, _resting),
    ]
