"""One life of a component under test: its process, the coupler's socket, what is sent, received and awaited."""

import contextlib
import dataclasses
import secrets
import shutil
import signal
import tempfile
import time
from pathlib import Path

import zmq
from zmq.utils.monitor import recv_monitor_message

from copepod_component.errors import Refused
from copepod_component.messages import PROTOCOL_MAJOR, PROTOCOL_MINOR, Damaged, Envelope
from copepod_component.messages import from_frame, handshake, message_name, to_frame, with_checksum
from copepod_conformance.component_process import ComponentProcess
from copepod_conformance.protocol import content
from copepod_conformance.verdicts import Silence, Violation

DATA, CONTROL = "data", "control"
_LANE_OF_NUMBER = {handshake.LANE_DATA: DATA, handshake.LANE_CONTROL: CONTROL}
_PING_EVERY_S = 0.5
_SLICE_S = 0.05
_CONTINUES_LATER_S = 1.0  # so that a component looks for pings before the next one comes, on a busy machine too
_SLOW_BYTES_PER_S = 5e6  # of large messages, where other work keeps a machine busy


@dataclasses.dataclass(frozen=True)
class Received:
    """A message of the component."""

    lane: str
    data: bytes
    envelope: Envelope

    @property
    def name(self):
        return message_name(self.envelope)

    @property
    def content(self):
        """The message without its Envelope, as bytes."""
        return content(self.envelope).SerializeToString(deterministic=True)


class Lanes:
    def __init__(self, context, endpoint):
        self._socket = context.socket(zmq.ROUTER)
        self._socket.linger = 0
        self._socket.rcvhwm = self._socket.sndhwm = 0
        self._socket.router_mandatory = 1
        self._socket.router_handover = 1
        self._monitor = self._socket.get_monitor_socket(zmq.EVENT_ACCEPTED | zmq.EVENT_DISCONNECTED)
        self._socket.bind(endpoint)
        self._peers = {}
        self._connections = 0

    def receive(self, seconds):
        """The next message, or None. A peer is known by the lane that its Hello names."""
        if self._socket.closed or not self._socket.poll(int(1000 * seconds)):
            return None
        peer, data = self._socket.recv_multipart()[:2]
        try:
            envelope = from_frame(data)
        except (Damaged, Refused) as problem:
            raise Violation(f"bytes that are not a message ({problem})") from problem
        if envelope.WhichOneof("body") == "hello":
            self._peers[peer] = _LANE_OF_NUMBER.get(envelope.hello.lane, DATA)
        return Received(self._peers.get(peer, DATA), data, envelope)

    def send(self, lane, frame):
        """Lost if the component is not connected."""
        with contextlib.suppress(StopIteration, zmq.ZMQError):
            peer = next(peer for peer, its_lane in reversed(self._peers.items()) if its_lane == lane)
            self._socket.send_multipart([peer, frame], copy=False)

    @property
    def connected(self):
        """Whether a connection is open. Once it is closed, all that came through it can be received."""
        while not self._socket.closed and self._monitor.poll(0):
            event = recv_monitor_message(self._monitor)["event"]
            self._connections += 1 if event == zmq.EVENT_ACCEPTED else -1
        return self._connections > 0

    def close(self):
        if not self._socket.closed:
            self._socket.disable_monitor()
            self._monitor.close(linger=0)
            self._socket.close()
            self._connections = 0


