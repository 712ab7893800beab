"""A `copepod run` as a process of its own, for campaigns and Python: its events, its lines, and how it ends."""

import os
import subprocess
from collections.abc import Mapping, Sequence
from typing import IO

from copepod_run.processes import start_child
from copepod_run.progress import Event, EventReader


class RunProcess:
    """Ends with the thread that has started it. SIGTERM lets it write a checkpoint."""

    def __init__(self, command: Sequence[str], environment: Mapping[str, str], output: IO[bytes] | int) -> None:
        """`command`: up to its options; `output`: for the result table."""
        self._popen = start_child(
            [*command, "--progress", "json"],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.PIPE,
        )
        assert self._popen.stderr is not None
        self._stderr = self._popen.stderr
        self.descriptor = self._stderr.fileno()  # becomes readable when there is something to read()
        self.exit_code: int | None = None  # 128 + number if a signal has ended it
        self._reader = EventReader(on_other=lambda line: self._note(line.decode(errors="replace")))

    def read(self) -> None:
        """Takes what has arrived, after waiting for some; at the end of the process `exit_code` is set."""
        received = os.read(self.descriptor, 65536)
        for event in self._reader.feed(received):
            if event["event"] == "notice":
                self._note(f"copepod: {event['text']}")
            else:
                self._take(event)
        if not received:
            code = self._popen.wait()
            self._stderr.close()
            self.exit_code = code if code >= 0 else 128 - code

    def _take(self, event: Event) -> None:
        """For derived classes: an event that is not a notice."""

    def _note(self, line: str) -> None:
        """For derived classes: a line for people."""

    def send(self, number: int) -> None:
        self._popen.send_signal(number)
