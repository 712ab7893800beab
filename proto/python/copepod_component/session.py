"""The component's session as a state machine without sockets: proto/session/component_session.hpp in Python."""

from .errors import Refused
from .messages import legal_messages, transition


class Session:
    def __init__(self, role):
        self.role = role
        self.state = "connected"
        self.session_id = 0
        self.epoch = 0
        self.last_sequence = 0
        self.next_step = -1

    def on_message(self, name, envelope):
        """What to do about a message on the data lane: "work", "repeat" (send the same bytes again) or "ignore", and
        why. Raises Refused for one that ends the component.
        """
        if name in ("Welcome", "Refusal"):
            if self.state != "connected":
                return "ignore", "the handshake is over"
            return self._take(transition(self.role, self.state, message=name))
        if self.state == "connected":
            return "ignore", "the Welcome has not come yet"
        if (envelope.session_id, envelope.epoch) != (self.session_id, self.epoch):
            return "ignore", "message of another session or of an earlier coupler"
        return self._on_request(name, envelope)

    def on_event(self, event):
        row = transition(self.role, self.state, event=event)
        if event == "work done" and self.state == "stepping":
            self.next_step += 1
        if row is not None:
            self._take(row)

    def has_ended(self):
        return self.state in ("done", "failed", "orphaned")

    def _on_request(self, name, envelope):
        if envelope.sequence == 0:
            raise Refused(f"{name} came without a number (its sequence is 0). Number the requests from 1.")
        if envelope.sequence == self.last_sequence:
            return "repeat", ""
        if envelope.sequence < self.last_sequence:
            return "ignore", f"request {envelope.sequence} was answered long ago"
        row = transition(self.role, self.state, message=name)
        if row is None:
            legal = ", ".join(legal_messages(self.role, self.state)) or "no message"
            raise Refused(
                f"{name} is not allowed now (a {self.role} component in state '{self.state}' allows {legal}). "
                "Send the messages in the order of docs/protocol.md."
            )
        if envelope.sequence != self.last_sequence + 1:
            raise Refused(
                f"request {envelope.sequence} came after request {self.last_sequence} "
                "(one in between was lost). Send every request until it is answered."
            )
        is_early = envelope.step < self.next_step if name == "Observation" else envelope.step != self.next_step
        if row.get("to") == "stepping" and is_early:
            raise Refused(
                f"{name} of step {envelope.step} came where step {self.next_step} was due "
                "(a step was left out or done twice). Advance step by step."
            )
        if row.get("to") == "configured" or name in ("Restore", "Observation"):
            self.next_step = envelope.step
        self.last_sequence = envelope.sequence
        return self._take(row)

    def _take(self, row):
        self.state = row.get("to", self.state)
        return "work", ""
