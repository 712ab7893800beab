"""Message classes, transition table, and the frames that carry Envelopes.

The build generates the package copepod.v1 (build/python); an installed kit has it beside this package.
"""

import importlib
import json
import pathlib
import struct

import xxhash

from .errors import Refused

try:
    Envelope = importlib.import_module("copepod.v1.envelope_pb2").Envelope
    handshake = importlib.import_module("copepod.v1.handshake_pb2")
    control = importlib.import_module("copepod.v1.control_pb2")
    setup = importlib.import_module("copepod.v1.setup_pb2")
    recording = importlib.import_module("copepod.v1.recording_pb2")
except ModuleNotFoundError as missing:
    raise ImportError(
        f"The Python message classes cannot be imported ({missing}). Add the folder that the build generates them in, "
        "build/python, to PYTHONPATH, or use an installed kit."
    ) from missing

_GENERATED = pathlib.Path(str(handshake.__file__)).parent

# One list of rows for components in every language; see proto/session/transition_table.hpp.
TRANSITIONS = json.loads((_GENERATED / "transitions.json").read_text())

# {name: kind} of every feature that a component may announce; see proto/contract/features.hpp.
FEATURES = {row["name"]: row["kind"] for row in json.loads((_GENERATED / "features.json").read_text())}

PROTOCOL_MAJOR = 2
PROTOCOL_MINOR = 0

_TAG = b"\x79"  # field 15, fixed64: the last field of every message
_CHECKSUM_BYTES = 9


class Damaged(Exception):
    """The checksum is wrong: the frame was damaged on its way and counts as lost."""


def envelope(**fields):
    """An Envelope of our protocol version with these fields; a dict stands for a message inside."""
    return Envelope(protocol_major=PROTOCOL_MAJOR, protocol_minor=PROTOCOL_MINOR, **fields)


def message_name(envelope):
    """Name of the message in an Envelope as in the schema, "FluidSetup"; None if it is empty."""
    field = envelope.WhichOneof("body")
    return None if field is None else Envelope.DESCRIPTOR.fields_by_name[field].message_type.name


def transition(role, state, **trigger):
    """The row of the session table for message=… or event=…, or None where the state does not allow it."""
    ((kind, name),) = trigger.items()
    rows = (row for row in TRANSITIONS if row.get(kind) == name)
    return next((row for row in rows if role in row["roles"] and state in row["from"]), None)


def legal_messages(role, state):
    """Names of the messages that the state allows."""
    rows = (row for row in TRANSITIONS if role in row["roles"] and state in row["from"])
    return [row["message"] for row in rows if "message" in row]


def checksum(content):
    """The nine bytes that follow `content` in a frame: tag and XXH3 (64 bits, seed 0, little-endian)."""
    return _TAG + struct.pack("<Q", xxhash.xxh3_64_intdigest(content))


def with_checksum(content):
    """The frame with these bytes."""
    return content + checksum(content)


def to_frame(envelope):
    """The frame that carries `envelope`."""
    return with_checksum(envelope.SerializeToString())


def from_frame(frame):
    """The Envelope in a frame. Raises Damaged if the checksum is wrong, Refused if the rest is not an Envelope."""
    content = frame[:-_CHECKSUM_BYTES]
    if frame[-_CHECKSUM_BYTES:] != checksum(content):
        raise Damaged(f"its {len(frame)} bytes do not end with their checksum")
    envelope = Envelope()
    try:
        envelope.ParseFromString(content)
    except Exception as error:  # the exception depends on the implementation of protobuf
        raise Refused(f"A message was refused ({error}). Use the same protocol version on both sides.") from error
    return envelope
