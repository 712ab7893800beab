"""Bytes from outside never crash a component: what is too large, too short, unknown or not finite is refused."""

import math
import secrets
from functools import partial

from google.protobuf.internal.encoder import _VarintBytes as varint

from copepod_component.messages import Envelope, message_name
from copepod_conformance.cases import AT_CENTRES, actuator, spheres
from copepod_conformance.conversation import CONTROL
from copepod_conformance.protocol import SETUP, STEP, content
from copepod_conformance.verdicts import Check, Rule

_SHAPE = Rule("Limits", "arrays whose lengths do not fit the number of bodies are refused with code 65")
_ENUMERATION = Rule("Limits", "unknown enumeration values are refused with code 65")
_INDEX = Rule("Limits", "indices out of range are refused with code 65")
_TEXT = Rule("Limits", "texts beyond 4096 bytes are refused with code 65")
_COUNT = Rule("Limits", "more than 1 000 000 bodies are refused with code 65")
_FIELDS = Rule("Limits", "field output or actions of no or negative steps are refused with code 65")
_CELLS = Rule("Limits", "negative or more than 10¹² cells are refused with code 65")
_FINITE = Rule("Limits", "a message with a number that is not finite is refused with code 65")
_SIZE = Rule(
    "Limits", "a message beyond 256 MiB is refused with code 65, or breaks the data lane; the control lane stays usable"
)
_BYTES = Rule("Limits", "bytes from outside never crash a process: what is not a message is refused with code 65")

_MOST_BYTES = 256 << 20
_MOST_BODIES = 1_000_000
_NOTICED_S = 3.0
_LONG_TEXT = "x" * 4097
_NO_VALUE = 99  # of any enumeration
_UNKNOWN_MESSAGE = b"\xfa\x3f\x00"  # number 1023 of the Envelope


def _bad_setup(trial, text, changes):
    """A setup with a fault that `text` describes."""
    trial.reach("greeted")
    trial.send(trial.case.setup_request(**changes), f" with {text}")
    trial.expect_failure(65)


def _bad_field(trial, name, path, change, fault):
    """The request `name` after `change` of what a field holds: of its entries, or of the only one."""
    trial.reach("greeted" if name == SETUP[trial.role] else "configured")
    request = trial.make(name)
    holder, field = next((holder, field) for place, holder, field in _fields_of(content(request)) if place == path)
    if field.label == field.LABEL_REPEATED:
        entries = getattr(holder, field.name)
        entries[:] = change(list(entries))
    else:
        setattr(holder, field.name, change([None])[-1])
    trial.send(request, f" with {path} {fault}")
    trial.expect_failure(65)


def _fields_of(message, path=""):
    """(path such as «bodies[1].mass_kg», message that holds it, descriptor) of all fields of a message and inside it.

    Empty lists are left out; of a list of messages the last one counts.
    """
    for field in message.DESCRIPTOR.fields:
        inside, name, is_list = getattr(message, field.name), path + field.name, field.label == field.LABEL_REPEATED
        if is_list and not len(inside):
            continue
        if field.type != field.TYPE_MESSAGE:
            yield name, message, field
        elif is_list:
            yield from _fields_of(inside[-1], f"{name}[{len(inside) - 1}].")
        else:
            yield from _fields_of(inside, f"{name}.")


def _last_is(value):
    return lambda entries: [*entries[:-1], value]


def _spoilt_fields(request):
    """Lists too short and too long, values that no enumeration has; NaN and infinities where a number is.

    --quick also leaves out all fields that are inside another message.
    """
    name = message_name(request)
    for path, _, field in _fields_of(content(request)):
        faults = []  # group, rule, change of the entries, its description, whether --quick leaves it out
        if field.label == field.LABEL_REPEATED and field.type != field.TYPE_STRING:
            faults.append(("limits", _SHAPE, lambda entries: entries[:-1], "too short", False))
            faults.append(("limits", _SHAPE, lambda entries: [*entries, entries[-1]], "too long", False))
        if field.type == field.TYPE_ENUM:
            for number in (_NO_VALUE, 0):
                faults.append(("limits", _ENUMERATION, _last_is(number), f"= {number}", number == 0))
        if field.type == field.TYPE_DOUBLE:
            for value in (math.nan, math.inf, -math.inf):
                faults.append(("numbers", _FINITE, _last_is(value), f"= {value}", math.isinf(value)))
        for group, rule, change, fault, thorough in faults:
            how = (name, path, change, fault)
            yield Check(group, f"{name}.{path} {fault}", rule, _bad_field, how, thorough=thorough or "." in path)


def _raw(trial, data_of, text):
    trial.send_bytes(data_of(trial), text)
    trial.expect_failure(65)


def _truncated(trial):
    """Lacks more bytes than the checksum behind it, which could otherwise be taken for the rest."""
    trial.sequence += 1
    data = trial.with_header(trial.make(trial.step_name)).SerializeToString()
    return data[: len(data) - 20]


def _unknown_message(trial):
    trial.sequence += 1
    return trial.with_header(Envelope(step=0)).SerializeToString() + _UNKNOWN_MESSAGE


