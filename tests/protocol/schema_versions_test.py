#!/usr/bin/python3
"""The promise of docs/protocol.md, Versions: what was released in tests/released stays readable, and is only added to.

    schema_versions_test.py             the messages and vectors are those of this version, and break no earlier one
    schema_versions_test.py --write     keeps those of this version; refuses to replace files, so remove those of a
                                        version that no release has yet
"""

import json
import re
import subprocess
import sys
import unittest
from pathlib import Path

from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorSet
from google.protobuf.json_format import MessageToDict

from copepod_component.messages import PROTOCOL_MAJOR, PROTOCOL_MINOR, from_frame, to_frame

ROOT = Path(__file__).resolve().parents[2]
RELEASED = ROOT / "tests/released"
VECTORS = ROOT / "docs/protocol_vectors.json"
SCHEMA = "copepod/v1/envelope.proto"  # imports the others
ADVICE = (
    "the messages are not those of this protocol version (docs/protocol.md, Versions). If it was released, raise the "
    "version in proto/session/messages.hpp and proto/python/copepod_component/messages.py; then run this with --write."
)
_TYPES, _LABELS = FieldDescriptorProto.Type.Name, FieldDescriptorProto.Label.Name


def kept(minor):
    """(descriptors, vectors) of a minor version, as paths."""
    name = f"protocol_{PROTOCOL_MAJOR}.{minor}"
    return RELEASED / f"{name}.binpb", RELEASED / f"{name}_vectors.json"


def present_bytes():
    """The descriptor set of what travels, in the form that `protoc` and `buf` write and read."""
    command = ["protoc", "--proto_path=proto", "--include_imports", "--descriptor_set_out=/dev/stdout"]
    return subprocess.run([*command, SCHEMA], cwd=ROOT, check=True, capture_output=True).stdout


def elements(descriptors):
    """{element: {property: value}}: whatever disappears or changes here breaks who relies on it."""
    found = {}
    for file in descriptors.file:
        for message in file.message_type:
            found |= _of_message(message, file.package)
        for enum in file.enum_type:
            found |= _of_enum(enum, file.package)
    return found


def _of_message(message, scope):
    name = f"{scope}.{message.name}"
    found = {f"message {name}": {}}
    for field in message.field:
        found[f"field {field.number} of {name}"] = {
            "name": field.name,
            "JSON name": field.json_name,
            "type": f"{_TYPES(field.type)} {field.type_name}".rstrip(),
            "label": _LABELS(field.label),
            "oneof": message.oneof_decl[field.oneof_index].name if field.HasField("oneof_index") else None,
            "presence": field.proto3_optional,
            "packed": field.options.packed if field.options.HasField("packed") else None,
        }
    found |= {f"reserved number {n} of {name}": {} for r in message.reserved_range for n in range(r.start, r.end)}
    for nested in message.nested_type:
        found |= _of_message(nested, name)
    for enum in message.enum_type:
        found |= _of_enum(enum, name)
    return found


def _of_enum(enum, scope):
    name = f"{scope}.{enum.name}"
    return {f"enum {name}": {}} | {f"value {v.number} of {name}": {"name": v.name} for v in enum.value}


def breaking_changes(older, newer):
    """Sentences on what `newer` takes from those who rely on `older`; additions are none."""
    before, after = elements(older), elements(newer)
    found = [f"{element} is gone" for element in before if element not in after]
    for element in before.keys() & after.keys():
        for name, value in before[element].items():
            if after[element][name] != value:
                found.append(f"{element}: {name} was {value}, is {after[element][name]}")
    return sorted(found)


def find(descriptors, path):
    """(list that holds it, descriptor) of "Message", "Message.field", "Enum" or "Enum.VALUE"."""
    name, _, part = path.partition(".")
    for file in descriptors.file:
        for holder in (file.message_type, file.enum_type):
            for one in holder:
                if one.name == name:
                    parts = one.field if hasattr(one, "field") else one.value
                    return (parts, next(p for p in parts if p.name == part)) if part else (holder, one)
    raise KeyError(path)


def removed(path):
    def change(descriptors):
        holder, one = find(descriptors, path)
        holder.remove(one)

    return change


def changed(path, **properties):
    """None: the property is cleared."""

    def change(descriptors):
        one = find(descriptors, path)[1]
        for name, value in properties.items():
            one.ClearField(name) if value is None else setattr(one, name, value)

    return change


def unpacked(descriptors):
    find(descriptors, "Kinematics.position_m")[1].options.packed = False


def all_that_a_minor_version_may_add(descriptors):
    message = find(descriptors, "Ping")[0].add(name="Hint")
    envelope = find(descriptors, "Envelope")[1]
    kind = {"type": F.TYPE_MESSAGE, "type_name": f".copepod.v1.{message.name}", "oneof_index": 0}
    envelope.field.add(name="hint", json_name="hint", number=64, label=F.LABEL_OPTIONAL, **kind)
    envelope.field.add(name="extra", json_name="extra", number=8, label=F.LABEL_OPTIONAL, type=F.TYPE_UINT64)
    envelope.reserved_range.add(start=70, end=72)
    find(descriptors, "Lane")[1].value.add(name="LANE_OTHER", number=3)


