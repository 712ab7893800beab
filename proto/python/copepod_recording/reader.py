"""Finds, reads and lists recordings: every record that is whole."""

import pathlib
from collections import Counter

from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.internal.decoder import _DecodeVarint32 as read_length
from google.protobuf.message import DecodeError

from copepod_component.errors import CaseError, Refused, StorageError
from copepod_component.messages import Damaged, from_frame, message_name, recording

_EARLIER_FORMAT = b"\x89CPDREC\n"  # how files of version 1.0 begin
_ROLES = {1: "fluid", 2: "body"}
_LANES = {1: "data", 2: "control"}
_ARROWS = {1: "-->", 2: "<--"}


def party_of(recorded):
    """Whose message it is: "fluid", "body", or the name of a controller; "?" before its Hello."""
    return recorded.name or _ROLES.get(recorded.role, "?")


class UnreadableRecording(StorageError):
    """The file is not a recording, or its header is damaged."""


class Recording:
    """One file: `header`, and its records as messages of recording.proto."""

    def __init__(self, path):
        """Raises UnreadableRecording, OSError."""
        self.path = path
        self.ending = ""  # why reading stopped before the end of the file; known after iterating
        self._content = path.read_bytes()
        if self._content.startswith(_EARLIER_FORMAT):
            raise UnreadableRecording(
                f"{path} cannot be read (it has the format of recordings of version 1.0). Record again, or use the "
                "tools of that version."
            )
        try:
            schema, self._start = self._read(FileDescriptorSet, 0)
        except (DecodeError, IndexError):
            schema = FileDescriptorSet()
        if recording.DESCRIPTOR.name not in (file.name for file in schema.file):
            raise UnreadableRecording(
                f"{path} is not a recording (it does not start like one). Name a file of wire/ or trace/."
            )
        first = next(self._records(), None)
        if first is None or not first.HasField("header"):
            raise UnreadableRecording(f"{path} has no header (cut off, or damaged). Record again.")
        self.header = first.header

    def messages(self):
        """(RecordedMessage, Envelope) of every message, in the order of the file; None for what is not intact."""
        for record in self._records():
            if record.HasField("message"):
                try:
                    yield record.message, from_frame(record.message.envelope)
                except (Damaged, Refused):
                    yield record.message, None

    def phases(self):
        """RecordedPhase of every phase, in the order in which they ended."""
        return (record.phase for record in self._records() if record.HasField("phase"))

    def _records(self):
        """Every record that is whole; `ending` has the reason for stopping before the end of the file."""
        place, self.ending = self._start, ""
        while place < len(self._content):
            try:
                record, end = self._read(recording.Record, place)
                if record.WhichOneof("content") is None:  # as in zeros, which a machine that lost power may leave
                    raise DecodeError
            except (DecodeError, IndexError) as problem:
                self.ending = f"{'cut off' if isinstance(problem, IndexError) else 'damaged'} at byte {place}"
                return
            yield record
            place = end

    def _read(self, kind, place):
        """The message at `place`, behind its length, and where it ends. Raises DecodeError; IndexError if cut off."""
        length, start = read_length(self._content, place)
        if start + length > len(self._content):
            raise IndexError
        return kind.FromString(self._content[start : start + length]), start + length


def recorded(run_directory, key, attempt):
    """What `output.wire` or `output.trace` recorded of an attempt (None: the newest): the file with its messages, the
    folder with the phases of each process. Raises CaseError if there is none."""
    folder = pathlib.Path(run_directory) / key
    found = sorted(folder.glob("attempt_*"))
    if attempt is not None:
        found = [path for path in found if path.stem == f"attempt_{attempt:03d}"]
    if not found:
        raise CaseError(
            f"{folder} holds no recording{f' of attempt {attempt}' if attempt else ''} (the run was not recorded). "
            f"Run the case with --set output.{key}=true."
        )
    return found[-1]


def lines(recording):
    """One line per message: time since the first, component, lane, direction, step, sequence, name, bytes."""
    start = None
    for recorded, envelope in recording.messages():
        start = recorded.time_ns if start is None else start
        about = _name(envelope)
        if envelope:
            again = f", attempt {envelope.attempt}" if envelope.attempt else ""
            about = f"step {envelope.step} #{envelope.sequence}{again} {about}"
        role, lane = party_of(recorded), _LANES.get(recorded.lane, "?")
        yield (
            f"{(recorded.time_ns - start) * 1e-9:13.6f} s  {_ARROWS.get(recorded.direction, '?')} "
            f"{role:5} {lane:7}  {about}, {len(recorded.envelope)} bytes"
        )


def counts(recording):
    """[(component, direction, message, number, bytes)], most bytes first."""
    number: Counter = Counter()
    size: Counter = Counter()
    for recorded, envelope in recording.messages():
        key = (party_of(recorded), "to" if recorded.direction == 1 else "from", _name(envelope))
        number[key] += 1
        size[key] += len(recorded.envelope)
    return [(*key, number[key], size[key]) for key, _ in size.most_common()]


def _name(envelope):
    return (message_name(envelope) or "none") if envelope else "not an intact Envelope"
