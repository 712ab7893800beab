"""A number that is not finite is refused wherever a message can hold one; the fields are read from the schema."""

import math

from google.protobuf.descriptor import FieldDescriptor

from copepod_conformance.protocol import SETUP, STEP, message_name, part
from copepod_conformance.verdicts import Check, Rule

_RULE = Rule("Limits", "a message with a number that is not finite is refused with code 65")


def numbers_of(message, path=""):
    """(path, message, field, index or None) of every floating-point number in it, one per list."""
    for field in message.DESCRIPTOR.fields:
        name = f"{path}{field.name}"
        repeated = field.label == FieldDescriptor.LABEL_REPEATED
        if field.type == FieldDescriptor.TYPE_DOUBLE:
            if not repeated:
                yield name, message, field.name, None
            elif len(getattr(message, field.name)):
                yield name, message, field.name, len(getattr(message, field.name)) - 1
        elif field.type == FieldDescriptor.TYPE_MESSAGE:
            children = getattr(message, field.name)
            if repeated and len(children):
                yield from numbers_of(children[-1], f"{name}[{len(children) - 1}].")
            elif not repeated and message.HasField(field.name):
                yield from numbers_of(children, f"{name}.")


def _poisoned(name, where, value):
    def run(trial):
        trial.reach("greeted" if name == SETUP[trial.role] else "configured")
        message = trial.make(name)
        _, holder, field, index = next(number for number in numbers_of(part(message, name)) if number[0] == where)
        if index is None:
            setattr(holder, field, value)
        else:
            getattr(holder, field)[index] = value
        trial.send(message)
        trial.sent[-1] += f" with {where} = {value}"
        trial.expect_failure(65)
    return run


def checks(subject):
    result = []
    for message, values in ((subject.case.setup_request(), (math.nan, -math.inf)),
                            (subject.case.step_request(0), (math.nan, math.inf, -math.inf))):
        name = message_name(message)
        for where, *_ in numbers_of(part(message, name)):
            for value in values:
                thorough = not math.isnan(value) or (name != STEP[subject.role] and "." in where)
                result.append(Check("numbers", f"{name}.{where} = {value}", _RULE, _poisoned(name, where, value),
                                    thorough=thorough))
    return result
