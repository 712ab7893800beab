#!/usr/bin/python3
"""Fuzzes the reader of recordings: changes, cuts, repeats and splices a small recording, mostly with right checksums.

    tests/fuzz/read_recording.py [--seconds 20 | --executions N] [--seed S]

Whatever the bytes are, the reader either reads or raises UnreadableRecording, and never reads a damaged block. It is
a simple mutational fuzzer, because Debian 12 has none for Python.
"""

import argparse
import os
import random
import struct
import sys
import time
import zlib
from pathlib import Path

from copepod_recording.listing import counts, lines
from copepod_recording.reader import MAGIC, Recording, UnreadableRecording

SEED = Path(__file__).resolve().parent / "corpus/read_recording.rec"


class Bytes(Recording):
    """A recording in memory."""

    def __init__(self, content):
        self._memory = content
        super().__init__("memory")

    def _load(self, path):
        return self._memory


def split(content):
    """Contents of the blocks of a sound recording."""
    place, blocks = len(MAGIC), []
    while place < len(content):
        (length,) = struct.unpack_from("<I", content, place)
        blocks.append(content[place + 8 : place + 8 + length])
        place += 8 + length
    return blocks


def join(blocks):
    return MAGIC + b"".join(struct.pack("<II", len(block), zlib.crc32(block)) + block for block in blocks)


def change(random_, block):
    """One random change of some bytes."""
    if not block:
        return bytes([random_.randrange(256)])
    place, kind = random_.randrange(len(block)), random_.randrange(5)
    if kind == 0:
        return block[:place] + bytes([random_.randrange(256)]) + block[place + 1 :]
    if kind == 1:
        return block[:place]
    if kind == 2:
        return block[:place] + block[place + random_.randrange(1, 9) :]
    if kind == 3:
        return block[:place] + random_.randbytes(random_.randrange(1, 9)) + block[place:]
    return block[:place] + bytes([block[place] ^ (1 << random_.randrange(8))]) + block[place + 1 :]


def mutate(random_, blocks):
    """A damaged recording: in three of four cases inside blocks, behind the checksums."""
    if random_.random() < 0.25:
        return change(random_, join(blocks))
    blocks = list(blocks)
    for _ in range(random_.randrange(1, 4)):
        # The schema is large, and costs much to build; it changes in one of fifty changes.
        target = 0 if random_.random() < 0.02 else random_.randrange(1, len(blocks))
        blocks[target] = change(random_, blocks[target])
    if random_.random() < 0.1:
        random_.shuffle(blocks)
    return join(blocks)


def read(content):
    """Whether it could be read; every other exception than these is a finding."""
    try:
        recording = Bytes(content)
    except UnreadableRecording:
        return False
    for _ in lines(recording):
        pass
    counts(recording)
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
    blocks = split(SEED.read_bytes())
    assert read(join(blocks)), "the seed cannot be read"
    end, executed, readable = time.monotonic() + options.seconds, 0, 0
    while executed < options.executions if options.executions else time.monotonic() < end:
        content = mutate(random_, blocks)
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
