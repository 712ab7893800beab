"""Compares two messages field by field: bit by bit, or within a tolerance."""

import math
import struct

# What differs between two runs that are the same: which run it was, and how long it took.
_PER_RUN = {"session_id", "epoch", "attempt", "protocol_minor"}
# … and where it wrote.
_PER_MESSAGE = {
    "Summary": {"seconds", "ranks"},
    "FluidSetup": {"trace_directory"},
    "BodySetup": {"trace_directory", "threads"},
    "FieldOutput": {"directory"},
    "Save": {"path"},
    "Restore": {"path"},
}


def differences(expected, found, tolerance=0.0):
    """Yields "loads.force_N[4] (body 1, y): 1.0 instead of 2.0" for every value that differs.

    `tolerance`: numbers may differ by so much, relative to the larger one; 0 means that every bit counts.
    """
    yield from _message(expected, found, tolerance, "", _PER_RUN)


def _message(expected, found, tolerance, path, ignored):
    for field in expected.DESCRIPTOR.fields:
        if field.name in ignored:
            continue
        name = f"{path}.{field.name}" if path else field.name
        a, b = getattr(expected, field.name), getattr(found, field.name)
        if field.label == field.LABEL_REPEATED:
            if len(a) != len(b):
                yield f"{name}: {len(b)} values instead of {len(a)}"
                continue
            for index, (x, y) in enumerate(zip(a, b)):
                yield from _value(field, x, y, tolerance, f"{name}[{index}]", _meaning(field.name, index))
        elif field.message_type is None:
            yield from _value(field, a, b, tolerance, name)
        elif expected.HasField(field.name) != found.HasField(field.name):
            yield f"{name}: {'missing' if expected.HasField(field.name) else 'not expected'}"
        elif expected.HasField(field.name):
            yield from _value(field, a, b, tolerance, name)


def _value(field, a, b, tolerance, name, meaning=""):
    if field.message_type is not None:
        yield from _message(a, b, tolerance, name, _PER_MESSAGE.get(field.message_type.name, ()))
    elif not _same(a, b, tolerance):
        yield f"{name}{meaning}: {b} instead of {a}"


def _meaning(field, index):
    """Which body's which component; arrays hold three numbers per body, quaternions four."""
    width, axes = (4, "wxyz") if field == "orientation_wxyz" else (3, "xyz")
    if not field.endswith(("_m", "_m_per_s", "_rad_per_s", "_N", "_N_m", "_wxyz")):
        return ""
    return f" (body {index // width}, {axes[index % width]})"


def _same(a, b, tolerance):
    if not isinstance(a, float):
        return a == b
    if struct.pack("<d", a) == struct.pack("<d", b):
        return True
    if tolerance == 0.0 or not (math.isfinite(a) and math.isfinite(b)):
        return False
    return abs(a - b) <= tolerance * max(abs(a), abs(b))
