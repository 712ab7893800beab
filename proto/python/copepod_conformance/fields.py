"""Every field of a message, read from the schema, so that checks of all of them need no list of names."""

import dataclasses

from google.protobuf.descriptor import FieldDescriptor
from google.protobuf.message import Message


@dataclasses.dataclass(frozen=True)
class Field:
    """A field that holds numbers, an enumeration or a text."""

    path: str  # «bodies[1].mass_kg»
    holder: Message
    descriptor: FieldDescriptor

    @property
    def is_list(self):
        return self.descriptor.label == FieldDescriptor.LABEL_REPEATED

    @property
    def is_real(self):
        return self.descriptor.type == FieldDescriptor.TYPE_DOUBLE

    @property
    def is_enumeration(self):
        return self.descriptor.type == FieldDescriptor.TYPE_ENUM

    @property
    def is_nested(self):
        return "." in self.path

    @property
    def entries(self):
        """The list that the field is."""
        return getattr(self.holder, self.descriptor.name)

    def put(self, value):
        """Sets the field, of a list its last entry."""
        if self.is_list:
            self.entries[-1] = value
        else:
            setattr(self.holder, self.descriptor.name, value)


def fields_of(message, path=""):
    """All fields of a message and of what is inside it, empty lists excepted; of a list of messages the last one."""
    for descriptor in message.DESCRIPTOR.fields:
        inside = getattr(message, descriptor.name)
        name = path + descriptor.name
        if descriptor.label == FieldDescriptor.LABEL_REPEATED and not len(inside):
            continue
        if descriptor.type != FieldDescriptor.TYPE_MESSAGE:
            yield Field(name, message, descriptor)
        elif descriptor.label != FieldDescriptor.LABEL_REPEATED:
            yield from fields_of(inside, f"{name}.")
        else:
            yield from fields_of(inside[-1], f"{name}[{len(inside) - 1}].")


def field_of(message, path):
    """The field of that path."""
    return next(field for field in fields_of(message) if field.path == path)
