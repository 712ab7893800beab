#!/usr/bin/env python3
"""Writes configs/examples/meshes/helix.obj: a tube of 0.7 along a right-handed helix of radius 2, two turns of pitch 7,
with rounded ends."""

import math
from pathlib import Path

OUTPUT = Path(__file__).resolve().parents[2] / "configs/examples/meshes/helix.obj"
TUBE, RADIUS, PITCH, TURNS = 0.7, 2.0, 7.0, 2
SIDES, PER_TURN, CAP = 12, 32, 4


def point(turn, angle, radius, forward):
    """On the ring of the tube around the helix at `turn`, moved along its tangent by `forward`."""
    phase = 2 * math.pi * turn
    centre = (RADIUS * math.cos(phase), RADIUS * math.sin(phase), PITCH * (turn - TURNS / 2))
    length = math.hypot(2 * math.pi * RADIUS, PITCH)
    sine, cosine = 2 * math.pi * RADIUS / length, PITCH / length
    normal = (math.cos(phase), math.sin(phase), 0.0)
    tangent = (-sine * math.sin(phase), sine * math.cos(phase), cosine)
    binormal = (-cosine * math.sin(phase), cosine * math.cos(phase), -sine)
    across = (radius * math.cos(angle), radius * math.sin(angle))
    return [c + across[0] * n + across[1] * b + forward * t for c, n, b, t in zip(centre, normal, binormal, tangent)]


rings = [(0.0, TUBE * math.sin(a), -TUBE * math.cos(a)) for a in (math.pi / 2 * k / CAP for k in range(1, CAP))]
rings += [(step / PER_TURN, TUBE, 0.0) for step in range(TURNS * PER_TURN + 1)]
rings += [(float(TURNS), radius, -forward) for _, radius, forward in reversed(rings[: CAP - 1])]
vertices = [
    point(turn, 2 * math.pi * side / SIDES, radius, ahead) for turn, radius, ahead in rings for side in range(SIDES)
]
vertices += [point(0.0, 0.0, 0.0, -TUBE), point(float(TURNS), 0.0, 0.0, TUBE)]
first_pole, last_pole = len(vertices) - 1, len(vertices)
faces = []
for ring in range(len(rings) - 1):
    for side in range(SIDES):
        here, beside = SIDES * ring + side + 1, SIDES * ring + (side + 1) % SIDES + 1
        faces += [(here, beside, here + SIDES), (beside, beside + SIDES, here + SIDES)]
for side in range(SIDES):
    beside, last = (side + 1) % SIDES, SIDES * (len(rings) - 1) + 1
    faces += [(side + 1, first_pole, beside + 1), (last + side, last + beside, last_pole)]
lines = [f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in vertices] + [f"f {a} {b} {c}" for a, b, c in faces]
OUTPUT.write_text("\n".join(lines) + "\n")
