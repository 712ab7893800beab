#!/usr/bin/env python3
"""Writes configs/validation/tube.obj: a tube of bore radius 1 along z, from −0.25 to 5.25, in a square of edge 2.3."""

import math
from pathlib import Path

OUTPUT = Path(__file__).resolve().parents[2] / "configs/validation/tube.obj"
HALF_EDGE, ENDS, SIDES = 1.15, (-0.25, 5.25), 64
BORE = 1 / math.sqrt(SIDES / (2 * math.pi) * math.sin(2 * math.pi / SIDES))  # a polygon with the area of the circle


def corners(side):
    """Of the bore and, in the same direction, of the square."""
    x, y = math.cos(2 * math.pi * side / SIDES), math.sin(2 * math.pi * side / SIDES)
    outside = HALF_EDGE / max(abs(x), abs(y))
    return (BORE * x, BORE * y), (outside * x, outside * y)


vertices = [(*place, z) for side in range(SIDES) for place in corners(side) for z in ENDS]
faces = []
for side in range(SIDES):
    # Low and high end of the bore, of the square; and those of the next side.
    a, b, c, d = range(4 * side + 1, 4 * side + 5)
    e, f, g, h = (4 * ((side + 1) % SIDES) + i for i in range(1, 5))
    for p, q, r, s in ((a, b, f, e), (c, g, h, d), (b, d, h, f), (a, e, g, c)):
        faces += [(p, q, r), (p, r, s)]
lines = [f"v {x:.7f} {y:.7f} {z:.7f}" for x, y, z in vertices] + [f"f {p} {q} {r}" for p, q, r in faces]
OUTPUT.write_text("\n".join(lines) + "\n")