def _long_path(trial):
    message = trial.make("Save", trial.folder / _LONG_TEXT)
    trial.send(message, f" with a path of {len(message.save.path)} bytes")
    trial.expect_failure(65)


def _too_many_bodies(trial):
    """Written as bytes: a million messages one by one would take longer than the check."""
    trial.reach("greeted")
    trial.sequence += 1
    message = trial.with_header(trial.make(SETUP[trial.role]))
    inside = content(message)
    one = type(inside)(bodies=inside.bodies[:1])
    many = inside.SerializeToString() + one.SerializeToString() * (_MOST_BODIES + 1 - len(inside.bodies))
    field = Envelope.DESCRIPTOR.fields_by_name[message.WhichOneof("body")].number
    message.ClearField("body")
    data = message.SerializeToString() + varint(field << 3 | 2) + varint(len(many)) + many
    trial.send_bytes(data, f"{SETUP[trial.role]} with {_MOST_BODIES + 1} bodies")
    trial.expect_failure(65)


def _too_large(trial):
    too_large = b"\xfa\x3f" + varint(_MOST_BYTES) + bytes(_MOST_BYTES)
    trial.send_bytes(too_large, f"{len(too_large)} bytes")
    trial.wait(_NOTICED_S)
    if trial.has_mail() or trial.process.exit_code() is not None:
        trial.expect_failure(65)
    else:  # ZeroMQ has dropped the message and its connection; the component must still be in our hands
        trial.answer_to_ping()
        trial.abort(70)
        trial.expect_exit(70)


def _garbage_on_control_lane(trial):
    trial.send_bytes(secrets.token_bytes(200), "200 random bytes", CONTROL)
    trial.answer_to_ping()
    trial.finish()


def checks(subject):
    check, configured = partial(Check, "limits"), partial(Check, "limits", steps=0)
    requests = (subject.case.step_request(0), subject.case.setup_request())
    return [
        *(spoilt for request in requests for spoilt in _spoilt_fields(request)),
        *(check(name, rule, _bad_setup, tuple(how)) for name, rule, *how in _BAD_SETUPS[subject.role]),
        check("a path of more than 4096 bytes", _TEXT, _long_path, needs=("checkpoint",), steps=1),
        configured(
            "random bytes", _BYTES, _raw, (lambda trial: b"\xff" + secrets.token_bytes(200), "201 random bytes")
        ),
        configured("an empty frame", _BYTES, _raw, (lambda trial: b"", "an empty frame")),
        configured(
            "a truncated message", _BYTES, _raw, (_truncated, f"{STEP[subject.role]} without its last 20 bytes")
        ),
        configured("an unknown message", _BYTES, _raw, (_unknown_message, "an Envelope with an unknown message")),
        configured("random bytes on the control lane", _BYTES, _garbage_on_control_lane),
        check("1 000 001 bodies", _COUNT, _too_many_bodies, thorough=True, alone=True),
        configured("a message of 256 MiB", _SIZE, _too_large, thorough=True, alone=True),
    ]


_NAME = {"bodies": spheres({"name": _LONG_TEXT}, {})}
_SPRING: dict = {"springs": [{"body_B": 2, "stiffness_N_per_m": 1.0, **AT_CENTRES}]}  # from body 0
_BEND = {"bends": [{"body_B": 1, "body_C": 2, "stiffness_N_m_per_rad": 1e-12, "rest_angle_rad": 3.0}]}
_ACTUATOR = {"actuators": [actuator("world_force", body_A=2)]}
_NO_STEP = {"fields": {"mean_start": 2, "mean_stop": 2, "mean_every_steps": 1}}

# By role: name of the check, rule, how to describe the setup, and its fields that differ.
_BAD_SETUPS: dict[str, tuple[tuple[str, Rule, str, dict], ...]] = {
    "body": (
        ("a body name of 4097 bytes", _TEXT, "a name of 4097 bytes", _NAME),
        ("a spring to a body that does not exist", _INDEX, "a spring from body 0 to body 2 of 2", _SPRING),
        ("an actuator on a body that does not exist", _INDEX, "an actuator on body 2 of 2", _ACTUATOR),
        ("a bend to a body that does not exist", _INDEX, "a bend of bodies 0, 1 and 2 of 2", _BEND),
    ),
    "controller": (("an action every 0 steps", _FIELDS, "every_steps = 0", {"every_steps": 0}),),
    "fluid": (
        ("a mean of every 0th step", _FIELDS, "a mean of every 0th of steps 0 to 2", {"fields": {"mean_stop": 2}}),
        ("a mean of no step", _FIELDS, "a mean of steps 2 to 2", _NO_STEP),
        ("snapshots every −1 steps", _FIELDS, "fields every −1 steps", {"fields": {"every_steps": -1}}),
        ("a negative number of cells", _CELLS, "32 × −24 × −24 cells", {"domain_cells": (32, -24, -24)}),
        ("2⁹³ cells", _CELLS, "2³¹ × 2³¹ × 2³¹ cells", {"domain_cells": 3 * [2**31]}),
    ),
}
