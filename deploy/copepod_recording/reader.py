"""Reads a recording: every block that is whole, with the schema that the file itself brings along."""

import struct
import zlib

from google.protobuf import descriptor_pb2, descriptor_pool, message, message_factory

MAGIC = b"\x89CPDREC\n"
_HEAD = struct.Struct("<II")  # length, CRC-32 of the content
_LONGEST_BLOCK = 1 << 29  # twice the largest message


class UnreadableRecording(Exception):
    """The file is no recording, or its schema or header is damaged."""


class Recording:
    """One file: `header`, and its records as Protocol Buffers messages of the file's own schema."""

    def __init__(self, path):
        """Raises UnreadableRecording, OSError."""
        self.path = path
        self._content = self._load(path)
        self.ending = ""  # why reading stopped before the end of the file; known after iterating
        if not self._content.startswith(MAGIC):
            raise UnreadableRecording(f"{path} is no recording (it does not start like one). Name a file of wire/ or trace/.")
        blocks = self._blocks()
        self._classes = self._make_classes(next(blocks, b""))
        first = self._parse(next(blocks, b""))
        if first is None or first.WhichOneof("content") != "header":
            raise UnreadableRecording(f"{path} has no header (cut off, or damaged). Record again.")
        self.header = first.header

    def _load(self, path):
        with open(path, "rb") as stream:
            return stream.read()

    def messages(self):
        """RecordedMessage of every message, in the order of the file."""
        return self._records("message")

    def phases(self):
        """RecordedPhase of every phase, in the order in which they ended."""
        return self._records("phase")

    def envelope(self, recorded):
        """The Envelope that travelled. Raises DecodeError if it was none."""
        envelope = self._classes["copepod.v1.Envelope"]()
        envelope.ParseFromString(recorded.envelope)
        return envelope

    def envelope_class(self):
        return self._classes["copepod.v1.Envelope"]

    def _records(self, kind):
        for content in self._blocks():
            record = self._parse(content)
            if record is None:
                continue
            if record.WhichOneof("content") == kind:
                yield getattr(record, kind)

    def _parse(self, content):
        record = self._classes["copepod.v1.Record"]()
        try:
            record.ParseFromString(content)
        except message.DecodeError:
            return None  # the schema, which comes first
        return record

    def _blocks(self):
        """Contents of all whole blocks; says in `ending` why it stopped if that is not the end of the file."""
        place, self.ending = len(MAGIC), ""
        while place < len(self._content):
            if place + _HEAD.size > len(self._content):
                self.ending = f"cut off at byte {place}"
                return
            length, checksum = _HEAD.unpack_from(self._content, place)
            start = place + _HEAD.size
            if length > _LONGEST_BLOCK or start + length > len(self._content):
                self.ending = f"cut off at byte {place}"
                return
            content = self._content[start : start + length]
            if zlib.crc32(content) != checksum:
                self.ending = f"damaged at byte {place}"
                return
            yield content
            place = start + length

    def _make_classes(self, schema):
        files = descriptor_pb2.FileDescriptorSet()
        try:
            files.ParseFromString(schema)
            pool = descriptor_pool.DescriptorPool()
            for file in files.file:
                pool.Add(file)
            factory = message_factory.MessageFactory(pool)
            names = ("copepod.v1.Record", "copepod.v1.Envelope")
            return {name: factory.GetPrototype(pool.FindMessageTypeByName(name)) for name in names}
        except (message.DecodeError, KeyError, TypeError, ValueError) as problem:
            raise UnreadableRecording(f"the schema of {self.path} is unusable ({problem}). Record again.") from None


def message_name(envelope):
    """Name of the message in an Envelope as in the schema, "Kinematics"; "none" if it is empty."""
    field = envelope.WhichOneof("body")
    return "none" if field is None else envelope.DESCRIPTOR.fields_by_name[field].message_type.name
