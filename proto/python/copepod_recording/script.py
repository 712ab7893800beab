"""What was said to a component, and what it answered: the data lane of one role, request by request."""

from dataclasses import dataclass

from google.protobuf.message import DecodeError

from copepod_recording.reader import message_name

ROLES = {"fluid": 1, "body": 2}
_TO_COMPONENT, _DATA, _CONTROL = 1, 1, 2
_HANDSHAKE = ("Hello", "Welcome", "Refusal", "none")


@dataclass
class Exchange:
    """A request and its reply, both Envelopes; the reply is None if the recording ends before it."""

    name: str
    request: object
    reply: object = None


@dataclass
class Script:
    """A component's part in a recorded run."""

    hello: object = None  # on the data lane; None if it never said one
    exchanges: list = None

    @property
    def restore(self):
        """The Restore that an attempt which went on from a checkpoint began with; None if it began at step 0."""
        return next((exchange.request.restore for exchange in self.exchanges if exchange.name == "Restore"), None)


def script_of(recording, role):
    """Script of "fluid" or "body". Requests that were sent twice count once."""
    script = Script(exchanges=[])
    by_sequence = {}
    for recorded in recording.messages():
        if recorded.role != ROLES[role] or recorded.lane == _CONTROL:
            continue
        try:
            envelope = recording.envelope(recorded)
        except DecodeError:
            continue
        name = message_name(envelope)
        if name == "Hello":
            script.hello = script.hello or envelope.hello
        elif name in _HANDSHAKE or envelope.sequence == 0:
            continue
        elif recorded.direction == _TO_COMPONENT:
            if envelope.sequence not in by_sequence:
                by_sequence[envelope.sequence] = Exchange(name, envelope)
                script.exchanges.append(by_sequence[envelope.sequence])
        elif envelope.sequence in by_sequence:
            by_sequence[envelope.sequence].reply = envelope
    return script
