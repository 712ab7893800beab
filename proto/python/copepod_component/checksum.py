"""Frames: the bytes of an Envelope and their checksum; proto/conversion/seal.hpp in Python."""

import struct

import xxhash

from .errors import Refused
from .schema import Envelope

_TAG = b"\x79"  # field 15, fixed64: the last field of every message
_SIZE = 9


class Damaged(Exception):
    """The checksum is wrong: the frame was damaged on its way and counts as lost."""


def of(content):
    """The nine bytes that follow `content` in a frame."""
    return _TAG + struct.pack("<Q", xxhash.xxh3_64_intdigest(content))


def append_to(content):
    """`content` followed by its checksum."""
    return content + of(content)


def to_bytes(envelope):
    """The frame that carries `envelope`."""
    return append_to(envelope.SerializeToString())


def from_bytes(frame):
    """The Envelope in a frame. Raises Damaged if the checksum is wrong, Refused if the rest is not an Envelope."""
    content = frame[:-_SIZE]
    if frame[-_SIZE:] != of(content):
        raise Damaged(f"its {len(frame)} bytes do not end with their checksum")
    envelope = Envelope()
    try:
        envelope.ParseFromString(content)
    except Exception as error:  # the exception depends on the implementation of protobuf
        raise Refused(f"A message was refused ({error}). Use the same protocol version on both sides.") from error
    return envelope
