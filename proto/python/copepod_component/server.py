"""The data lane: sends Hello, then answers requests until the run ends. The transition table defines what is legal."""

import os
import sys
import time
import traceback

from .errors import ComponentError, DeadlinePassed, ExitCode, Refused
from .messages import Damaged, control, envelope, from_frame, message_name, to_frame
from .session import Session
from .validation import check_version, check_welcome

PHASES = {
    "FluidSetup": control.PHASE_CONFIGURING,
    "BodySetup": control.PHASE_CONFIGURING,
    "ControllerSetup": control.PHASE_CONFIGURING,
    "Restore": control.PHASE_CHECKPOINTING,
    "Save": control.PHASE_CHECKPOINTING,
    "Finish": control.PHASE_FINISHING,
}

FINISH_S = 0.5


class Server:
    def __init__(self, socket, served, name, features, hello, context, monitor, host, log):
        self._socket, self._served, self._name, self._features, self._hello = socket, served, name, features, hello
        self._context, self._monitor, self._host, self._log = context, monitor, host, log
        self._session = Session(served.role)
        self._last_reply = b""

    def run(self, connect_deadline_s):
        """Returns the exit code of the process."""
        try:
            self._shake_hands(connect_deadline_s)
            while not self._session.has_ended():
                self._serve(1.0)
            end = time.monotonic() + FINISH_S  # Finished may be lost, and the coupler ask again
            while self._session.state == "done" and time.monotonic() < end and not self._address_is_gone():
                if self._socket.poll(10):
                    self._handle(self._socket.recv())
            return self._context.stop_code if self._session.state == "orphaned" else ExitCode.FINISHED
        except Exception as error:
            code, reason = ExitCode.SOLVER_FAILED, str(error)
            if expected := isinstance(error, ComponentError):
                code = error.code
            else:  # a mistake in the solver, in one line with the place that raised it
                place = traceback.extract_tb(error.__traceback__)[-1]
                where = f"{place.filename}, line {place.lineno}"
                reason = f"The component raised {error!r} in {where} (see the log for the traceback). Fix it."
            self._log.error("%s", reason, exc_info=not expected)
            if not self._session.session_id:  # the coupler cannot learn of it
                print(f"error: {reason}", file=sys.stderr)
            elif not self._context.stop_code:
                failure = {"code": int(code), "component": self._name, "host": self._host}
                failure |= {"step": self._context.step, "reason": reason[:4000]}
                self._socket.send(to_frame(self._envelope(step=self._context.step, failure=failure)))
            return self._context.stop_code or code

    def _shake_hands(self, connect_deadline_s):
        end = time.monotonic() + connect_deadline_s
        while self._session.state == "connected":
            if time.monotonic() > end:
                raise DeadlinePassed(
                    "The coupler did not answer (it is not running, or listens at another address). "
                    "Start it, or correct --endpoint."
                )
            if self._monitor.is_rejected():
                raise Refused(
                    "The coupler turned this component away (a key is missing or wrong, here or at the "
                    "coupler). Give --keys with the file of this role of this run."
                )
            self._socket.send(self._hello)
            self._serve(1.0)

    def _address_is_gone(self):
        """Whether the coupler has given up its address, and with it the run."""
        transport, _, path = self._socket.last_endpoint.decode().rstrip("\0").partition("://")
        return transport == "ipc" and not os.path.exists(path)

    def _serve(self, seconds):
        """Handles the next message, if one comes in this time."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if self._context.stop_code:
                self._session.on_event("coupler lost")
                return
            if self._socket.poll(100):
                self._handle(self._socket.recv())
                return

    def _handle(self, data):
        try:
            request = from_frame(data)
        except Damaged as damage:
            self._log.warning("Ignored a message; the coupler will send it again: %s", damage)
            return
        name = message_name(request)
        if name is None:
            raise Refused("A message was refused (it is empty or unknown). Use the same version on both sides.")
        if name != "Refusal":  # a Refusal must be readable in any version
            check_version(request)
        action, reason = self._session.on_message(name, request)
        if action == "ignore":
            self._log.warning("Ignored a %s: %s.", name, reason)
        elif action == "repeat":
            self._socket.send(self._last_reply)
        else:
            self._work(name, request)

    def _work(self, name, request):
        if name == "Refusal":
            raise Refused(request.refusal.reason)
        if name == "Welcome":
            check_welcome(request.welcome)
            self._session.session_id, self._session.epoch = request.welcome.session_id, request.welcome.epoch
            self._context.phase = control.PHASE_WAITING
            return
        needed = "checkpoint" if name in ("Save", "Restore") else "snapshots" if name.endswith("Setup") else ""
        if needed and request.sequence > 1 and needed not in self._features:
            raise Refused(f"A {name} was refused (this component does not announce {needed}). Send none.")
        self._context.step, self._context.received_sequence = request.step, request.sequence
        self._context.phase = PHASES.get(name, control.PHASE_EXCHANGING)
        reply = self._envelope(sequence=request.sequence, step=request.step)
        if name == "Finish":
            reply.finished.SetInParent()
        else:
            self._served.perform(request, reply)
        self._last_reply = to_frame(reply)
        self._socket.send(self._last_reply)
        self._context.replied_sequence = request.sequence
        if name == "Finish":
            return
        self._context.phase = control.PHASE_ADVANCING
        self._served.follow_up(name)
        self._session.on_event("work done")
        self._context.phase = control.PHASE_WAITING

    def _envelope(self, **fields):
        return envelope(session_id=self._session.session_id, epoch=self._session.epoch, **fields)
