"""Surfaces of spheres and capsules, as the coupler adds them to a case for pages."""

import math

AROUND, RINGS = 24, 12
UNIT_M = 1e-10


def with_surfaces(case):
    """A resolved case and the surfaces of its bodies."""
    shapes = {body["name"]: body for body in case.get("bodies") or []}
    for swimmer in case.get("swimmers") or []:
        for name, bead in zip(("B2", "B1", "B3"), swimmer["beads"]):
            shapes[f"{swimmer['name']}.{bead.get('name') or name}"] = bead
    sizes = {name: (shape["radius_m"], shape.get("length_m") or 0) for name, shape in shapes.items()}
    different = list(dict.fromkeys(sizes.values()))
    surfaces = [_surface(*size) for size in different]
    numbers = {name: different.index(size) for name, size in sizes.items()}
    return {**case, "surfaces": {"surfaces": surfaces, "bodies": numbers, "obstacles": []}}


def _surface(radius_m, length_m):
    points, triangles = [], []
    for ring in range(RINGS + 1):
        polar = math.pi * ring / RINGS
        for step in range(AROUND):
            azimuth = 2 * math.pi * step / AROUND
            across = radius_m * math.sin(polar)
            z_m = radius_m * math.cos(polar) + math.copysign(length_m / 2, RINGS / 2 - ring)
            points += [across * math.cos(azimuth), across * math.sin(azimuth), z_m]
            if ring > 0:
                here, beside = ring * AROUND + step, ring * AROUND + (step + 1) % AROUND
                triangles += [here - AROUND, here, beside, here - AROUND, beside, beside - AROUND]
    whole = [round(value / UNIT_M) for value in points]
    return {"radius_m": radius_m, "unit_m": UNIT_M, "points": whole, "triangles": triangles}
