"""Finds and reads recordings: every block that is whole, with the schema that the file itself contains."""

import functools
import itertools
import pathlib
import struct
import zlib

from google.protobuf import descriptor_pb2, descriptor_pool, message, message_factory
from google.protobuf.descriptor import FieldDescriptor

MAGIC = b"\x89CPDREC\n"
_HEAD = struct.Struct("<II")  # length, CRC-32 of the content
_LONGEST_BLOCK = 1 << 29  # twice the largest message

_TEXT, _BYTES, _ENUM = FieldDescriptor.TYPE_STRING, FieldDescriptor.TYPE_BYTES, FieldDescriptor.TYPE_ENUM
_FIXED64, _UINT64, _UINT32 = FieldDescriptor.TYPE_FIXED64, FieldDescriptor.TYPE_UINT64, FieldDescriptor.TYPE_UINT32
_INT32, _SINT64 = FieldDescriptor.TYPE_INT32, FieldDescriptor.TYPE_SINT64
_NEEDED = {  # of the schema that a file brings along; it may hold more
    "Record": {"header": "RecordingHeader", "message": "RecordedMessage", "phase": "RecordedPhase"},
    "RecordingHeader": {"process": _TEXT, "rank": _INT32, "clock": _TEXT, "monotonic_ns": _FIXED64, "utc_ns": _FIXED64},
    "RecordedMessage": {"time_ns": _FIXED64, "direction": _ENUM, "role": _ENUM, "lane": _ENUM, "envelope": _BYTES},
    "RecordedPhase": {"name": _TEXT, "step": _SINT64, "begin_ns": _FIXED64, "duration_ns": _UINT64},
    "Envelope": {
        "session_id": _FIXED64,
        "epoch": _UINT64,
        "sequence": _UINT64,
        "attempt": _UINT32,
        "step": _SINT64,
        "checksum": _FIXED64,
    },
}


class MissingRecording(Exception):
    """The run was not recorded."""


class UnreadableRecording(Exception):
    """The file is not a recording, or its schema or header is damaged."""


class Recording:
    """One file: `header`, and its records as Protocol Buffers messages of the file's own schema."""

    def __init__(self, path):
        """Raises UnreadableRecording, OSError."""
        self.path = path
        self._content = self._load(path)
        self.ending = ""  # why reading stopped before the end of the file; known after iterating
        if not self._content.startswith(MAGIC):
            raise UnreadableRecording(
                f"{path} is not a recording (it does not start like one). Name a file of wire/ or trace/."
            )
        blocks = self._blocks()
        self._classes = _classes_of(next(blocks, b""))
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
        """The Envelope that travelled, without its checksum. Raises DecodeError if it was none."""
        envelope = self._classes["Envelope"]()
        envelope.ParseFromString(recorded.envelope)
        envelope.ClearField("checksum")
        return envelope

    def _records(self, kind):
        for content in itertools.islice(self._blocks(), 1, None):  # the schema comes first
            record = self._parse(content)
            if record is None:
                continue
            if record.WhichOneof("content") == kind:
                yield getattr(record, kind)

    def _parse(self, content):
        record = self._classes["Record"]()
        try:
            record.ParseFromString(content)
        except message.DecodeError:
            return None
        return record

    def _blocks(self):
        """Contents of all whole blocks; `ending` has the reason for stopping before the end of the file."""
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


@functools.lru_cache(maxsize=4)
def _classes_of(schema):
    """Record and Envelope of a serialised FileDescriptorSet. Raises UnreadableRecording if they lack a field."""
    files = descriptor_pb2.FileDescriptorSet()
    try:
        files.ParseFromString(schema)
        pool = descriptor_pool.DescriptorPool()
        for file in files.file:
            pool.Add(file)
        for name, fields in _NEEDED.items():
            descriptor = pool.FindMessageTypeByName(f"copepod.v1.{name}")
            for field, kind in fields.items():
                _require(descriptor.fields_by_name[field], kind)
        factory = message_factory.MessageFactory(pool)
        return {
            name: factory.GetPrototype(pool.FindMessageTypeByName(f"copepod.v1.{name}"))
            for name in ("Record", "Envelope")
        }
    except (message.DecodeError, KeyError, TypeError, ValueError) as problem:
        raise UnreadableRecording(f"the schema is unusable ({problem}). Record again.") from None


def _require(field, kind):
    """Raises ValueError unless the field is of the expected kind: a type, or the name of a message or oneof."""
    single = field.label != field.LABEL_REPEATED
    if isinstance(kind, int):
        fits = field.type == kind
    else:
        fits = field.message_type is not None and field.message_type.full_name == f"copepod.v1.{kind}"
        fits = fits and field.containing_oneof is not None and field.containing_oneof.name == "content"
    if not (single and fits):
        raise ValueError(f"{field.full_name} is of another kind")


def message_name(envelope):
    """Name of the message in an Envelope as in the schema, "Kinematics"; "none" if it is empty."""
    for field, _ in envelope.ListFields():
        if field.containing_oneof is not None and field.message_type is not None:
            return field.message_type.name
    return "none"


def wire_file(run_directory, attempt=None):
    """The recorded messages of an attempt, by default the newest. Raises MissingRecording."""
    return _chosen(pathlib.Path(run_directory) / "wire", "*.rec", attempt, "wire")


def trace_folder(run_directory, attempt=None):
    """The folder with the phases of each process. Raises MissingRecording."""
    return _chosen(pathlib.Path(run_directory) / "trace", "attempt_*", attempt, "trace")


def _chosen(folder, pattern, attempt, key):
    found = sorted(folder.glob(pattern))
    if attempt is not None:
        found = [path for path in found if path.stem == f"attempt_{attempt:03d}"]
    if not found:
        raise MissingRecording(
            f"{folder} holds no recording{f' of attempt {attempt}' if attempt else ''} (the run was not recorded). "
            f"Run the case with --set output.{key}=true."
        )
    return found[-1]
