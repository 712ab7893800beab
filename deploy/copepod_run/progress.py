"""How far a run is: the coupler's events, shown as a bar on a terminal and as lines every few seconds elsewhere."""

import json
import os
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, TextIO

from copepod_run.messages import is_quiet, is_utf8, notice, redraw, write

Event = dict[str, Any]
Clock = Callable[[], float]

LINE_EVERY_S = 5.0
RECORD_EVERY_S = 0.5
_WIDEST_BAR = 40
_NARROWEST_BAR = 10
_PLACES = (12, 22)  # columns of time left and speed, so that the bar does not shake


class EventReader:
    """Parses what the coupler writes on its stdout, and a run on its stderr: one JSON object per line."""

    def __init__(self, on_other: Callable[[bytes], None] = lambda line: None) -> None:
        """`on_other(line)`: called for every line that is not an event."""
        self._rest = b""
        self._on_other = on_other

    def feed(self, received: bytes) -> list[Event]:
        """Events that `received` completes."""
        *lines, self._rest = (self._rest + received).split(b"\n")
        events = []
        for line in lines:
            try:
                event = json.loads(line)
            except ValueError:
                event = None
            if isinstance(event, dict) and "event" in event:
                events.append(event)
            else:
                self._on_other(line)
        return events


def for_stream(stream: TextIO, cells: int) -> "Progress":
    """The display that suits `stream`; `cells` is the number of cells per step, for the speed in MLUPS."""
    if is_quiet():
        return Progress()
    return (TerminalProgress if redraws(stream) else PlainProgress)(stream, cells)


def redraws(stream: TextIO) -> bool:
    """Whether a line can be drawn again in place."""
    return stream.isatty() and os.environ.get("TERM", "dumb") != "dumb"


def width_of(stream: TextIO) -> int:
    """Columns of a line that does not wrap."""
    try:
        return os.get_terminal_size(stream.fileno()).columns - 1
    except OSError:
        return 79


class Progress:
    """A display of one run; this one shows nothing, as in quiet mode."""

    def phase(self, name: str) -> None:
        ...

    def step(self, event: Event) -> None:
        ...

    def notice(self, text: str) -> None:
        ...

    def close(self) -> None:
        ...


class EventProgress(Progress):
    """Phases and steps as JSON lines, for a program that shows them in its own way."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def phase(self, name: str) -> None:
        self._write({"event": "phase", "phase": name})

    def step(self, event: Event) -> None:
        self._write(event)

    def notice(self, text: str) -> None:
        write(self._stream, notice(text))

    def _write(self, event: Event) -> None:
        write(self._stream, json.dumps(event) + "\n")


def speed_text(steps_per_s: float, cells: int) -> str:
    """«412 steps/s, 101 MLUPS» (million lattice cell updates per second)."""
    text = f"{_three_digits(steps_per_s)} steps/s"
    return f"{text}, {_three_digits(steps_per_s * cells / 1e6)} MLUPS" if cells else text


def _three_digits(value: float) -> str:
    if value >= 100:
        return f"{value:.0f}"
    return f"{value:.1f}" if value >= 10 else f"{value:.2f}"


def figures(event: Event, cells: int) -> list[str]:
    """Time left and speed of a progress event; nothing before there is a rate."""
    if not event["steps_per_s"]:
        return []
    return [f"{clock_text(event['remaining_s'])} left", speed_text(event["steps_per_s"], cells)]


def clock_text(seconds: float) -> str:
    """Time left: «0:07», «12:31», «3:04:00»."""
    seconds = int(max(seconds, 0) + 0.5)
    hours, minutes = seconds // 3600, seconds % 3600 // 60
    return f"{hours}:{minutes:02d}:{seconds % 60:02d}" if hours else f"{minutes}:{seconds % 60:02d}"


class PlainProgress(Progress):
    """Lines for logs and pipes: every phase, a step line every few seconds and for the last step."""

    def __init__(self, stream: TextIO, cells: int, clock: Clock = time.monotonic) -> None:
        self._stream = stream
        self._cells = cells
        self._clock = clock
        self._next = 0.0

    def phase(self, name: str) -> None:
        self._write(name)

    def step(self, event: Event) -> None:
        now = self._clock()
        if now < self._next and event["step"] != event["steps"]:
            return
        self._next = now + LINE_EVERY_S
        percent = 100.0 * event["step"] / max(event["steps"], 1)
        words = [f"step {event['step']} of {event['steps']} ({percent:.0f} %)", *figures(event, self._cells)]
        self._write(", ".join(words))

    def notice(self, text: str) -> None:
        self._write(text)

    def _write(self, text: str) -> None:
        write(self._stream, f"copepod: {text}\n")


class TerminalProgress(Progress):
    """One line, redrawn in place, never wider than the terminal."""

    def __init__(self, stream: TextIO, cells: int) -> None:
        self._stream = stream
        self._cells = cells
        self._full, self._empty = ("━", "╌") if is_utf8(stream) else ("#", ".")
        self._drawn = False

    def phase(self, name: str) -> None:
        if not self._drawn:  # once there is a bar it stays
            self._draw(f"copepod: {name} …")

    def step(self, event: Event) -> None:
        self._drawn = True
        self._draw(self.line(event, width_of(self._stream)))

    def notice(self, text: str) -> None:
        """A line of its own, above the bar."""
        redraw(self._stream, f"copepod: {text}", "\n")

    def close(self) -> None:
        """Leaves the last state of the bar standing."""
        write(self._stream, "\n")

    def line(self, event: Event, width: int) -> str:
        """The bar with its figures in at most `width` columns; what does not fit is left out from the right."""
        steps = str(event["steps"])
        share = min(event["step"] / max(event["steps"], 1), 1.0)
        head = f"{int(100 * share):3d} % "
        words = [f"step {event['step']:>{len(steps)}}/{steps}"]
        words += [word.ljust(places) for word, places in zip(figures(event, self._cells), _PLACES)]
        while words and len(head) + len("  ".join(words)) + _NARROWEST_BAR > width:
            words.pop()
        tail = "  ".join(["", *words])
        columns = max(min(_WIDEST_BAR, width - len(head) - len(tail)), 0)
        full = int(share * columns)
        return (head + self._full * full + self._empty * (columns - full) + tail)[:width].rstrip()

    def _draw(self, text: str) -> None:
        redraw(self._stream, text[: width_of(self._stream)])


class RecordedProgress(Progress):
    """Passes everything on to another display, and keeps phase and last step in a file for `copepod watch`."""

    def __init__(self, display: Progress, path: Path, clock: Clock = time.monotonic) -> None:
        self._display = display
        self._path = path
        self._clock = clock
        self._next = 0.0
        self._state: Event = {}

    def phase(self, name: str) -> None:
        self._state["phase"] = name
        self._record()
        self._display.phase(name)

    def step(self, event: Event) -> None:
        self._state |= event
        now = self._clock()
        if now >= self._next or event["step"] == event["steps"]:
            self._next = now + RECORD_EVERY_S
            self._record()
        self._display.step(event)

    def notice(self, text: str) -> None:
        self._display.notice(text)

    def close(self) -> None:
        self._display.close()

    def _record(self) -> None:
        """Replaces the file at once; a full disk must not end a run that needs no space."""
        fresh = self._path.with_suffix(".new")
        with suppress(OSError):
            fresh.write_text(json.dumps(self._state) + "\n")
            fresh.replace(self._path)
