#!/usr/bin/python3
"""The messages are those of their protocol version: schema_MAJOR.MINOR.txt lists every field and value of each version.

    schema_versions_test.py             the list of the present version fits, and no version took anything away
    schema_versions_test.py --write     writes the list of the present version
"""

import re
import sys
import unittest
from pathlib import Path

from copepod_component.messages import PROTOCOL_MAJOR, PROTOCOL_MINOR, Envelope

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PRESENT = HERE / f"schema_{PROTOCOL_MAJOR}.{PROTOCOL_MINOR}.txt"
ADVICE = (
    "the messages are not those of this protocol version (docs/protocol.md, Versions). If it was released, raise the "
    "version in proto/session/messages.hpp and proto/python/copepod_component/messages.py; then run this with --write."
)


def described(message):
    """Lines on all fields of a message, of the messages in it, and on the values of their enumerations."""
    lines, waiting, known = [], [message], set()
    while waiting:
        one = waiting.pop()
        if one.full_name in known:
            continue
        known.add(one.full_name)
        for field in one.fields:
            kind = field.message_type or field.enum_type
            repeated = "repeated " if field.label == field.LABEL_REPEATED else ""
            name = kind.full_name if kind else _SCALARS[field.type]
            lines.append(f"{one.full_name} {field.number} {field.name}: {repeated}{name}")
            waiting += [field.message_type] if field.message_type else []
            lines += (
                [f"{kind.full_name} {value.number} {value.name}" for value in kind.values] if field.enum_type else []
            )
    return sorted(set(lines))


_FIELD = type(Envelope.DESCRIPTOR.fields[0])
_SCALARS = {
    getattr(_FIELD, name): name.removeprefix("TYPE_").lower() for name in dir(_FIELD) if name.startswith("TYPE_")
}


class SchemaVersions(unittest.TestCase):
    def test_messages_are_those_of_the_present_version(self):
        changed = set(described(Envelope.DESCRIPTOR)) ^ set(PRESENT.read_text().splitlines())
        self.assertEqual(changed, set(), ADVICE)

    def test_minor_versions_only_add(self):
        versions = [
            set((HERE / f"schema_{PROTOCOL_MAJOR}.{minor}.txt").read_text().splitlines())
            for minor in range(PROTOCOL_MINOR + 1)
        ]
        for older, newer in zip(versions, versions[1:]):
            self.assertEqual(older - newer, set())

    def test_both_kits_speak_the_same_version(self):
        header = (ROOT / "proto/session/messages.hpp").read_text()
        versions = [int(re.search(rf"kProtocol{part} = (\d+);", header)[1]) for part in ("Major", "Minor")]
        self.assertEqual(versions, [PROTOCOL_MAJOR, PROTOCOL_MINOR])


if __name__ == "__main__":
    if sys.argv[1:] == ["--write"]:
        PRESENT.write_text("\n".join(described(Envelope.DESCRIPTOR)) + "\n")
    else:
        unittest.main()
