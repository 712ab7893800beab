"""The control lane: a thread that answers pings and aborts while the solver computes, and notices a lost coupler."""

import os
import threading
import time
from typing import Any

import zmq

from .errors import ExitCode, Refused
from .keys import next_event
from .messages import Damaged, envelope, from_frame, to_frame

DISCONNECTED_S = 3.0
PAUSE_S = 1.0  # a gap in this thread's own attention
GRACE_S = 2.0  # for the solver's thread, after a stop request


class ControlLane:
    """Owns its socket once the thread has started. It has a thread, and is none: names of Thread's own change."""

    def __init__(self, socket, endpoint, hello, context, orphan_after_s, log):
        self._socket, self._endpoint, self._hello, self._context = socket, endpoint, hello, context
        self._orphan_after_s, self._log = orphan_after_s, log
        self._header: Any = None  # (session_id, epoch) once welcomed
        self._connected = False
        self._disconnected_since = None
        self._last_ping = self._last_look = 0.0

    def start(self):
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self):
        socket = self._socket
        # Monitored before it connects: otherwise the first event could be missed, and the coupler considered lost.
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
                self._connected = next_event(monitor) == zmq.EVENT_CONNECTED
            if self._header is not None:
                self._look_for_coupler()
            if self._context.stop_code and stopping_since is None:
                stopping_since = time.monotonic()
            if stopping_since is not None and time.monotonic() - stopping_since > GRACE_S:
                os._exit(self._context.stop_code)

    def _handle(self, socket, data):
        try:
            message = from_frame(data)
        except (Damaged, Refused) as error:
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
            names = ("step", "phase", "progress", "awaited_rank", "received_sequence", "replied_sequence")
            pong = {"stamp_ns": message.ping.stamp_ns, **{name: getattr(self._context, name) for name in names}}
            header = {"session_id": message.session_id, "epoch": message.epoch, "step": pong["step"]}
            socket.send(to_frame(envelope(**header, pong=pong)))
        elif kind == "abort":
            self._log.error("Aborted by the coupler: %s", message.abort.failure.reason)
            self._stop(message.abort.failure.code)

    def _look_for_coupler(self):
        now = time.monotonic()
        was_away = now - self._last_look > PAUSE_S  # suspended, and the coupler too: its clocks start anew
        self._last_look = now
        if was_away:
            self._last_ping = now
        if self._connected:
            self._disconnected_since = None
        elif was_away or self._disconnected_since is None:
            self._disconnected_since = now
        broken = self._disconnected_since is not None and now - self._disconnected_since > DISCONNECTED_S
        if (broken or now - self._last_ping > self._orphan_after_s) and not self._context.stop_code:
            why = "its connection broke and did not come back" if broken else "pings no longer arrive"
            self._log.error("The coupler is gone (%s). See the coupler's log.", why)
            self._stop(ExitCode.COMPONENT_LOST)

    def _stop(self, code):
        if not self._context.stop_code:
            self._context.stop_code = int(code) or int(ExitCode.SOLVER_FAILED)
