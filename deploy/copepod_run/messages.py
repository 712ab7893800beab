"""What the command writes to the terminal: lines for people or JSON, and one line per stage of the preparation."""

import codecs
import enum
import io
import json
import locale
import os
import re
import sys
import time
from collections.abc import Callable
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
    """Standard output or error: whatever is written, a terminal only obeys `draw`."""

    def write(self, text: str, /) -> int:
        return super().write(printable(text))

    write_as_it_is = io.TextIOWrapper.write


def open_outputs() -> None:
    """Makes standard output and error usable in any locale and if they are closed; for Python programs started, too."""
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest that is free: this one
    encoding, _, _ = os.environ.get("PYTHONIOENCODING", "").partition(":")
    if not encoding:
        try:
            locale.setlocale(locale.LC_CTYPE, "")
            encoding = locale.getencoding()
        except locale.Error:  # one that is not installed here: it names a terminal elsewhere, and C has no «µ»
            encoding = "utf-8"
    os.environ["PYTHONIOENCODING"] = f"{encoding}:replace"
    for name, descriptor in (("stdout", 1), ("stderr", 2)):
        buffer = open(descriptor, "wb", closefd=False)
        is_read_at_once = descriptor == 2 or buffer.raw.isatty()
        setattr(sys, name, _Output(buffer, encoding, "replace", line_buffering=is_read_at_once))


def is_utf8(stream: TextIO) -> bool:
    """Whether the stream can show every character; «UTF-8» and «utf8» are one encoding."""
    return codecs.lookup(stream.encoding or "ascii").name == "utf-8"


def draws() -> bool:
    """Whether stderr is for people, at a terminal, where a line can be drawn again in place."""
    return _voice is Voice.LINES and sys.stderr.isatty() and os.environ.get("TERM", "dumb") != "dumb"


def width() -> int:
    """Columns of a line that does not wrap."""
    try:
        return os.get_terminal_size(sys.stderr.fileno()).columns - 1
    except OSError:
        return 79


def draw(text: str, end: str = "") -> None:
    """Draws a line of the terminal. It stays if it has an `end`; otherwise what is written next replaces it."""
    global _is_drawn
    _is_drawn = bool(text) and not end
    text = printable(text) if end else printable(text)[: width()]
    _write(getattr(sys.stderr, "write_as_it_is", sys.stderr.write), f"\r{text}\033[K{end}")


def keep_drawn() -> None:
    """The line that was drawn last stays."""
    global _is_drawn
    if _is_drawn:
        _is_drawn = False
        _write(sys.stderr.write, "\n")


def _write(write: Callable[[str], int], text: str) -> None:
    """A reader that went away (`copepod run … 2>&1 | head`) or a full disk must not end a run."""
    try:
        write(text)
        sys.stderr.flush()
    except OSError:
        silence(sys.stderr)


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
_is_drawn = False


def speak(voice: Voice) -> None:
    """From now on in this way; as JSON, a line is {"event": "notice", "text": …}."""
    global _voice
    _voice = voice


def speaks_json() -> bool:
    return _voice is Voice.JSON


def say(text: str) -> None:
    """A line of the command's own on stderr."""
    if _voice is not Voice.QUIET:
        complain(text)


def complain(text: str) -> None:
    """A line that is written in quiet mode, too: why the command ends."""
    say_lines(f"copepod: {text}\n")


def say_lines(text: str) -> None:
    """Lines of another program on stderr."""
    if speaks_json():
        for line in text.splitlines():
            report("notice", text=line.removeprefix("copepod: "))
        return
    if _is_drawn:
        draw("")
    _write(sys.stderr.write, text)


def report(event: str, **details: Any) -> None:
    """An event for a program that reads JSON lines; people are not shown it."""
    if speaks_json():
        _write(sys.stderr.write, json.dumps({"event": event, **details}) + "\n")


class Stage:
    """Context of one stage; the line is opened on entry and closed with the elapsed time on exit."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._terminal = draws()

    def __enter__(self) -> "Stage":
        self._start = time.monotonic()
        self._next_update = self._start + UPDATE_EVERY_S
        self._show("")
        return self

    def count(self, done: int, total: int) -> None:
        """Shows how far the stage is: at once on a terminal, now and then elsewhere. Without `total`: for how long."""
        now = time.monotonic()
        if self._terminal or now >= self._next_update:
            self._next_update = now + UPDATE_EVERY_S
            self._show(f"{done}/{total}" if total else elapsed_text(now - self._start))

    def __exit__(self, exception_type: type[BaseException] | None, *_: object) -> None:
        outcome = "" if exception_type is None else "failed after "
        self._show(f"{outcome}{elapsed_text(time.monotonic() - self._start)}", "\n")

    def _show(self, text: str, end: str = "") -> None:
        """Nothing at first, then how far the stage is or, with the `end` of the line, how long it took."""
        if _voice is not Voice.LINES:
            say(f"{self._text} … {text}".rstrip())
        elif self._terminal:
            draw(f"copepod: {self._text} … {text}{' ' if text and not end else ''}", end)
        else:
            _write(sys.stderr.write, (text or f"copepod: {self._text}") + (end or " … "))
