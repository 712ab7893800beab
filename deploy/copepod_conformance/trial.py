"""One life of the component under test, and the coupler that it talks to."""

import secrets
import shutil
import tempfile
import time
from pathlib import Path

from copepod_conformance import protocol
from copepod_conformance.component_process import ComponentProcess
from copepod_conformance.lanes import CONTROL, DATA, Lanes
from copepod_conformance.protocol import Envelope, PROTOCOL_MAJOR, PROTOCOL_MINOR, describe, part
from copepod_conformance.verdicts import NotApplicable, Silence, Violation

_PING_EVERY_S = 0.5
_SLICE_S = 0.05
_REFUSED = 65


class Trial:
    """Starts the component on entry and leaves nothing of it on exit. Every wait ends by itself."""

    def __init__(self, subject, options=()):
        self.subject, self.role, self.case = subject, subject.role, subject.case
        self.step_name = protocol.STEP[subject.role]
        self.folder = Path(tempfile.mkdtemp(prefix="copepod-conformance-"))
        self.log = self.folder / "component.log"
        self.token = secrets.token_hex(8)
        self.session_id, self.epoch = secrets.randbits(63), 1
        self.sequence, self.next_step = 0, 0
        self.hellos, self.sent = {}, []
        self._inbox = {DATA: [], CONTROL: []}
        self._last_ping = None  # no pings before the Welcome
        self._lanes = Lanes(subject.context, f"ipc://{self.folder}/coupler.ipc")
        connection = ["--endpoint", f"ipc://{self.folder}/coupler.ipc", "--session", self.token,
                      "--log-file", str(self.log), *options]
        self.process = ComponentProcess([*subject.command, *connection], subject.environment, self.folder / "terminal")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._lanes.close()
        self.process.end()
        shutil.rmtree(self.folder, ignore_errors=True)

    # -- the run of a coupler ------------------------------------------------------------------------------------

    def greet(self):
        """Waits for the Hello on both lanes."""
        self._pump(lambda: len(self.hellos) == 2, "a Hello on both lanes")

    def welcome(self, **changes):
        """Welcomes both lanes; `changes` are fields of the Envelope, or `minor` of the Welcome."""
        minor = changes.pop("minor", PROTOCOL_MINOR)
        for lane in (CONTROL, DATA):
            message = Envelope(**{"protocol_major": PROTOCOL_MAJOR, "protocol_minor": PROTOCOL_MINOR, "step": -1,
                                  **changes})
            message.welcome.minor, message.welcome.session_id = minor, self.session_id
            message.welcome.epoch = self.epoch
            self._lanes.send(lane, message.SerializeToString())
        self.sent.append("Welcome on both lanes")
        self._last_ping = 0.0

    def reach(self, state):
        """Brings the component to `state` by the shortest path; in a busy state the last reply is still to come."""
        path = protocol.path_to(self.role, state)
        busy = protocol.is_busy(self.role, state)
        self.greet()
        for place, name in enumerate(path):
            if name == "Welcome":
                self.welcome()
            elif name == "Refusal":
                raise NotApplicable("it has ended by then")
            elif busy and place == len(path) - 1:
                self.send(self.make(name))
            else:
                self.request(name)

    def configure(self):
        self.reach("configured")
        return self

    def make(self, name):
        """A legal message of that name for the present step."""
        if name == protocol.SETUP[self.role]:
            return self.case.setup_request()
        if name == self.step_name:
            return self.case.step_request(self.next_step)
        message = Envelope(step=self.next_step)
        content = part(message, name)
        if name == "Save":
            content.path = str(self.folder / "checkpoint")
        return message

    def request(self, what):
        """Sends a request (a name, or an Envelope) and returns the reply, which must be the one that the table says."""
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

    # -- sending ------------------------------------------------------------------------------------------------

    def send(self, message, **changes):
        """Puts the header on and sends; without a `sequence` of its own it is the next request. Returns its name."""
        name = protocol.message_name(message)
        if "sequence" not in changes:
            self.sequence += 1
            if name == self.step_name:
                self.next_step = message.step + 1
        self.send_bytes(self.with_header(message, **changes).SerializeToString(), describe(message))
        return name

    def with_header(self, message, **changes):
        header = {"protocol_major": PROTOCOL_MAJOR, "protocol_minor": PROTOCOL_MINOR, "session_id": self.session_id,
                  "epoch": self.epoch, "sequence": self.sequence, **changes}
        for field, value in header.items():
            setattr(message, field, value)
        return message

    def send_bytes(self, data, text, lane=DATA):
        self.sent.append(text if lane == DATA else f"{text} on the control lane")
        self._lanes.send(lane, data)

    def send_control(self, name, **header):
        """Ping or Abort; returns the Envelope, already sent, for its fields."""
        message = Envelope(step=-1)
        part(message, name)
        return self.with_header(message, sequence=0, **header)

    def ping(self, **header):
        """Sends one Ping and returns its stamp."""
        message = self.send_control("Ping", **header)
        message.ping.stamp_ns = secrets.randbits(62)
        self.send_bytes(message.SerializeToString(), "Ping", CONTROL)
        return message.ping.stamp_ns

    def abort(self, code):
        message = self.send_control("Abort")
        failure = message.abort.failure
        failure.code, failure.component, failure.reason = code, "coupler", "The run is over (a check ends it). Go on."
        self.send_bytes(message.SerializeToString(), f"Abort (code {code})", CONTROL)

    def stop_pings(self):
        self._last_ping = None

    def vanish(self):
        """The coupler's socket is gone, as if its process had been killed."""
        self.sent.append("nothing any more: the coupler is gone")
        self._lanes.close()

    # -- expecting ----------------------------------------------------------------------------------------------

    def expect(self, name, lane=DATA):
        """The next message on the lane, which must be of that name."""
        received = self.receive(name, lane)
        if received.name != name:
            raise Violation(f"{describe(received.envelope)} instead of {name}")
        return received

    def expect_reply(self, name, request):
        """The reply that the table has for the request `name`, with the header of the request."""
        state = next(state for row in protocol.TRANSITIONS if row.get("message") == name for state in row["from"])
        row = protocol.transition(self.role, state, message=name)
        reply = self.expect(row["reply"])
        header = reply.envelope
        wanted = (request.sequence, self.session_id, self.epoch)
        if (header.sequence, header.session_id, header.epoch) != wanted:
            raise Violation(f"{reply.name} with sequence, session and epoch {header.sequence}, {header.session_id}, "
                            f"{header.epoch} instead of {wanted[0]}, {wanted[1]}, {wanted[2]}")
        if reply.name in ("Loads", "Kinematics"):
            due = request.step + 1 if name == "AppliedLoads" else request.step
            if header.step != due:
                raise Violation(f"{reply.name} of step {header.step} instead of step {due}")
        if reply.name == "Configured":
            self.case.learn(header)
        return reply

    def expect_failure(self, code=_REFUSED, words=(), told=True):
        """A Failure with this code and these words, and an end with the same code.

        told=False: before the Welcome there is no session, so the Failure may stay untold.
        """
        if told or self._comes_before_the_end():
            failure = self.expect("Failure").envelope.failure
            if failure.code != code:
                raise Violation(f"a Failure with code {failure.code} instead of {code}: {failure.reason}")
            for word in words:
                if word not in failure.reason:
                    raise Violation(f"a Failure that does not say «{word}»: {failure.reason}")
        self.expect_exit(code)

    def expect_exit(self, *codes, within_s=None):
        """The process ends with one of these codes; its control lane may be served meanwhile."""
        code = self.await_end(within_s)
        if code not in codes:
            wanted = str(codes[0]) if len(codes) == 1 else f"one from {codes[0]} to {codes[-1]}"
            raise Violation(f"{_ending(code)} instead of {wanted}{self._last_words()}")

    def await_end(self, within_s=None):
        """Exit code of the process, whatever it is."""
        patience_s = within_s or self.subject.patience_s
        deadline = time.monotonic() + patience_s
        while (code := self.process.exit_code(_SLICE_S)) is None:
            self._serve()
            if time.monotonic() > deadline:
                raise Silence(f"no end of the process within {patience_s:g} s")
        return code

    def receive(self, what, lane=DATA):
        """The next message on the lane."""
        self._pump(lambda: self._inbox[lane], what)
        return self._inbox[lane].pop(0)

    def receive_pong(self, stamp_ns):
        """The answer to one's own ping, and how long it took at most."""
        start = time.monotonic()
        while (pong := self.expect("Pong", CONTROL).envelope.pong).stamp_ns != stamp_ns:
            pass
        return pong, time.monotonic() - start

    def wait(self, seconds):
        """Time passes; messages are collected."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            self._take(_SLICE_S)

    # -- inside -------------------------------------------------------------------------------------------------

    def _pump(self, done, what):
        deadline = time.monotonic() + self.subject.patience_s
        while not done():
            if self._take(_SLICE_S):
                continue
            if self.process.exit_code() is not None and not self._take(_SLICE_S) and not done():
                raise Violation(f"{_ending(self.process.exit_code())} instead of {what}{self._last_words()}")
            if time.monotonic() > deadline:
                raise Silence(f"nothing within {self.subject.patience_s:g} s instead of {what}")

    def _take(self, seconds):
        """Collects one message and pings when it is time; False if there was none."""
        now = time.monotonic()
        if self._last_ping is not None and now - self._last_ping > _PING_EVERY_S:
            self._last_ping = now
            ping = self.send_control("Ping")
            self._lanes.send(CONTROL, ping.SerializeToString())
        received = self._lanes.receive(seconds)
        if received is None:
            return False
        if received.name == "Hello":
            self.hellos.setdefault(received.lane, received)
        elif received.name != "Pong" or received.envelope.pong.stamp_ns:
            self._inbox[received.lane].append(received)
        return True

    def _serve(self):
        if not self._lanes.closed:
            self._take(0)

    def _comes_before_the_end(self):
        """Whether there is a message before the process ends."""
        self.await_end()
        self._take(0)
        return bool(self._inbox[DATA])

    def _last_words(self):
        words = self.process.last_words(self.log)
        return f"; its last words: {words}" if words else ""


def _ending(code):
    return f"the end of the process by signal {-code}" if code < 0 else f"the end of the process with exit code {code}"
