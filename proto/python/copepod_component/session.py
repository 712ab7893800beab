"""The component's session as a state machine without sockets: proto/session/component_session.hpp in Python."""

from .messages import TRANSITIONS


class Action:
    """What to do about a message: kind is "work", "repeat", "ignore" or "refuse"."""

    def __init__(self, kind, work=None, reply=None, reason=""):
        self.kind, self.work, self.reply, self.reason = kind, work, reply, reason


class Session:
    def __init__(self, role):
        self.role = role
        self.state = "connected"
        self.session_id = 0
        self.epoch = 0
        self.last_sequence = 0
        self.next_step = -1

    def on_message(self, name, envelope):
        """A message arrived on the data lane. Exactly once: a repeated request is answered with the same bytes."""
        if name in ("Welcome", "Refusal"):
            if self.state != "connected":
                return Action("ignore", reason="the handshake is over")
            return self._take(self._find(message=name))
        if self.state == "connected":
            return Action("ignore", reason="the Welcome has not come yet")
        if (envelope.session_id, envelope.epoch) != (self.session_id, self.epoch):
            return Action("ignore", reason="message of another session or of an earlier coupler")
        return self._on_request(name, envelope)

    def on_event(self, event):
        row = self._find(event=event)
        if row is None:
            return Action("ignore", reason="nothing is left to do")
        if event == "work done" and self.state == "stepping":
            self.next_step += 1
        return self._take(row)

    def legal_messages(self):
        rows = [
            row["message"]
            for row in TRANSITIONS
            if "message" in row and self.role in row["roles"] and self.state in row["from"]
        ]
        return ", ".join(rows) or "no message"

    def has_ended(self):
        return self.state in ("done", "failed", "orphaned")

    def _on_request(self, name, envelope):
        if envelope.sequence == 0:
            return self._refuse(f"{name} came without a number (its sequence is 0). Number the requests from 1.")
        if envelope.sequence == self.last_sequence:
            return Action("repeat")
        if envelope.sequence < self.last_sequence:
            return Action("ignore", reason=f"request {envelope.sequence} was answered long ago")
        row = self._find(message=name)
        if row is None:
            return self._refuse(self._illegal(name))
        if envelope.sequence != self.last_sequence + 1:
            return self._refuse(
                f"request {envelope.sequence} came after request {self.last_sequence} "
                "(one in between was lost). Send every request until it is answered."
            )
        if row.get("to") == "stepping" and envelope.step != self.next_step:
            return self._refuse(
                f"{name} of step {envelope.step} came where step {self.next_step} was due "
                "(a step was left out or done twice). Advance step by step."
            )
        if row.get("to") == "configured" or name == "Restore":
            self.next_step = envelope.step
        self.last_sequence = envelope.sequence
        return self._take(row)

    def _find(self, **trigger):
        ((kind, name),) = trigger.items()
        for row in TRANSITIONS:
            if row.get(kind) == name and self.role in row["roles"] and self.state in row["from"]:
                return row
        return None

    def _take(self, row):
        self.state = row.get("to", self.state)
        return Action("work", row["work"], row.get("reply"))

    def _refuse(self, reason):
        self.state = "failed"
        return Action("refuse", reason=reason)

    def _illegal(self, name):
        return (
            f"{name} is not allowed now (a {self.role} component in state '{self.state}' allows "
            f"{self.legal_messages()}). Send the messages in the order of docs/protocol.md."
        )
