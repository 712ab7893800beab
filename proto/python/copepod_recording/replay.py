"""Recorded exchanges, played to a real component by `replay`, or to a real coupler by `RecordedComponent`, and compared
with what comes: field by field, bit by bit or within a tolerance."""

import dataclasses
import math
import struct
from pathlib import Path

from copepod_component.errors import CaseError, SolverError
from copepod_component.messages import Envelope, handshake, message_name, recording as schema
from copepod_component.run import Capabilities, serve_component
from copepod_component.solvers import SolverContext
from copepod_conformance.conversation import DATA, Conversation
from copepod_conformance.protocol import HANDSHAKE, ROLE_NUMBER, SETUP, content, part
from copepod_conformance.verdicts import Violation
from copepod_recording.reader import party_of

_END_S = 30.0  # after Finished
# What differs between two runs that are the same: which run it was, how its requests are numbered …
_PER_RUN = {"session_id", "epoch", "sequence", "attempt", "protocol_minor"}
# … how long it took, and where it wrote.
_PER_MESSAGE = {
    "Summary": {"seconds", "ranks"},
    "FluidSetup": {"trace_directory"},
    "BodySetup": {"trace_directory", "threads"},
    "FieldOutput": {"directory"},
    "Save": {"path"},
    "Restore": {"path"},
}


@dataclasses.dataclass
class Exchange:
    """A request and its reply, both Envelopes; the reply is None if the recording ends before it."""

    name: str
    request: object
    reply: object = None


@dataclasses.dataclass
class Script:
    """A component's part in a recorded run: the data lane of one role, request by request."""

    hello: object  # on the data lane; None if there is none
    exchanges: list

    @property
    def restore(self):
        """The Restore at the beginning of an attempt that resumed from a checkpoint; None if it began at step 0."""
        return next((exchange.request.restore for exchange in self.exchanges if exchange.name == "Restore"), None)


def script_of(recording, role):
    """Script of "fluid", "body" or a controller by its name, up to the first damaged message. Requests that were sent
    twice count once."""
    hello, by_sequence = None, dict[int, Exchange]()
    for recorded, envelope in recording.messages():
        if party_of(recorded) != role or recorded.lane == handshake.LANE_CONTROL:
            continue
        if envelope is None:
            recording.ending = f"damaged after {len(by_sequence)} exchanges"
            break
        name = message_name(envelope)
        if name == "Hello":
            hello = hello or envelope.hello
        elif name is None or name in HANDSHAKE or envelope.sequence == 0:
            continue
        elif recorded.direction == schema.DIRECTION_TO_COMPONENT:
            by_sequence.setdefault(envelope.sequence, Exchange(name, envelope))
        elif envelope.sequence in by_sequence:
            by_sequence[envelope.sequence].reply = envelope
    return Script(hello, list(by_sequence.values()))


def replay(component, role, script, tolerance):
    """Plays the coupler of a recorded run to `component` (a Component).

    Yields each Exchange whose reply was recorded, with a text for every value that differs. Raises SolverError if the
    component does not answer, reports a failure or does not exit with 0.
    """
    try:
        kind = role if role in ROLE_NUMBER else "controller"
        with Conversation(component, ["--name", role] if kind == "controller" else []) as conversation:
            conversation.await_hello()
            if conversation.hellos[DATA].envelope.hello.role != ROLE_NUMBER[kind]:
                raise Violation(f"a Hello that is not of a {role} component")
            conversation.welcome()
            for exchange in script.exchanges:
                reply = _ask(conversation, exchange, role)
                if exchange.reply is not None:
                    yield exchange, differences(exchange.reply, reply, tolerance)
            last = script.exchanges[-1]
            if last.name != "Finish":
                _ask(conversation, Exchange("Finish", Envelope(step=last.request.step, finish={})), role)
            if (code := conversation.await_end(_END_S)) != 0:
                raise Violation(conversation.describe_end(code, "0"))
    except (Violation, OSError) as problem:
        raise SolverError(
            f"The {role} component did not answer as a component should ({problem}). See its output, or test it with: "
            "copepod conformance."
        ) from problem


def _ask(conversation, exchange, role):
    """Sends a recorded request in the present session and returns the reply."""
    request = Envelope()
    request.CopyFrom(exchange.request)
    conversation.sequence += 1
    conversation.with_header(request, attempt=0)
    _redirect(request, role, conversation.folder)
    about = f"a reply to {exchange.name} of step {request.step}"
    conversation.send_bytes(request.SerializeToString(), about)
    while True:
        reply = conversation.receive(about).envelope
        if reply.WhichOneof("body") == "failure":
            raise SolverError(f"The {role} component failed at step {reply.failure.step}: {reply.failure.reason}")
        if reply.sequence == request.sequence:
            return reply


