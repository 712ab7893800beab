"""Envelopes to and from the bytes of a frame, which end with their checksum: proto/conversion/seal.hpp in Python."""

import struct

import xxhash

from .errors import Refused
from .schema import Envelope

_TAG = b"\x79"  # field 15, fixed64: the last field of every message
_SIZE = 9


class Damaged(Exception):
    """Bytes that changed on their way: to be treated like a message that did not arrive."""


def to_bytes(envelope):
    """The frame that carries `envelope`."""
    return sealed(envelope.SerializeToString())


def sealed(content):
    """`content` with its checksum."""
    return content + _seal(content)


def from_bytes(frame):
    """The Envelope in a frame. Raises Damaged if the checksum does not fit, Refused if it is no Envelope though it does."""
    content = frame[:-_SIZE]
    if frame[-_SIZE:] != _seal(content):
        raise Damaged(f"{len(frame)} bytes do not end with their checksum")
    envelope = Envelope()
    try:
        envelope.ParseFromString(content)
    except Exception as error:  # protobuf raises its own kind per implementation
        raise Refused(f"A message was refused ({error}). Use the same protocol version on both sides.") from error
    return envelope


def _seal(content):
    return _TAG + struct.pack("<Q", xxhash.xxh3_64_intdigest(content))
