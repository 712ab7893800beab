"""What the command writes to the terminal: lines for people or JSON, and one line per stage of the preparation."""

import enum
import codecs
import io
import json
import locale
import os
import re
import sys
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any, TextIO

UPDATE_EVERY_S = 15.0  # of a stage's progress where the line cannot be redrawn


def elapsed_text(seconds: float) -> str:
    """Duration for people: «4 s», «2 min 05 s», «3 h 20 min»."""
    minutes, rest = divmod(int(seconds + 0.5), 60)
    if minutes == 0:
        return f"{rest} s"
    return f"{minutes} min {rest:02d} s" if minutes < 60 else f"{minutes // 60} h {minutes % 60:02d} min"


# All but line feeds and tabs; with them the characters that change the direction of a line.
_CONTROL_CHARACTERS = re.compile(
    "[\\x00-\\x08\\x0b-\\x1f\\x7f-\\x9f\\u061c\\u200e\\u200f\\u202a-\\u202e\\u2066-\\u2069]"
)


def printable(text: str) -> str:
    """The text with control characters written as \\x1b: names and files from elsewhere may hold them."""
    return _CONTROL_CHARACTERS.sub(lambda found: found[0].encode("unicode_escape").decode(), text)


class _Output(io.TextIOWrapper):
    """Standard output or error: whatever is written, a terminal only obeys `redraw`."""

    def write(self, text: str, /) -> int:
        return super().write(printable(text))

    write_as_it_is = io.TextIOWrapper.write


def _encoding_of_locale() -> str:
    """UTF-8, too, for a locale that is not installed here: it names a terminal elsewhere, and C has no «µ»."""
    try:
        locale.setlocale(locale.LC_CTYPE, "")
    except locale.Error:
        return "utf-8"
    return locale.getencoding()


def open_outputs() -> None:
    """Makes standard output and error usable in any locale and if they are closed; for Python programs started, too."""
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest that is free: this one
    encoding, _, _ = os.environ.get("PYTHONIOENCODING", "").partition(":")
    encoding = encoding or _encoding_of_locale()
    os.environ["PYTHONIOENCODING"] = f"{encoding}:replace"
    for name, descriptor in (("stdout", 1), ("stderr", 2)):
        buffer = open(descriptor, "wb", closefd=False)
        is_read_at_once = descriptor == 2 or buffer.raw.isatty()
        setattr(sys, name, _Output(buffer, encoding, "replace", line_buffering=is_read_at_once))


def is_utf8(stream: TextIO) -> bool:
    """Whether the stream can show every character; «UTF-8» and «utf8» are one encoding."""
    return codecs.lookup(stream.encoding or "ascii").name == "utf-8"


def write(stream: TextIO, text: str) -> None:
    """Writes and flushes; a reader that went away (`copepod run … 2>&1 | head`) or a full disk must not end a run."""
    _write_by(stream.write, stream, text)


def redraw(stream: TextIO, text: str, end: str = "") -> None:
    """Writes over the line of a terminal that was drawn last."""
    _write_by(getattr(stream, "write_as_it_is", stream.write), stream, f"\r{printable(text)}\033[K{end}")


def _write_by(write: Callable[[str], int], stream: TextIO, text: str) -> None:
    try:
        write(text)
        stream.flush()
    except OSError:
        silence(stream)


def silence(stream: TextIO) -> None:
    """Discards what the stream still holds and what follows; Python would otherwise complain about it at its end."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)


class Voice(enum.Enum):
    """How the command talks on stderr."""

    LINES = "lines for people"
    JSON = "one JSON object per line"
    QUIET = "errors only"


_voice = Voice.LINES


def speak(voice: Voice) -> None:
    """From now on in this way; as JSON, a line is {"event": "notice", "text": …}."""
    global _voice
    _voice = voice


def is_quiet() -> bool:
    return _voice is Voice.QUIET


def speaks_json() -> bool:
    return _voice is Voice.JSON


def say(text: str) -> None:
    """A line of the command's own on stderr."""
    if not is_quiet():
        complain(text)


def complain(text: str) -> None:
    """A line that is written in quiet mode, too: why the command ends."""
    say_lines(f"copepod: {text}\n")


def say_lines(text: str) -> None:
    """Lines of another program on stderr."""
    if _voice is Voice.JSON:
        text = "".join(notice(line.removeprefix("copepod: ")) for line in text.splitlines())
    write(sys.stderr, text)


def report(event: str, **details: Any) -> None:
    """An event for a program that reads JSON lines; people are not shown it."""
    if speaks_json():
        write(sys.stderr, json.dumps({"event": event, **details}) + "\n")


def notice(text: str) -> str:
    """A line for people, as an event."""
    return json.dumps({"event": "notice", "text": text}) + "\n"


class Stage:
    """Context of one stage; the line is opened on entry and closed with the elapsed time on exit."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._terminal = sys.stderr.isatty() and _voice is Voice.LINES

    def __enter__(self) -> "Stage":
        self._start = time.monotonic()
        self._next_update = self._start + UPDATE_EVERY_S
        if _voice is not Voice.LINES:
            say(f"{self._text} …")
        else:
            write(sys.stderr, f"copepod: {self._text} … ")
        return self

    def count(self, done: int, total: int) -> None:
        """Shows how far the stage is: at once on a terminal, now and then elsewhere. Without `total`: for how long."""
        now = time.monotonic()
        if self._terminal or now >= self._next_update:
            self._next_update = now + UPDATE_EVERY_S
            self._show(f"{done}/{total}" if total else elapsed_text(now - self._start))

    def __exit__(
        self,
        exception_type: type[BaseException] | None,
        exception: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        outcome = "" if exception_type is None else "failed after "
        self._show(f"{outcome}{elapsed_text(time.monotonic() - self._start)}", "\n")

    def _show(self, text: str, end: str = "") -> None:
        """How far the stage is or, with the `end` of the line, how long it took."""
        if _voice is not Voice.LINES:
            say(f"{self._text} … {text}")
        elif self._terminal:
            redraw(sys.stderr, f"copepod: {self._text} … {text}{'' if end else ' '}", end)
        else:
            write(sys.stderr, f"{text}{end or ' … '}")
