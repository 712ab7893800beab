"""Ctrl-C and its relatives while a run is on: recorded, and readable on a file descriptor."""

import os
import signal
from contextlib import suppress
from types import FrameType


class SignalRecorder:
    """Context in which SIGINT, SIGTERM and SIGHUP only leave a note; ignored signals (nohup) stay ignored.

    SIGUSR1 asks for a checkpoint and does not end anything; deploy/copepod ignores it outside.
    """

    def __init__(self) -> None:
        self.received: list[int] = []
        self.checkpoint_wanted = False

    def __enter__(self) -> "SignalRecorder":
        self.descriptor, self._writing_end = os.pipe()
        for end in (self.descriptor, self._writing_end):
            os.set_blocking(end, False)
        self._former_wakeup = signal.set_wakeup_fd(self._writing_end, warn_on_full_buffer=False)
        self._former = {}
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) is not signal.SIG_IGN:
                self._former[number] = signal.signal(number, lambda number, _: self.received.append(number))
        self._former[signal.SIGUSR1] = signal.signal(signal.SIGUSR1, self._want_checkpoint)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._former.items():
            signal.signal(number, handler)
        signal.set_wakeup_fd(self._former_wakeup)
        os.close(self.descriptor)
        os.close(self._writing_end)

    def drain(self) -> None:
        """Empties the descriptor."""
        with suppress(BlockingIOError):
            os.read(self.descriptor, 4096)

    def _want_checkpoint(self, number: int, frame: FrameType | None) -> None:
        self.checkpoint_wanted = True
