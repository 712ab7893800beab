"""The messages of the protocol as Markdown, from the schema that protoc has read, with its comments."""

import re

from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorSet
from sphinx.util import logging

_LOG = logging.getLogger(__name__)
_TYPES = {value: name.removeprefix("TYPE_").lower() for name, value in FieldDescriptorProto.Type.items()}
_MESSAGES, _ENUMS, _FIELDS, _VALUES = 4, 5, 2, 2  # numbers of these fields in the descriptors


def markdown(path):
    """Lines of a page with a table for each message and enumeration of a FileDescriptorSet with source information."""
    for file in FileDescriptorSet.FromString(path.read_bytes()).file:
        comments = {tuple(place.path): _text(place) for place in file.source_code_info.location}
        yield f"\n## {file.name.removeprefix('copepod/v1/')}\n\n[Definitions](../../proto/{file.name})\n"
        remarks = [text for place in file.source_code_info.location for text in place.leading_detached_comments]
        yield from (f"{_escaped(remark)}\n" for remark in remarks)
        for number, message in enumerate(file.message_type):
            yield from _heading(message.name, comments.get((_MESSAGES, number)), file.name)
            fields = (
                (field.name, field.number, _type(message, field), comments.get((_MESSAGES, number, _FIELDS, place), ""))
                for place, field in enumerate(message.field)
            )
            yield from _table(("field", "number", "type", "meaning"), sorted(fields, key=lambda row: row[1]))
        for number, enum in enumerate(file.enum_type):
            yield from _heading(enum.name, comments.get((_ENUMS, number)), file.name)
            values = (
                (value.name, value.number, comments.get((_ENUMS, number, _VALUES, place), ""))
                for place, value in enumerate(enum.value)
            )
            yield from _table(("value", "number", "meaning"), values)


def _heading(name, comment, file):
    if not comment:
        _LOG.warning("%s in %s is not documented. Give it a comment.", name, file)
    yield f"\n### {name}\n\n{_escaped(comment or '')}\n"


def _table(head, rows):
    rows = list(rows)
    if rows:
        yield f"| {' | '.join(head)} |\n|{'---|' * len(head)}"
        for name, *cells, meaning in rows:
            yield f"| `{name}` | {' | '.join(map(str, cells))} | {_escaped(' '.join(meaning.split()))} |"


def _type(message, field):
    """«repeated double», «[Phase](#phase)», «map of string to double»."""
    entry = next((nested for nested in message.nested_type if field.type_name.endswith(f".{nested.name}")), None)
    if entry:
        return f"map of {_TYPES[entry.field[0].type]} to {_TYPES[entry.field[1].type]}"
    name = field.type_name.rpartition(".")[2]
    shown = f"[{name}](#{name.lower()})" if name else _TYPES[field.type]
    choice = "one of " if field.HasField("oneof_index") and not field.proto3_optional else ""
    optional = "optional " if field.proto3_optional else ""
    return choice + optional + ("repeated " if field.label == field.LABEL_REPEATED else "") + shown


def _text(place):
    return re.sub(r"(?m)^ ", "", place.leading_comments + place.trailing_comments).strip()


def _escaped(text):
    return re.sub(r"([|\[\]<*])", r"\\\1", text)
