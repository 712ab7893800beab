"""The control lane: a thread that answers pings and aborts while the solver computes, and notices a lost coupler."""

import os
import threading
import time

import zmq
from zmq.utils.monitor import recv_monitor_message

from . import checksum
from .errors import ExitCode, Refused
from .schema import Envelope, PROTOCOL_MAJOR, PROTOCOL_MINOR

DISCONNECTED_S = 3.0
GRACE_S = 2.0  # for the solver's thread, after a stop request


class ControlLane(threading.Thread):
    """Owns its socket from the start of the thread on."""

    def __init__(self, socket, endpoint, hello, vitals, orphan_after_s, log):
        super().__init__(daemon=True)
        self._socket, self._endpoint, self._hello, self._vitals = socket, endpoint, hello, vitals
        self._orphan_after_s, self._log = orphan_after_s, log
        self._header = None  # (session_id, epoch) once welcomed
        self._connected = False
        self._disconnected_since = None
        self._last_ping = 0.0

    def run(self):
        socket = self._socket
        # Watched before it connects: an event that came earlier would be missed, and the coupler taken for lost.
        monitor = socket.get_monitor_socket(zmq.EVENT_CONNECTED | zmq.EVENT_DISCONNECTED | zmq.EVENT_CLOSED)
        socket.connect(self._endpoint)
        last_hello, stopping_since = -1e300, None
        while True:
            if self._header is None and time.monotonic() - last_hello > 1.0:
                last_hello = time.monotonic()
                socket.send(self._hello)
            if socket.poll(100):
                self._handle(socket, socket.recv())
            while monitor.poll(0):
                self._connected = recv_monitor_message(monitor)["event"] == zmq.EVENT_CONNECTED
            if self._header is not None:
                self._look_for_coupler()
            if self._vitals.stop_code and stopping_since is None:
                stopping_since = time.monotonic()
            if stopping_since is not None and time.monotonic() - stopping_since > GRACE_S:
                os._exit(self._vitals.stop_code)

    def _handle(self, socket, data):
        try:
            message = checksum.from_bytes(data)
        except (checksum.Damaged, Refused) as error:
            self._log.warning("On the control lane: %s", error)
            return
        kind = message.WhichOneof("body")
        if kind == "welcome":
            self._header = (message.welcome.session_id, message.welcome.epoch)
            self._last_ping = time.monotonic()
        elif self._header != (message.session_id, message.epoch):
            return
        elif kind == "ping":
            self._last_ping = time.monotonic()
            socket.send(self._pong(message.ping.stamp_ns))
        elif kind == "abort":
            self._log.error("Aborted by the coupler: %s", message.abort.failure.reason)
            self._stop(message.abort.failure.code)

    def _pong(self, stamp_ns):
        session_id, epoch = self._header
        vitals = self._vitals
        reply = Envelope(
            protocol_major=PROTOCOL_MAJOR,
            protocol_minor=PROTOCOL_MINOR,
            session_id=session_id,
            epoch=epoch,
            step=vitals.step,
        )
        reply.pong.stamp_ns = stamp_ns
        reply.pong.step = vitals.step
        reply.pong.phase = vitals.phase
        reply.pong.progress = vitals.progress
        reply.pong.received_sequence = vitals.received_sequence
        reply.pong.replied_sequence = vitals.replied_sequence
        return checksum.to_bytes(reply)

    def _look_for_coupler(self):
        now = time.monotonic()
        if self._connected:
            self._disconnected_since = None
        elif self._disconnected_since is None:
            self._disconnected_since = now
        broken = self._disconnected_since is not None and now - self._disconnected_since > DISCONNECTED_S
        if (broken or now - self._last_ping > self._orphan_after_s) and not self._vitals.stop_code:
            self._log.error(
                "The coupler is gone (%s). Look at the coupler's log.",
                "its connection broke and did not come back" if broken else "no ping any more",
            )
            self._stop(ExitCode.COMPONENT_LOST)

    def _stop(self, code):
        if not self._vitals.stop_code:
            self._vitals.stop_code = int(code) or int(ExitCode.SOLVER_FAILED)
