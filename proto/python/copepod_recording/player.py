"""Plays the coupler of a recorded run to a real component and compares its replies with the recorded ones."""

import secrets
import sys
import time

import zmq

from copepod_run.checkout import ROOT

from copepod_recording.comparison import differences
from copepod_recording.reader import message_name
from copepod_recording.script import ROLES

sys.path.insert(0, str(ROOT / "proto" / "python"))
from copepod_component import checksum  # noqa: E402

_CONNECT_DEADLINE_S = 60.0
_REPLY_DEADLINE_S = 600.0
_PING_EVERY_S = 0.5


class Failed(Exception):
    """The component did not answer as a component does."""


class Player:
    """The coupler's end of one component, bound to an endpoint. A context that closes its socket."""

    def __init__(self, endpoint, token, role, envelope_class, is_alive, folder):
        """`is_alive()`: whether the component's process lives; `folder`: receives whatever it is told to write."""
        self._token, self._role, self._envelope_class = token, role, envelope_class
        self._is_alive, self._folder = is_alive, folder
        self._session, self._epoch = secrets.randbits(63) | 1, time.time_ns() // 1000
        self._peers = {}
        self._last_ping = 0.0
        self._context = zmq.Context()
        self._socket = self._context.socket(zmq.ROUTER)
        self._socket.bind(endpoint)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._context.destroy(linger=500)

    def greet(self):
        """Waits for the component's Hello on both lanes and welcomes it. Raises Failed."""
        end = time.monotonic() + _CONNECT_DEADLINE_S
        while len(self._peers) < 2:
            peer, envelope = self._receive(end, "it did not say Hello on both lanes")
            hello = envelope.hello
            if message_name(envelope) != "Hello" or hello.session_token != self._token:
                continue
            if hello.role != ROLES[self._role]:
                raise Failed(f"it is no {self._role} component (its Hello says so). Use the other option.")
            self._peers[hello.lane] = peer
            welcome = self._envelope_class(protocol_major=1, step=-1)
            welcome.welcome.session_id, welcome.welcome.epoch = self._session, self._epoch
            self._socket.send_multipart([peer, checksum.to_bytes(welcome)])

    def play(self, script, tolerance, on_difference):
        """Sends every request and compares every reply; returns how many were compared.

        `on_difference(exchange, text)` is called for every value that differs. Raises Failed.
        """
        compared = 0
        for exchange in script.exchanges:
            reply = self._ask(exchange.request)
            if exchange.reply is None:
                continue
            compared += 1
            for text in differences(exchange.reply, reply, tolerance):
                on_difference(exchange, text)
        if not script.exchanges or script.exchanges[-1].name != "Finish":
            self._ask(self._finish_after(script))
        return compared

    def _ask(self, recorded):
        request = self._envelope_class()
        request.CopyFrom(recorded)
        request.session_id, request.epoch, request.attempt = self._session, self._epoch, 0
        self._redirect(request)
        self._socket.send_multipart([self._peers[1], checksum.to_bytes(request)])
        end = time.monotonic() + _REPLY_DEADLINE_S
        while True:
            peer, reply = self._receive(end, f"it did not answer {message_name(request)} of step {request.step}")
            if peer != self._peers[1]:
                continue
            if message_name(reply) == "Failure":
                raise Failed(f"at step {reply.failure.step}: {reply.failure.reason}")
            if reply.sequence == request.sequence:
                return reply

    def _redirect(self, request):
        """What the recorded run wrote must stay as it is."""
        name = message_name(request)
        if name == "FluidSetup":
            request.fluid_setup.fields.directory = str(self._folder)
            request.fluid_setup.trace_directory = ""
        elif name == "BodySetup":
            request.body_setup.trace_directory = ""
        elif name == "Save":
            request.save.path = str(self._folder / f"{self._role}_{request.step}")

    def _finish_after(self, script):
        last = script.exchanges[-1].request if script.exchanges else None
        finish = self._envelope_class(
            protocol_major=1, sequence=last.sequence + 1 if last else 1, step=last.step if last else -1
        )
        finish.finish.SetInParent()
        return finish

    def _receive(self, end, complaint):
        """The next message; pings meanwhile. Raises Failed after `end`, and when the process has died."""
        while True:
            self._ping()
            if self._socket.poll(50):
                peer, data = self._socket.recv_multipart()
                envelope = self._envelope_class()
                envelope.ParseFromString(data)
                envelope.ClearField("checksum")  # of the frame, not of what it says
                return peer, envelope
            if not self._is_alive():
                raise Failed(f"{complaint} (its process ended). Look at its output above.")
            if time.monotonic() > end:
                raise Failed(f"{complaint} in time (it hangs, or connects elsewhere). Look at its output above.")

    def _ping(self):
        if 2 not in self._peers or time.monotonic() - self._last_ping < _PING_EVERY_S:
            return
        self._last_ping = time.monotonic()
        ping = self._envelope_class(protocol_major=1, session_id=self._session, epoch=self._epoch, step=-1)
        ping.ping.stamp_ns = time.monotonic_ns()
        self._socket.send_multipart([self._peers[2], checksum.to_bytes(ping)])
