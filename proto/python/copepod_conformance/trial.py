"""One life of the component under test, controlled by a check: reach a state, ask, expect."""

import time

from copepod_component.messages import Envelope, message_name
from copepod_conformance import protocol
from copepod_conformance.conversation import CONTROL, DATA, Conversation
from copepod_conformance.protocol import content, describe, part
from copepod_conformance.verdicts import NotApplicable, Violation

_REFUSED = 65


class Trial(Conversation):
    """A coupler that follows the protocol unless a check requests otherwise."""

    def __init__(self, subject, options=()):
        super().__init__(subject, options)
        self.role, self.case, self.step_name = subject.role, subject.case, protocol.STEP[subject.role]
        self.next_step = 0

    def require(self, *features):
        """Raises NotApplicable unless the component announces all of them."""
        for feature in features:
            if not self.subject.can(feature):
                raise NotApplicable(f"it does not announce {feature}")

    # -- the run of a coupler

    def reach(self, state):
        """Brings the component to `state` by the shortest path; in a busy state the last reply is still to come."""
        path = protocol.path_to(self.role, state)
        busy = protocol.settled(self.role, state) != state  # a component only passes through while it works
        self.await_hello()
        for place, name in enumerate(path):
            if name == "Save":
                self.require("checkpoint")
            if name == "Welcome":
                self.welcome()
            elif busy and place == len(path) - 1:
                self.send(self.make(name))
            else:
                self.request(name)

    def configure(self, steps=0):
        """The solver exists and has done some steps."""
        self.reach("configured")
        self.advance(steps)

    def make(self, name, path=None):
        """A legal message of that name for the present step; `path`: of the checkpoint that it names."""
        if name == protocol.SETUP[self.role]:
            return self.case.setup_request()
        if name == self.step_name:
            return self.case.step_request(self.next_step)
        message = Envelope(step=self.next_step)
        part(message, name)
        if path or name == "Save":
            content(message).path = str(path or self.folder / "checkpoint")
        return message

    def request(self, what):
        """Sends a request (a name, or an Envelope) and returns the reply, which must be the one in the table."""
        message = self.make(what) if isinstance(what, str) else what
        name = self.send(message)
        return self.expect_reply(name, message)

    def advance(self, steps):
        """Some steps; returns the content of the replies."""
        return [self.request(self.step_name).content for _ in range(steps)]

    def finish(self):
        """The proper end of a run."""
        self.request("Finish")
        self.expect_exit(0)

    def send(self, message, remark="", **changes):
        """Puts the header on and sends; without a `sequence` of its own it is the next request. Returns its name.

        The `remark` follows the message in reports.
        """
        name = message_name(message)
        if "sequence" not in changes:
            self.sequence += 1
            if name == self.step_name:
                self.next_step = message.step + 1
        self.send_bytes(self.with_header(message, **changes).SerializeToString(), describe(message) + remark)
        return name

    # -- expecting

    def expect(self, name, lane=DATA):
        """The next message on the lane, which must be of that name."""
        received = self.receive(name, lane)
        if received.name != name:
            raise Violation(f"{describe(received.envelope)} instead of {name}")
        return received

    def expect_reply(self, name, request):
        """The reply that the table has for the request `name`, with the header of the request."""
        reply = self.expect(protocol.reply_to(name))
        header = reply.envelope
        wanted = (request.sequence, self.session_id, self.epoch)
        if (header.sequence, header.session_id, header.epoch) != wanted:
            raise Violation(
                f"{reply.name} with sequence, session and epoch {header.sequence}, {header.session_id}, "
                f"{header.epoch} instead of {wanted[0]}, {wanted[1]}, {wanted[2]}"
            )
        if reply.name in ("Loads", "Kinematics"):
            due = request.step + 1 if name == "AppliedLoads" else request.step
            if header.step != due:
                raise Violation(f"{reply.name} of step {header.step} instead of step {due}")
        if reply.name == "Configured" and self.role == "body":
            self.case.driving_nodes = header.configured.driving_nodes
        return reply

    def expect_failure(self, code=_REFUSED, words=(), is_sent=True):
        """A Failure with this code and these words, and an end with the same code.

        With `is_sent` False the Failure may be missing: before the Welcome there is no session.
        """
        if not is_sent:
            self.await_end()
        if is_sent or self.has_mail():
            failure = self.expect("Failure").envelope.failure
            if failure.code != code:
                raise Violation(f"a Failure with code {failure.code} instead of {code}: {failure.reason}")
            for word in words:
                if word not in failure.reason:
                    raise Violation(f"a Failure without «{word}»: {failure.reason}")
        self.expect_exit(code)

    def expect_exit(self, *codes, within_s=None):
        """The process ends with one of these codes."""
        code = self.await_end(within_s)
        if code not in codes:
            wanted = codes[0] if len(codes) == 1 else f"one from {codes[0]} to {codes[-1]}"
            raise Violation(self.describe_end(code, wanted))

    def answer_to_ping(self):
        """The Pong to a ping of one's own, and how long it took at most."""
        start, stamp_ns = time.monotonic(), self.ping()
        while (pong := self.expect("Pong", CONTROL).envelope.pong).stamp_ns != stamp_ns:
            pass
        return pong, time.monotonic() - start
