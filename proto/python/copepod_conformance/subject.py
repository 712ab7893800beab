"""The component under test: what it announces, its case, what an undisturbed run replies; and one life of it, which a
check controls: reach a state, ask, expect."""

import functools
import json
import tempfile
import time
from pathlib import Path

from copepod_component.errors import CaseError
from copepod_component.messages import Envelope, message_name
from copepod_conformance import protocol
from copepod_conformance.cases import BodyCase, ControllerCase, FluidCase
from copepod_conformance.component_process import Component
from copepod_conformance.conversation import CONTROL, DATA, Conversation
from copepod_conformance.protocol import content, describe, part
from copepod_conformance.verdicts import NotApplicable, Violation

STEPS = 6  # of the undisturbed run
SAVED_STEP = 3
_CASES = {"fluid": FluidCase, "body": BodyCase, "controller": ControllerCase}


class Subject(Component):
    def __init__(self, options, environment, folder, context):
        """Raises CaseError if the command does not print its capabilities."""
        super().__init__(options.command, environment, folder, context, options.patience)
        self.role = options.role
        self.capabilities = self._ask()
        self.features = set(self.capabilities.get("features", []))
        self.case = _CASES[self.role](self.features, options.solver)

    @property
    def name(self):
        return self.capabilities.get("name", "") or " ".join(self.command)

    def can(self, feature):
        return feature in self.features

    def require(self, *features):
        """Raises NotApplicable unless the component announces all of them."""
        for feature in features:
            if not self.can(feature):
                raise NotApplicable(f"it does not announce {feature}")

    # Both are made when a check first asks; from Python 3.12 on, each of several threads that ask at once makes one.

    @functools.cached_property
    def reference(self):
        """Of an undisturbed run: content of the replies to STEPS steps, and the digest after them."""
        with Trial(self) as trial:
            trial.configure()
            return trial.advance(STEPS), trial.digest()

    @functools.cached_property
    def checkpoint(self):
        """Path of a checkpoint of the middle of an undisturbed run, and the digest then."""
        with Trial(self) as trial:
            trial.configure(SAVED_STEP)
            digest = trial.digest()
            message = trial.make("Save", Path(tempfile.mkdtemp(dir=self.folder)) / "checkpoint")
            trial.request(message)
            return message.save.path, digest

    def _ask(self):
        try:
            code, answer, words = self.run_to_end("--capabilities")
            if code != 0:
                how = "it did not end" if code is None else f"its exit code is {code}"
                raise ValueError(f"{how}; its last words: {words[:300]}" if words else how)
            capabilities = json.loads(answer)
            if not isinstance(capabilities, dict):
                raise ValueError("the JSON is not an object")
        except (OSError, ValueError) as error:
            raise CaseError(
                f"{' '.join(self.command)} --capabilities does not print what the component can do as JSON ({error}). "
                "See docs/adding_a_component.md."
            ) from error
        if capabilities.get("role") in _CASES and capabilities["role"] != self.role:
            raise CaseError(
                f"{' '.join(self.command)} is a {capabilities['role']} component. Use --role {capabilities['role']}."
            )
        return capabilities


class Trial(Conversation):
    """A coupler that follows the protocol unless a check requests otherwise."""

    def __init__(self, subject, options=()):
        super().__init__(subject, (*options, *(["--name", "pilot"] if subject.role == "controller" else [])))
        self.role, self.case, self.step_name = subject.role, subject.case, protocol.STEP[subject.role]
        self.next_step = 0

    # -- the run of a coupler

    def reach(self, state):
        """Brings the component to `state` by the shortest path; in a busy state the last reply is still to come."""
        path = protocol.paths(self.role)[state]
        busy = protocol.settled(self.role, state) != state  # a component only passes through while it works
        self.await_hello()
        for place, name in enumerate(path):
            if name == "Save":
                self.subject.require("checkpoint")
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

    def digest(self):
        """What it reports of its state."""
        return self.request("Summarise").envelope.summary.digest

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
        if reply.name in ("Loads", "Kinematics", "Action"):
            due = request.step + 1 if name == "AppliedLoads" else request.step
            if header.step != due:
                raise Violation(f"{reply.name} of step {header.step} instead of step {due}")
        if reply.name == "Configured" and self.role == "body":
            self.case.driving_nodes = header.configured.driving_nodes
        return reply

    def expect_undisturbed(self, replies, first=0):
        """These replies, to the steps from `first` on, are those of an undisturbed run."""
        expected, _ = self.subject.reference
        for number, reply in enumerate(replies, first):
            if reply != expected[number]:
                raise Violation(f"a reply to step {number} that differs from the one of an undisturbed run")

    def expect_undisturbed_end(self):
        """The rest of the run is that of an undisturbed one, and so is its digest."""
        first, (_, expected) = self.next_step, self.subject.reference
        self.expect_undisturbed(self.advance(STEPS - first), first)
        if (digest := self.digest()) != expected:
            raise Violation(f"digest {digest:016x} after step {STEPS - 1}, but {expected:016x} in an undisturbed run")

    def expect_failure(self, code, words=(), is_sent=True):
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
