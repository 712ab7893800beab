#!/usr/bin/python3
"""Fuzzes the reader of recordings: changes, cuts, repeats and splices a small recording, mostly inside its messages.

    tests/fuzz/read_recording.py [--seconds 20 | --executions N] [--seed S]

Whatever the bytes are, the reader either reads or raises UnreadableRecording, and never takes a damaged message for an
intact one. It is a simple mutational fuzzer, because Debian 12 has none for Python.
"""

import argparse
import os
import random
import sys
import time
from pathlib import Path

from google.protobuf.internal.encoder import _VarintBytes as length_bytes
from google.protobuf.message import DecodeError

from copepod_component.messages import recording as schema
from copepod_component.messages import with_checksum
from copepod_recording.reader import Recording, UnreadableRecording, counts, lines, read_length
from copepod_recording.replay import script_of

SEED = Path(__file__).resolve().parent / "corpus/read_recording.rec"


class Content(bytes):
    """What takes the place of a path."""

    def read_bytes(self):
        return self


def split(content):
    """The messages of a sound recording."""
    place, messages = 0, []
    while place < len(content):
        length, start = read_length(content, place)
        place = start + length
        messages.append(content[start:place])
    return messages


def join(messages):
    return b"".join(length_bytes(len(message)) + message for message in messages)


def change(random_, message):
    """One random change of some bytes."""
    if not message:
        return bytes([random_.randrange(256)])
    place, kind = random_.randrange(len(message)), random_.randrange(5)
    if kind == 0:
        return message[:place] + bytes([random_.randrange(256)]) + message[place + 1 :]
    if kind == 1:
        return message[:place]
    if kind == 2:
        return message[:place] + message[place + random_.randrange(1, 9) :]
    if kind == 3:
        return message[:place] + random_.randbytes(random_.randrange(1, 9)) + message[place:]
    return message[:place] + bytes([message[place] ^ (1 << random_.randrange(8))]) + message[place + 1 :]


def change_envelope(random_, message):
    """The record with another Envelope, whose checksum is right; as it is if it holds none."""
    record = schema.Record()
    try:
        record.ParseFromString(message)
    except DecodeError:
        return message
    if record.HasField("message"):
        record.message.envelope = with_checksum(change(random_, record.message.envelope[:-9]))
    return record.SerializeToString()


def mutate(random_, messages):
    """A damaged recording: in three of four cases inside messages, in half of these behind the checksums."""
    if random_.random() < 0.25:
        return change(random_, join(messages))
    messages = list(messages)
    for _ in range(random_.randrange(1, 4)):
        target = random_.randrange(len(messages))
        messages[target] = random_.choice((change, change_envelope))(random_, messages[target])
    if random_.random() < 0.1:
        random_.shuffle(messages)
    return join(messages)


def read(content):
    """Whether it could be read; every other exception than these is a finding."""
    try:
        recording = Recording(Content(content))
    except UnreadableRecording:
        return False
    for recorded, envelope in recording.messages():
        assert envelope is None or recorded.envelope == with_checksum(recorded.envelope[:-9])
    for _ in lines(recording):
        pass
    counts(recording)
    script_of(recording, "fluid")
    for phase in recording.phases():
        str(phase)
    return True


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=20)
    parser.add_argument("--executions", type=int)
    parser.add_argument("--seed", type=int, default=time.time_ns())
    options = parser.parse_args()
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stderr.fileno())  # Protocol Buffers reports every damaged text there
    random_ = random.Random(options.seed)
    messages = split(SEED.read_bytes())
    assert read(join(messages)), "the seed cannot be read"
    end, executed, readable = time.monotonic() + options.seconds, 0, 0
    while executed < options.executions if options.executions else time.monotonic() < end:
        content = mutate(random_, messages)
        try:
            readable += read(content)
        except (Exception, RecursionError) as problem:
            Path("finding.rec").write_bytes(content)
            print(f"read_recording: a finding, finding.rec: {problem!r}")
            return 1
        executed += 1
    print(f"read_recording: {executed} executions ({readable} of them readable), no finding")
    return 0


if __name__ == "__main__":
    sys.exit(main())
