"""A number that is not finite is refused wherever a message can hold one; the fields are read from the schema."""

import math

from copepod_conformance.checks.refusal import refused
from copepod_conformance.fields import field_of, fields_of
from copepod_conformance.protocol import content, message_name
from copepod_conformance.verdicts import Check, Rule

_RULE = Rule("Limits", "a message with a number that is not finite is refused with code 65")
_VALUES = (math.nan, math.inf, -math.inf)


def _poison(path, value):
    return lambda message: field_of(message, path).put(value)


def checks(subject):
    result = []
    for request in (subject.case.setup_request(), subject.case.step_request(0)):
        name = message_name(request)
        for field in fields_of(content(request)):
            if field.is_real:
                result += [
                    Check(
                        "numbers",
                        f"{name}.{field.path} = {value}",
                        _RULE,
                        refused(name, _poison(field.path, value), f"{field.path} = {value}"),
                        thorough=field.is_nested or not math.isnan(value),
                    )
                    for value in _VALUES
                ]
    return result
