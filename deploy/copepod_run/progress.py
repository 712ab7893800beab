"""How far a run is: the coupler's events, shown as a bar on a terminal and as lines every few seconds elsewhere."""

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from copepod_run.messages import draw, draws, is_utf8, report, say, speaks_json, width
from copepod_run.run_directory import replace_text

Event = dict[str, Any]

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


def speed_text(steps_per_s: float, cells: int) -> str:
    """«412 steps/s, 101 MLUPS» (million lattice cell updates per second)."""
    text = f"{_three_digits(steps_per_s)} steps/s"
    return f"{text}, {_three_digits(steps_per_s * cells / 1e6)} MLUPS" if cells else text


def _three_digits(value: float) -> str:
    return f"{value:.{0 if value >= 100 else 1 if value >= 10 else 2}f}"


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


class Progress:
    """Shows how far a run is, and keeps phase and last step in a file for `copepod watch`."""

    def __init__(self, cells: int, path: Path, clock: Callable[[], float] = time.monotonic) -> None:
        """`cells`: per step, for the speed in MLUPS."""
        self._cells = cells
        self._path = path
        self._clock = clock
        self._next_record = self._next_line = 0.0
        self._has_bar = False
        self._state: Event = {}

    def phase(self, name: str) -> None:
        self._state["phase"] = name
        self._record()
        if speaks_json():
            report("phase", phase=name)
        elif not draws():
            say(name)
        elif not self._has_bar:  # which stays
            draw(f"copepod: {name} …")

    def step(self, event: Event) -> None:
        self._state |= event
        now, is_last = self._clock(), event["step"] == event["steps"]
        if is_last or now >= self._next_record:
            self._next_record = now + RECORD_EVERY_S
            self._record()
        if speaks_json():
            report(**event)
        elif draws():
            self._has_bar = True
            draw(bar(event, self._cells, width()))
        elif is_last or now >= self._next_line:
            self._next_line = now + LINE_EVERY_S
            percent = 100.0 * event["step"] / max(event["steps"], 1)
            words = [f"step {event['step']} of {event['steps']} ({percent:.0f} %)", *figures(event, self._cells)]
            say(", ".join(words))

    def _record(self) -> None:
        replace_text(self._path, json.dumps(self._state) + "\n")


def bar(event: Event, cells: int, columns: int) -> str:
    """A bar with its figures in at most so many columns; what does not fit is left out from the right."""
    full, empty = ("━", "╌") if is_utf8(sys.stderr) else ("#", ".")
    steps = str(event["steps"])
    share = min(event["step"] / max(event["steps"], 1), 1.0)
    head = f"{int(100 * share):3d} % "
    words = [f"step {event['step']:>{len(steps)}}/{steps}"]
    words += [word.ljust(places) for word, places in zip(figures(event, cells), _PLACES)]
    while words and len(head) + len("  ".join(words)) + _NARROWEST_BAR > columns:
        words.pop()
    tail = "  ".join(["", *words])
    length = max(min(_WIDEST_BAR, columns - len(head) - len(tail)), 0)
    done = int(share * length)
    return (head + full * done + empty * (length - done) + tail)[:columns].rstrip()