F = FieldDescriptorProto
# What happens to the schema, which reserves number 9 of Welcome for this test; how it is done; what is found.
BREAKING = (
    ("field removed", removed("Hello.ranks"), "field 8 of Hello is gone"),
    ("field renumbered", changed("Hello.ranks", number=88), "field 8 of Hello is gone"),
    ("field renamed", changed("Ping.stamp_ns", name="stamp"), "field 1 of Ping: name was stamp_ns, is stamp"),
    ("number reused", changed("Hello.ranks", name="age", type=F.TYPE_BOOL), "field 8 of Hello: name was ranks, is age"),
    ("JSON name", changed("Ping.stamp_ns", json_name="ns"), "field 1 of Ping: JSON name was stampNs, is ns"),
    (
        "type",
        changed("Envelope.sequence", type=F.TYPE_SINT64),
        "field 5 of Envelope: type was TYPE_UINT64, is TYPE_SINT64",
    ),
    (
        "message inside",
        changed("Envelope.pong", type_name=".copepod.v1.Ping"),
        "field 61 of Envelope: type was TYPE_MESSAGE .copepod.v1.Pong, is TYPE_MESSAGE .copepod.v1.Ping",
    ),
    (
        "label",
        changed("Hello.host", label=F.LABEL_REPEATED),
        "field 6 of Hello: label was LABEL_OPTIONAL, is LABEL_REPEATED",
    ),
    ("oneof left", changed("Envelope.ping", oneof_index=None), "field 60 of Envelope: oneof was body, is None"),
    ("oneof joined", changed("Envelope.epoch", oneof_index=0), "field 4 of Envelope: oneof was None, is body"),
    (
        "no presence",
        changed("Summary.mass_drift", proto3_optional=False),
        "field 7 of Summary: presence was True, is False",
    ),
    ("no longer packed", unpacked, "field 1 of Kinematics: packed was None, is False"),
    ("message removed", removed("Refusal"), "message Refusal is gone"),
    ("message renamed", changed("Refusal", name="Rejection"), "message Refusal is gone"),
    ("enumeration removed", removed("Lane"), "enum Lane is gone"),
    ("value removed", removed("Lane.LANE_CONTROL"), "value 2 of Lane is gone"),
    ("value renumbered", changed("Lane.LANE_CONTROL", number=7), "value 2 of Lane is gone"),
    ("value renamed", changed("Lane.LANE_CONTROL", name="B"), "value 2 of Lane: name was LANE_CONTROL, is B"),
    ("reserved number free", changed("Welcome", reserved_range=None), "reserved number 9 of Welcome is gone"),
)


class BreakingChanges(unittest.TestCase):
    def found(self, change):
        older = FileDescriptorSet.FromString(present_bytes())
        find(older, "Welcome")[1].reserved_range.add(start=9, end=10)
        newer = FileDescriptorSet.FromString(older.SerializeToString())
        change(newer)
        return [sentence.replace(" copepod.v1.", " ") for sentence in breaking_changes(older, newer)]

    def test_each_kind_is_found(self):
        for name, change, sentence in BREAKING:
            with self.subTest(name):
                self.assertIn(sentence, self.found(change))

    def test_every_property_has_a_change_that_it_finds(self):
        properties = {name for of in elements(FileDescriptorSet.FromString(present_bytes())).values() for name in of}
        sentences = " ".join(sentence for _, _, sentence in BREAKING)
        self.assertEqual([name for name in properties if f": {name} was" not in sentences], [])

    def test_additions_are_allowed(self):
        self.assertEqual(self.found(all_that_a_minor_version_may_add), [])


class SchemaVersions(unittest.TestCase):
    def test_messages_are_those_of_the_present_version(self):
        present, listed = (
            elements(FileDescriptorSet.FromString(content))
            for content in (present_bytes(), kept(PROTOCOL_MINOR)[0].read_bytes())
        )
        self.assertEqual(present, listed, ADVICE)

    def test_minor_versions_only_add(self):
        versions = [kept(minor)[0].read_bytes() for minor in range(PROTOCOL_MINOR + 1)] + [present_bytes()]
        for older, newer in zip(map(FileDescriptorSet.FromString, versions), versions[1:]):
            self.assertEqual(breaking_changes(older, FileDescriptorSet.FromString(newer)), [])

    def test_vectors_of_every_version_decode_and_encode_to_the_same_bytes(self):
        """In C++: tests/unit/proto/conversion/released_vectors_test.cpp."""
        for minor in range(PROTOCOL_MINOR + 1):
            vectors = json.loads(kept(minor)[1].read_text())["vectors"]
            listed = FileDescriptorSet.FromString(kept(minor)[0].read_bytes())
            body = [f.type_name for f in find(listed, "Envelope")[1].field if f.HasField("oneof_index")]
            self.assertEqual({f".copepod.v1.{vector['message']}" for vector in vectors}, set(body))
            for vector in vectors:
                with self.subTest(minor=minor, message=vector["message"]):
                    envelope = from_frame(bytes.fromhex(vector["frame"]))
                    self.assertEqual(MessageToDict(envelope, preserving_proto_field_name=True), vector["envelope"])
                    self.assertEqual(to_frame(envelope).hex(), vector["frame"])

    def test_the_page_has_the_vectors_of_the_present_version(self):
        self.assertEqual(VECTORS.read_text(), kept(PROTOCOL_MINOR)[1].read_text(), ADVICE)

    def test_both_kits_speak_the_same_version(self):
        header = (ROOT / "proto/session/messages.hpp").read_text()
        versions = [int(re.search(rf"kProtocol{part} = (\d+);", header)[1]) for part in ("Major", "Minor")]
        self.assertEqual(versions, [PROTOCOL_MAJOR, PROTOCOL_MINOR])


def write():
    """Keeps the descriptors and vectors of this version."""
    for path, content in zip(kept(PROTOCOL_MINOR), (present_bytes(), VECTORS.read_bytes())):
        if path.exists():
            sys.exit(f"{path} exists (what was released stays). Remove it if no release has this version yet.")
        path.write_bytes(content)


if __name__ == "__main__":
    if sys.argv[1:] == ["--write"]:
        write()
    else:
        unittest.main()
