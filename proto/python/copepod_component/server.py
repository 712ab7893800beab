"""The data lane: says Hello, then answers requests until the run ends. The session table decides what is legal."""

import sys
import time
import traceback

from . import checksum
from .errors import ComponentError, DeadlinePassed, ExitCode, Refused
from .schema import Envelope, PROTOCOL_MAJOR, PROTOCOL_MINOR, control, message_name
from .session import Session
from .validation import check_version, check_welcome

PHASES = {
    "make the solver": control.PHASE_CONFIGURING,
    "read the state": control.PHASE_CHECKPOINTING,
    "write the state": control.PHASE_CHECKPOINTING,
    "say goodbye": control.PHASE_FINISHING,
}

FAREWELL_S = 0.5


def _told(error):
    """An exception that nobody foresaw, in one line with the place that raised it."""
    place = traceback.extract_tb(error.__traceback__)[-1]
    return (
        f"The component raised {error!r} in {place.filename}, line {place.lineno} (the log has the traceback). Mend it."
    )


class Server:
    def __init__(self, socket, served, hello, vitals, door, host, log):
        self._socket, self._served, self._hello = socket, served, hello
        self._vitals, self._door, self._host, self._log = vitals, door, host, log
        self._session = Session(served.role)
        self._last_reply = b""

    def run(self, connect_deadline_s):
        """Returns the exit code of the process."""
        try:
            self._greet(connect_deadline_s)
            while not self._session.has_ended():
                data = self._receive(1.0)
                if data is not None:
                    self._handle(data)
            if self._session.state == "done":
                self._stay_for_repeated_goodbyes()
            return self._vitals.stop_code if self._session.state == "orphaned" else ExitCode.FINISHED
        except Exception as error:
            foreseen = isinstance(error, ComponentError)
            code = error.code if foreseen else ExitCode.SOLVER_FAILED
            reason = f"{error}" if foreseen else _told(error)
            self._log.error("%s", reason, exc_info=not foreseen)
            if not self._session.session_id:  # no coupler hears of it
                print(f"error: {reason}", file=sys.stderr)
            if self._session.session_id and not self._vitals.stop_code:
                self._tell_failure(code, reason)
            return self._vitals.stop_code or code

    def _greet(self, connect_deadline_s):
        end = time.monotonic() + connect_deadline_s
        while self._session.state == "connected":
            if time.monotonic() > end:
                raise DeadlinePassed(
                    "The coupler did not answer (it is not running, or at another address). "
                    "Start it, or correct --endpoint."
                )
            if self._door.turns_us_away():
                raise Refused(
                    "The coupler turned this component away (a key is missing or wrong, here or at the "
                    "coupler). Give --keys with the file of this role of this run."
                )
            self._socket.send(self._hello)
            data = self._receive(1.0)
            if data is not None:
                self._handle(data)

    def _stay_for_repeated_goodbyes(self):
        """The goodbye may get lost, and the coupler ask again."""
        end = time.monotonic() + FAREWELL_S
        while time.monotonic() < end:
            if self._socket.poll(10):
                self._handle(self._socket.recv())

    def _receive(self, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if self._vitals.stop_code:
                self._session.on_event("coupler lost")
                return None
            if self._socket.poll(100):
                return self._socket.recv()
        return None

    def _handle(self, data):
        try:
            request = checksum.from_bytes(data)
        except checksum.Damaged as damage:
            self._log.warning("Ignored a message, the coupler will send it again: %s", damage)
            return
        name = message_name(request)
        if name is None:
            raise Refused("A message was refused (it is empty or unknown). Use the same version on both sides.")
        if name != "Refusal":  # which must be readable in any version
            check_version(request)
        action = self._session.on_message(name, request)
        if action.kind == "ignore":
            self._log.warning("Ignored a %s: %s.", name, action.reason)
        elif action.kind == "repeat":
            self._socket.send(self._last_reply)
        elif action.kind == "refuse":
            raise Refused(action.reason)
        else:
            self._work(name, request, action)

    def _work(self, name, request, action):
        if name == "Refusal":
            raise Refused(request.refusal.reason)
        if name == "Welcome":
            check_welcome(request.welcome)
            self._session.session_id, self._session.epoch = request.welcome.session_id, request.welcome.epoch
            self._vitals.phase = control.PHASE_WAITING
            return
        self._vitals.step, self._vitals.received_sequence = request.step, request.sequence
        self._vitals.phase = PHASES.get(action.work, control.PHASE_EXCHANGING)
        reply = self._envelope(request.sequence, request.step)
        if name == "Finish":
            reply.finished.SetInParent()
        else:
            self._served.perform(request, reply)
        self._last_reply = checksum.to_bytes(reply)
        self._socket.send(self._last_reply)
        self._vitals.replied_sequence = request.sequence
        if name == "Finish":
            return
        self._vitals.phase = control.PHASE_ADVANCING
        self._served.follow_up(name)
        self._session.on_event("work done")
        self._vitals.phase = control.PHASE_WAITING

    def _tell_failure(self, code, reason):
        message = self._envelope(0, self._vitals.step)
        message.failure.code = int(code)
        message.failure.component = self._served.role
        message.failure.host = self._host
        message.failure.step = self._vitals.step
        message.failure.reason = reason[:4000]
        self._socket.send(checksum.to_bytes(message))

    def _envelope(self, sequence, step):
        return Envelope(
            protocol_major=PROTOCOL_MAJOR,
            protocol_minor=PROTOCOL_MINOR,
            session_id=self._session.session_id,
            epoch=self._session.epoch,
            sequence=sequence,
            step=step,
        )
