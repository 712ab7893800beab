"""The connection to the guard on another host of a run: what it reports, and whether it still does."""

import json
import os
import subprocess
import time
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from copepod_run import hosts
from copepod_run.errors import ExitCode, Stop
from copepod_run.host_guard import GUARD
from copepod_run.processes import Wrong, end_with_parent

_READY_WITHIN_S = 30.0
_REACHED_WITHIN_S = 4.0  # a guard ends within half a second, or is killed after two


class HostConnection:
    """Ends with this command; the guard then ends everything on that host."""

    def __init__(self, host: str, mark: str, order: Mapping[str, Any]) -> None:
        """Sends the order at once; wait_until_ready() has the answer."""
        self.host = host
        self._mark = mark
        self.wrong: list[Wrong] = []  # what the last answer reported
        self.address = ""  # of this host as seen from there, empty if unknown
        self.left: int | None = None  # processes that could not be ended, once the guard has ended the others
        self._answered = time.monotonic()
        self._asked = self._received = 0
        self._rest = b""
        self._is_ready = self._is_closed = False
        parent = os.getpid()
        self._popen = subprocess.Popen(
            hosts.connecting_command(host, hosts.guard_command(GUARD, mark)),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
            preexec_fn=lambda: end_with_parent(parent, 9),
        )
        self.pid = self._popen.pid
        self._order = {**order, "host": host}
        pipes = (self._popen.stdin, self._popen.stdout, self._popen.stderr)
        self._stdin, self._stdout, self._stderr = self._pipes = [pipe for pipe in pipes if pipe]
        for pipe in self._pipes:
            os.set_blocking(pipe.fileno(), False)
        self._send(self._order)

    def wait_until_ready(self) -> None:
        """Raises Stop(2) if the host cannot take part."""
        deadline = self._answered + _READY_WITHIN_S
        while not self._is_ready:
            self.read()
            if self._is_closed or time.monotonic() > deadline:
                why = self.why_closed() if self._is_closed else f"no answer within {_READY_WITHIN_S:.0f} s"
                raise Stop(ExitCode.BAD_CASE, hosts.not_reached(self.host, why))
            time.sleep(0.01)

    def ask(self) -> None:
        """One question more; answers to earlier ones are read."""
        self.read()
        self._asked += 1
        self._send({"ping": self._asked, "received": self._received})

    @property
    def is_closed(self) -> bool:
        return self._is_closed

    @property
    def silent_s(self) -> float:
        """Since the last answer."""
        return time.monotonic() - self._answered

    def forgive(self) -> None:
        """The silence was ours."""
        self._answered = time.monotonic()

    def end(self) -> None:
        """Asks the guard to end everything there."""
        self._send({"end": True})

    def end_stopped_guard(self) -> None:
        """Reaches the host anew to end a guard that does not answer; nothing happens if the host does not either."""
        command = hosts.connecting_command(self.host, hosts.ending_command(GUARD, self._mark))
        with suppress(subprocess.TimeoutExpired):
            subprocess.run(
                command,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
                timeout=_REACHED_WITHIN_S,
            )

    def read(self) -> None:
        """Takes what has arrived."""
        while not self._is_closed:
            try:
                received = os.read(self._stdout.fileno(), 1 << 16)
            except BlockingIOError:
                return
            self._is_closed = not received
            *lines, self._rest = (self._rest + received).split(b"\n")
            for line in lines:
                self._take(line)

    def why_closed(self) -> str:
        """The last line of ssh, or how it ended."""
        try:
            code: int | None = self._popen.wait(timeout=1)
        except subprocess.TimeoutExpired:
            code = None
        try:
            lines = (self._stderr.read() or b"").decode(errors="replace").strip().splitlines()
        except OSError:
            lines = []
        if code is not None and code < 0:
            return f"its connection, process {self.pid}, was killed by signal {-code}"
        return lines[-1].strip().rstrip(".") if lines else f"the connection ended with code {code}"

    def close(self) -> None:
        self._popen.kill()
        self._popen.wait()
        for pipe in self._pipes:
            with suppress(OSError):
                pipe.close()

    def _take(self, line: bytes) -> None:
        try:
            answer = json.loads(line)
        except ValueError:  # what a login script prints
            return
        if not isinstance(answer, dict):
            return
        self._answered = time.monotonic()
        if "ready" in answer:
            self._check(answer)
        elif "pong" in answer:
            self._received = answer["pong"]
            self.wrong = [Wrong(**wrong) for wrong in answer["wrong"]]
        elif "ended" in answer:
            self.left = answer["ended"]

    def _check(self, answer: Mapping[str, Any]) -> None:
        if answer["problem"]:
            raise Stop(ExitCode.BAD_CASE, f"host {self.host}: {answer['problem']}")
        if self._order["build"] not in ("", answer["build"]):
            raise Stop(
                ExitCode.BAD_CASE,
                f"host {self.host}: {self._order['program']} is of another build than here. "
                "Copy the checkout, or build it there.",
            )
        self.address, self._is_ready = answer["address"], True

    def _send(self, words: Mapping[str, Any]) -> None:
        with suppress(OSError):  # full, because nothing has been read for long, or closed: seen where answers are read
            os.write(self._stdin.fileno(), json.dumps(words).encode() + b"\n")
