"""The command's own lines on stderr, for people or as JSON, and one line per stage of the preparation."""

import json
import os
import sys
import time
from types import TracebackType
from typing import TextIO

UPDATE_EVERY_S = 15.0  # of a stage's progress where the line cannot be redrawn


def elapsed_text(seconds: float) -> str:
    """Duration for people: «4 s», «2 min 05 s», «3 h 20 min»."""
    minutes, rest = divmod(int(seconds + 0.5), 60)
    if minutes == 0:
        return f"{rest} s"
    return f"{minutes} min {rest:02d} s" if minutes < 60 else f"{minutes // 60} h {minutes % 60:02d} min"


def write(stream: TextIO, text: str) -> None:
    """Writes and flushes; a reader that went away (`copepod run … 2>&1 | head`) or a full disk must not end a run."""
    try:
        stream.write(text)
        stream.flush()
    except OSError:
        silence(stream)


def silence(stream: TextIO) -> None:
    """Discards what the stream still holds and what follows; Python would otherwise complain about it at its end."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)


_speaks_json = False


def speak_json() -> None:
    """From now on every line on stderr is a JSON object: {"event": "notice", "text": …}."""
    global _speaks_json
    _speaks_json = True


def say(text: str) -> None:
    """A line of the command's own on stderr."""
    say_lines(f"copepod: {text}\n")


def say_lines(text: str) -> None:
    """Lines of another program on stderr."""
    if _speaks_json:
        text = "".join(notice(line.removeprefix("copepod: ")) for line in text.splitlines())
    write(sys.stderr, text)


def notice(text: str) -> str:
    """A line for people, as an event."""
    return json.dumps({"event": "notice", "text": text}) + "\n"


class Stage:
    """Context of one stage; the line is opened on entry and closed with the elapsed time on exit."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._terminal = sys.stderr.isatty() and not _speaks_json

    def __enter__(self) -> "Stage":
        self._start = time.monotonic()
        self._next_update = self._start + UPDATE_EVERY_S
        if _speaks_json:
            say(f"{self._text} …")
        else:
            self._write(f"copepod: {self._text} … ")
        return self

    def count(self, done: int, total: int) -> None:
        """Shows how far the stage is: at once on a terminal, now and then elsewhere. Without `total`: for how long."""
        now = time.monotonic()
        progress = f"{done}/{total}" if total else elapsed_text(now - self._start)
        if self._terminal:
            self._write(f"\r\033[Kcopepod: {self._text} … {progress} ")
        elif now >= self._next_update:
            self._next_update = now + UPDATE_EVERY_S
            if _speaks_json:
                say(f"{self._text} … {progress}")
            else:
                self._write(f"{progress} … ")

    def __exit__(
        self,
        exception_type: type[BaseException] | None,
        exception: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        outcome = "" if exception_type is None else "failed after "
        ending = f"{outcome}{elapsed_text(time.monotonic() - self._start)}"
        if _speaks_json:
            say(f"{self._text} … {ending}")
        elif self._terminal:
            self._write(f"\r\033[Kcopepod: {self._text} … {ending}\n")
        else:
            self._write(f"{ending}\n")

    @staticmethod
    def _write(text: str) -> None:
        write(sys.stderr, text)
