"""Bytes from outside never crash a component: what is too large, too short or unknown is refused."""

import secrets

from google.protobuf.descriptor import FieldDescriptor

from copepod_conformance.lanes import CONTROL
from copepod_conformance.protocol import Envelope, SETUP, STEP, message_name, part
from copepod_conformance.verdicts import Check, NotApplicable, Rule, Silence, Violation

_SHAPE = Rule("Limits", "arrays whose lengths do not fit the number of bodies are refused with code 65")
_ENUMERATION = Rule("Limits", "unknown enumeration values are refused with code 65")
_INDEX = Rule("Limits", "indices out of range are refused with code 65")
_TEXT = Rule("Limits", "texts beyond 4096 bytes are refused with code 65")
_COUNT = Rule("Limits", "more than 1 000 000 bodies are refused with code 65")
_SIZE = Rule("Limits", "a message beyond 256 MiB is refused: by a Failure, or by breaking the connection; nothing crashes")
_BYTES = Rule("Limits", "bytes from outside never crash a process: what is no message is refused with code 65")

_MOST_BYTES = 256 << 20
_MOST_BODIES = 1_000_000
_LONG_TEXT = "x" * 4097
_NO_VALUE = 99  # of any enumeration
_UNKNOWN_MESSAGE = b"\xfa\x3f\x00"  # number 1023 of the Envelope


def _refused(name, change, text):
    """The message `name`, changed so that it must be refused."""
    def run(trial):
        trial.reach("greeted" if name == SETUP[trial.role] else "configured")
        message = trial.make(name)
        change(part(message, name))
        trial.send(message)
        trial.sent[-1] += f" with {text}"
        trial.expect_failure(65)
    return run


def _lists(message):
    """Names of the fields of a message that are lists of numbers."""
    return [field.name for field in message.DESCRIPTOR.fields
            if field.label == FieldDescriptor.LABEL_REPEATED and field.type != FieldDescriptor.TYPE_MESSAGE]


def _shorter(field):
    return lambda content: getattr(content, field).pop()


def _longer(field):
    return lambda content: getattr(content, field).append(getattr(content, field)[-1])


def _list_checks(message, every):
    name = message_name(message)
    for field in _lists(part(message, name)):
        for change, text in ((_shorter, "too short"), (_longer, "too long")):
            yield Check("limits", f"{name}.{field} {text}", _SHAPE, _refused(name, change(field), f"{field} {text}"),
                        thorough=not every)


def _enumerations(message, path=""):
    """(path, function that sets the value) of every enumeration in a message, one per list."""
    for field in message.DESCRIPTOR.fields:
        name = path + field.name
        if field.type == FieldDescriptor.TYPE_ENUM:
            yield name
        elif field.type == FieldDescriptor.TYPE_MESSAGE:
            children = getattr(message, field.name)
            repeated = field.label == FieldDescriptor.LABEL_REPEATED
            if repeated and len(children) or not repeated and message.HasField(field.name):
                yield from _enumerations(children[-1] if repeated else children, f"{name}.")


def _set_enumeration(path, value):
    def change(content):
        *parents, last = path.split(".")
        for name in parents:
            content = getattr(content, name)
            content = content if hasattr(content, "DESCRIPTOR") else content[-1]
        setattr(content, last, value)
    return change


def _enumeration_checks(setup):
    name = message_name(setup)
    for path in _enumerations(part(setup, name)):
        for value in (_NO_VALUE, 0):
            yield Check("limits", f"{name}.{path} = {value}", _ENUMERATION,
                        _refused(name, _set_enumeration(path, value), f"{path} = {value}"),
                        thorough=value == 0 or "." in path)


def _raw(data_of, text):
    def run(trial):
        trial.configure()
        trial.send_bytes(data_of(trial), text)
        trial.expect_failure(65)
    return run


def _truncated(trial):
    trial.sequence += 1
    data = trial.with_header(trial.make(trial.step_name)).SerializeToString()
    return data[:len(data) - 7]


