"""Checks messages before a solver sees them; limits as in proto/conversion/limits.hpp."""

import math

from .errors import Refused
from .messages import PROTOCOL_MAJOR, PROTOCOL_MINOR, setup as schema

MESSAGE_BYTES = 256 << 20
ENTRIES = 1_000_000  # of every list in a setup
CELLS = 10**12
STRING_BYTES = 4096
# Of lists in a setup; other lists of numbers are vectors of 3.
_LENGTHS = {"boundaries": (6,), "orientation_wxyz": (4,), "extents_m": (0, 3), "inertia_kg_m2": (0, 6)}
_LONG_TEXTS = {"text", "parameters"}
_OF_ANY_LENGTH = {"profile", "quantities", "region_cells", "faces", "vertices_m", "triangles"}


def check_version(envelope):
    """Raises Refused for a message of another major version."""
    if envelope.protocol_major != PROTOCOL_MAJOR:
        raise _refused(f"it is of protocol version {envelope.protocol_major}, not {PROTOCOL_MAJOR}")


def check_welcome(welcome):
    """Raises Refused for a minor version that our Hello did not offer."""
    if welcome.minor > PROTOCOL_MINOR:
        raise _refused(
            f"the coupler chose protocol {PROTOCOL_MAJOR}.{welcome.minor}, "
            f"this component supports up to {PROTOCOL_MAJOR}.{PROTOCOL_MINOR}"
        )


def check_setup(setup):
    """Raises Refused unless every field of a setup is valid."""
    _check(setup)
    if getattr(setup, "no_slip_plane", 0) > 6:
        raise _refused(f"no_slip_plane is {setup.no_slip_plane}, a domain has 6 faces")
    if hasattr(setup, "fields"):
        _check_fields(setup.fields)
        if min(setup.domain_cells) < 0:
            raise _refused(f"domain_cells is {min(setup.domain_cells)}, less than 0")
        if math.prod(max(1, count) for count in setup.domain_cells) > CELLS:
            raise _refused("domain_cells are more than 10^12 cells")
        for pair in setup.jointed:
            if not pair.body_A < pair.body_B < len(setup.bodies):
                raise _refused(f"a joint is on bodies {pair.body_A} and {pair.body_B} of {len(setup.bodies)}")
    if getattr(setup, "every_steps", 1) < 1:
        raise _refused(f"every_steps is {setup.every_steps}, less than 1")
    if hasattr(setup, "springs"):
        _check_bodies(setup)


def check_text(text, name):
    """Raises Refused for a text that is too long."""
    if len(text.encode()) > STRING_BYTES:
        raise _refused(f"{name} has more than {STRING_BYTES} bytes")


def _check_bodies(setup):
    """Springs, bends, joints and actuators act on bodies that exist."""
    named = [("a spring", [spring.body_A, spring.body_B]) for spring in setup.springs]
    named += [("a bend", [bend.body_A, bend.body_B, bend.body_C]) for bend in setup.bends]
    for joint in setup.joints:
        named.append(("a joint", [joint.body_A] + ([joint.body_B - 1] if joint.body_B else [])))
    for actuator in setup.actuators:
        pair = actuator.kind == schema.ACTUATOR_KIND_PAIR_FORCE
        named.append(("an actuator", [actuator.body_A, actuator.body_B - 1] if pair else [actuator.body_A]))
        if actuator.kind == schema.ACTUATOR_KIND_JOINT_MOTION and not 0 < actuator.joint <= len(setup.joints):
            raise _refused(f"an actuator drives joint {actuator.joint - 1} of {len(setup.joints)}")
    for what, bodies in named:
        if min(bodies) < 0 or max(bodies) >= len(setup.bodies):
            raise _refused(f"{what} is on bodies {' and '.join(map(str, bodies))} of {len(setup.bodies)}")


def _check_fields(fields):
    """Snapshots and the mean must cover at least one step if they are requested."""
    for name in ("every_steps", "mean_start", "mean_stop", "mean_every_steps"):
        if getattr(fields, name) < 0:
            raise _refused(f"fields.{name} is {getattr(fields, name)}, less than 0")
    region = fields.region_cells
    if len(region) not in (0, 6):
        raise _refused(f"fields.region_cells has {len(region)} entries, not 6")
    for start, stop in zip(region[::2], region[1::2]):
        if min(start, stop) < 0 or start >= stop > 0 or (stop == 0 and start > 0):
            raise _refused("fields.region_cells has no cells along an axis")
    if fields.compression > 9:
        raise _refused(f"fields.compression is {fields.compression}, more than 9")
    if fields.mean_stop == 0:
        return
    if fields.mean_start >= fields.mean_stop:
        raise _refused(f"fields.mean_start is {fields.mean_start}, not before mean_stop {fields.mean_stop}")
    if fields.mean_every_steps == 0:
        raise _refused("fields.mean_every_steps of a mean is 0")


def _check(message):
    for field in message.DESCRIPTOR.fields:
        value, name = getattr(message, field.name), field.name
        repeated = field.label == field.LABEL_REPEATED
        if repeated:
            _check_length(field, value)
        entries = value if repeated else (value,)
        if field.type == field.TYPE_MESSAGE:
            if field.containing_oneof and not message.HasField(name):  # optional
                continue
            for entry in entries:
                _check(entry)
        elif field.type == field.TYPE_DOUBLE and not all(map(math.isfinite, entries)):
            raise _refused(f"{name} holds a number that is not finite")
        elif field.type == field.TYPE_ENUM:
            for entry in entries:
                if entry == 0 or entry not in field.enum_type.values_by_number:
                    raise _refused(f"{name} has the unknown value {entry}")
        elif field.type == field.TYPE_STRING and name not in _LONG_TEXTS:
            for entry in entries:
                check_text(entry, name)


def _check_length(field, entries):
    if field.type in (field.TYPE_MESSAGE, field.TYPE_STRING) and field.name not in _LENGTHS:
        if len(entries) > ENTRIES:
            raise _refused(f"{field.name} has {len(entries)} entries, at most {ENTRIES} are allowed")
    elif field.name not in _OF_ANY_LENGTH and len(entries) not in _LENGTHS.get(field.name, (3,)):
        raise _refused(f"{field.name} has {len(entries)} entries, not {_LENGTHS.get(field.name, (3,))[-1]}")


def _refused(why):
    return Refused(f"A message was refused ({why}). Use the same protocol version on both sides.")