class Conversation:
    """Starts the component at once and leaves nothing of it on exit. Every wait has an end."""

    def __init__(self, subject, options=()):
        """`subject`: a Component."""
        self.subject = subject
        self.folder = Path(tempfile.mkdtemp(dir=subject.folder))
        self.token = secrets.token_hex(8)
        self.session_id, self.epoch, self.sequence = secrets.randbits(63), 1, 0
        self.hellos, self.sent = {}, []
        self._inbox: dict = {DATA: [], CONTROL: []}
        self._last_ping = None  # no pings before the Welcome
        self._travel_s = 0.0  # of the last bytes sent, added to the patience
        self._log = self.folder / "component.log"
        endpoint = f"ipc://{self.folder}/coupler.ipc"
        self._lanes = Lanes(subject.context, endpoint)
        connection = ["--endpoint", endpoint, "--session", self.token, "--log-file", str(self._log)]
        if "--orphan-after" not in options:  # a busy machine may keep pings back for longer than the default
            connection += ["--orphan-after", "60"]
        command = [*subject.command, *connection, *options]
        self.process = ComponentProcess(command, subject.environment, self.folder, subject.shows_output)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._lanes.close()
        self.process.end()
        shutil.rmtree(self.folder, ignore_errors=True)

    # -- sending

    def with_header(self, message, **changes):
        """Fills the header of an Envelope; `changes` are fields that differ."""
        header = {"session_id": self.session_id, "epoch": self.epoch, "sequence": self.sequence, **changes}
        message.protocol_major, message.protocol_minor = PROTOCOL_MAJOR, PROTOCOL_MINOR
        for field, value in header.items():
            setattr(message, field, value)
        return message

    def send_bytes(self, data, text, lane=DATA):
        """Sends any bytes; `text` describes them in the report."""
        self.sent.append(text if lane == DATA else f"{text} on the control lane")
        self._travel_s = len(data) / _SLOW_BYTES_PER_S
        self._lanes.send(lane, with_checksum(data))

    def send_damaged(self, message, text):
        """One bit of the message changes on its way."""
        frame = bytearray(to_frame(message))
        frame[len(frame) // 2] ^= 4
        self.sent.append(text)
        self._lanes.send(DATA, bytes(frame))

    def welcome(self, remark="", minor=PROTOCOL_MINOR, **changes):
        """Welcomes both lanes; `changes` are fields of the Envelope. The `remark` follows it in reports."""
        welcome = {"minor": minor, "session_id": self.session_id, "epoch": self.epoch}
        header = {"session_id": 0, "epoch": 0, "sequence": 0, **changes}
        for lane in (CONTROL, DATA):
            self._lanes.send(lane, to_frame(self.with_header(Envelope(step=-1, welcome=welcome), **header)))
        self.sent.append(f"Welcome on both lanes{remark}")
        self._last_ping = 0.0

    def ping(self, **changes):
        """Sends one Ping and returns its stamp, which is not 0."""
        ping = {"stamp_ns": 1 + secrets.randbits(62)}
        message = self.with_header(Envelope(step=-1, ping=ping), sequence=0, **changes)
        self.send_bytes(message.SerializeToString(), "Ping", CONTROL)
        return ping["stamp_ns"]

    def abort(self, code):
        failure = {"code": code, "component": "coupler", "reason": "The run is over (ended by a check). Ignore this."}
        message = self.with_header(Envelope(step=-1, abort={"failure": failure}), sequence=0)
        self.send_bytes(message.SerializeToString(), f"Abort (code {code})", CONTROL)

    def stop_pings(self):
        self._last_ping = None

    def suspend(self, seconds):
        """All processes are stopped for a while, the coupler too: no pings, and the coupler is the last to continue."""
        self._last_ping = None
        self.ping()
        self.receive("the Pong to a Ping: none is on its way when the processes stop", CONTROL)
        self.sent.append(f"nothing, no pings either, while its processes are stopped for {seconds:g} s")
        self.process.send_signal(signal.SIGSTOP)
        self.wait(seconds)
        self.process.send_signal(signal.SIGCONT)
        self.wait(_CONTINUES_LATER_S)
        self._last_ping = 0.0

    def vanish(self):
        """The coupler's socket is gone, as if its process had been killed."""
        self.sent.append("nothing more: the coupler is gone")
        self._lanes.close()

    # -- waiting

    def await_hello(self):
        """Waits for the Hello on both lanes."""
        self._collect_until(lambda: len(self.hellos) == 2, "a Hello on both lanes")

    def receive(self, what, lane=DATA):
        """The next message on the lane; `what` names the expected one in the report."""
        self._collect_until(lambda: self._inbox[lane], what)
        return self._inbox[lane].pop(0)

    def wait(self, seconds):
        """Time passes; messages are collected."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            self._collect(_SLICE_S)

    def await_end(self, within_s=None):
        """Exit code of the process, whatever it is."""
        patience_s = within_s or self.subject.patience_s
        deadline = time.monotonic() + patience_s
        while (code := self.process.exit_code(_SLICE_S)) is None:
            self._collect(0)
            if time.monotonic() > deadline:
                raise Silence(f"no end of the process within {patience_s:g} s")
        self._collect_rest()
        return code

    def has_mail(self):
        """Whether a message of the data lane has arrived that was not received yet."""
        self._collect(0)
        return bool(self._inbox[DATA])

    def describe_end(self, code, wanted):
        """«the end of the process with exit code 70 instead of 65; its last words: …»"""
        how = f"by signal {-code}" if code < 0 else f"with exit code {code}"
        words = self.process.last_words(self._log)
        return f"the end of the process {how} instead of {wanted}" + (f"; its last words: {words}" if words else "")

    # -- inside

    def _collect_until(self, done, what):
        patience_s = self.subject.patience_s + self._travel_s
        deadline = time.monotonic() + patience_s
        while not done():
            if self._collect(_SLICE_S):
                continue
            code = self.process.exit_code()
            if code is not None and not self._collect(_SLICE_S):
                self._collect_rest()
                if done():
                    return
                raise Violation(self.describe_end(code, what))
            if time.monotonic() > deadline:
                raise Silence(f"nothing within {patience_s:.3g} s instead of {what}")

    def _collect_rest(self):
        """What a process that has ended sent before: on a busy machine its last messages may take their time."""
        deadline = time.monotonic() + self.subject.patience_s
        while self._lanes.connected and time.monotonic() < deadline:
            self._collect(_SLICE_S)
        while self._collect(0):
            pass

    def _collect(self, seconds):
        """Takes one message, and pings when it is time; False if there was none."""
        now = time.monotonic()
        if self._last_ping is not None and now - self._last_ping > _PING_EVERY_S:
            self._last_ping = now
            self._lanes.send(CONTROL, to_frame(self.with_header(Envelope(step=-1, ping={}), sequence=0)))
        received = self._lanes.receive(seconds)
        if received is None:
            return False
        if received.name == "Hello":
            self.hellos.setdefault(received.lane, received)
        elif received.name != "Pong" or received.envelope.pong.stamp_ns:  # pongs to the periodic pings have stamp 0
            self._inbox[received.lane].append(received)
        return True