def _unknown_message(trial):
    trial.sequence += 1
    return trial.with_header(Envelope(step=0)).SerializeToString() + _UNKNOWN_MESSAGE


def _long_path(trial):
    if not trial.subject.can("checkpoint"):
        raise NotApplicable("it does not announce checkpoint")
    trial.configure()
    trial.advance(1)
    message = trial.make("Save")
    message.save.path = f"{trial.folder}/{_LONG_TEXT}"
    trial.send(message)
    trial.sent[-1] += f" with a path of {len(message.save.path)} bytes"
    trial.expect_failure(65)


def _too_many_bodies(trial):
    """Written as bytes: a million messages one by one would take longer than the check."""
    trial.reach("greeted")
    trial.sequence += 1
    message = trial.with_header(trial.make(SETUP[trial.role]))
    content = part(message, SETUP[trial.role])
    one = type(content)()
    one.bodies.append(content.bodies[0])
    many = content.SerializeToString() + one.SerializeToString() * (_MOST_BODIES + 1 - len(content.bodies))
    field = Envelope.DESCRIPTOR.fields_by_name[message.WhichOneof("body")].number
    message.ClearField("body")
    data = message.SerializeToString() + _varint(field << 3 | 2) + _varint(len(many)) + many
    trial.send_bytes(data, f"{SETUP[trial.role]} with {_MOST_BODIES + 1} bodies")
    trial.expect_failure(65)


def _varint(number):
    result = bytearray()
    while number > 0x7F:
        result.append(number & 0x7F | 0x80)
        number >>= 7
    return bytes([*result, number])


def _too_large(trial):
    trial.configure()
    trial.send_bytes(b"\xfa\x3f" + _varint(_MOST_BYTES) + bytes(_MOST_BYTES), f"{_MOST_BYTES + 7} bytes")
    try:
        trial.expect_failure(65)
    except Silence:
        pass  # the message was dropped with its connection, which both sides make again
    else:
        return
    if trial.process.exit_code() is not None:
        raise Violation("neither a Failure nor a component that goes on")
    trial.advance(1)
    trial.finish()


def _garbage_on_control_lane(trial):
    trial.configure()
    trial.send_bytes(secrets.token_bytes(200), "200 random bytes", CONTROL)
    trial.receive_pong(trial.ping())
    trial.finish()


def checks(subject):
    setup, step = subject.case.setup_request(), subject.case.step_request(0)
    result = [*_list_checks(step, every=True), *_list_checks(setup, every=False), *_enumeration_checks(setup)]
    if subject.role == "body":
        result += [
            Check("limits", "a body name of 4097 bytes", _TEXT, _refused(
                SETUP["body"], lambda content: setattr(content.bodies[0], "name", _LONG_TEXT), "a name of 4097 bytes")),
            Check("limits", "a spring to a body that does not exist", _INDEX, _refused(
                SETUP["body"], _spring_to_nowhere, "a spring from body 0 to body 2 of 2")),
        ]
    return result + [
        Check("limits", "a path of more than 4096 bytes", _TEXT, _long_path),
        Check("limits", "random bytes", _BYTES, _raw(lambda trial: b"\xff" + secrets.token_bytes(200), "201 random bytes")),
        Check("limits", "an empty frame", _BYTES, _raw(lambda trial: b"", "an empty frame")),
        Check("limits", "a truncated message", _BYTES, _raw(_truncated, f"{STEP[subject.role]} without its last 7 bytes")),
        Check("limits", "an unknown message", _BYTES, _raw(_unknown_message, "an Envelope with an unknown message")),
        Check("limits", "random bytes on the control lane", _BYTES, _garbage_on_control_lane),
        Check("limits", "1 000 001 bodies", _COUNT, _too_many_bodies, thorough=True),
        Check("limits", "a message of 256 MiB", _SIZE, _too_large, thorough=True, alone=True),
    ]


def _spring_to_nowhere(content):
    content.springs.add(body_A=0, body_B=2, stiffness_N_per_m=1.0, anchor_A_m=[0, 0, 0], anchor_B_m=[0, 0, 0])