def _redirect(request, role, folder):
    """Output of the recorded run must not be overwritten."""
    name = message_name(request)
    if name in SETUP.values():
        content(request).trace_directory = ""
    if name == "FluidSetup":
        request.fluid_setup.fields.directory = str(folder)
    elif name == "Save":
        request.save.path = str(folder / f"{role}_{request.step}")


class RecordedComponent:
    """What the component kit serves: `perform` fills in the recorded reply.

    A request that differs from the recorded one ends the run, since its reply would answer another question.
    """

    def __init__(self, role, script, tolerance):
        self.role = role if role in ROLE_NUMBER else "controller"
        self._tolerance = tolerance
        self._recorded = {(exchange.name, exchange.request.step): exchange for exchange in script.exchanges}

    def perform(self, request, reply):
        name = message_name(request)
        if name == "Save":
            Path(request.save.path).write_bytes(b"")
            reply.saved.SetInParent()
            return
        exchange = self._recorded.get((name, request.step))
        if exchange is None or exchange.reply is None:
            raise SolverError(
                f"{name} of step {request.step} is not in the recording (it ends before; all requests so far were as "
                "recorded). Run fewer steps, or replay an attempt that finished."
            )
        for text in differences(exchange.request, request, self._tolerance):
            raise SolverError(
                f"{name} of step {request.step} is not what was recorded ({text}). "
                "Compare coupler and case with those of the recording."
            )
        reply.step = exchange.reply.step
        part(reply, message_name(exchange.reply)).CopyFrom(content(exchange.reply))

    def follow_up(self, name):
        """Nothing is left to compute."""


def serve_recording(role, recording, tolerance):
    """Takes part in a run as the recorded component; returns the exit code of the process. Raises CaseError."""
    script, path = script_of(recording, role), recording.path
    if script.hello is None:
        raise CaseError(f"{path} has no {role} component (it holds no Hello of one). Record again.")
    if script.restore is not None:
        raise CaseError(
            f"{path.stem} cannot play the {role} component (it resumed from a checkpoint, and a run with a recorded "
            "component starts at step 0). Use --attempt 1, or --fluid or --body to replay it."
        )
    announced = script.hello.capabilities
    features = [name for name in announced.features if name != "estimate"]  # a recording holds replies, not a solver
    capabilities = Capabilities(f"Recorded {announced.name}", announced.version, features)
    return serve_component(RecordedComponent(role, script, tolerance), capabilities, SolverContext())


def differences(expected, found, tolerance=0.0, path="", ignored=_PER_RUN):
    """Yields "loads.force_N[4] (body 1, y): 1.0 instead of 2.0" for every value that differs.

    `tolerance`: numbers may differ by so much, relative to the larger one; 0 means that every bit counts.
    `path`: of the messages, with a dot behind it, where they are parts of others; `ignored`: fields.
    """
    for field in expected.DESCRIPTOR.fields:
        if field.name in ignored:
            continue
        name, is_list = path + field.name, field.label == field.LABEL_REPEATED
        a, b = _values(expected, field), _values(found, field)
        if len(a) != len(b):
            missing = "missing" if len(a) else "not expected"
            yield f"{name}: {len(b)} values instead of {len(a)}" if is_list else f"{name}: {missing}"
            continue
        for index, (x, y) in enumerate(zip(a, b)):
            place = f"{name}[{index}]" if is_list else name
            if field.message_type is not None:
                inside = _PER_MESSAGE.get(field.message_type.name, ())
                yield from differences(x, y, tolerance, f"{place}.", inside)
            elif not _same(x, y, tolerance):
                yield f"{place}{_meaning(field, index)}: {y} instead of {x}"


def _values(message, field):
    """What a field holds, none if it is a message that is missing."""
    value = getattr(message, field.name)
    if field.label == field.LABEL_REPEATED:
        return value
    return [value] if field.message_type is None or message.HasField(field.name) else []


def _meaning(field, index):
    """Which body's which component; arrays hold three numbers per body, quaternions four."""
    is_array = field.label == field.LABEL_REPEATED
    if not (is_array and field.name.endswith(("_m", "_m_per_s", "_rad_per_s", "_N", "_N_m", "_wxyz"))):
        return ""
    width, axes = (4, "wxyz") if field.name == "orientation_wxyz" else (3, "xyz")
    return f" (body {index // width}, {axes[index % width]})"


def _same(a, b, tolerance):
    if not isinstance(a, float):
        return a == b
    if tolerance > 0.0 and math.isclose(a, b, rel_tol=tolerance):
        return True
    return struct.pack("<d", a) == struct.pack("<d", b)
