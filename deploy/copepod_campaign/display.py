"""How far a campaign is: a line that is redrawn on a terminal, a plain line every minute elsewhere."""

import sys
import time
from collections.abc import Callable
from typing import TextIO

from copepod_campaign.entry import Entry, State
from copepod_campaign.pool import Pool
from copepod_run.progress import clock_text, redraws, width_of
from copepod_run.messages import elapsed_text, is_quiet, redraw, report, say, speaks_json, write

_LINE_EVERY_S = 60.0


def for_stderr(name: str, pool: Pool) -> "PlainDisplay":
    if is_quiet():
        return QuietDisplay(sys.stderr, name, pool)
    if speaks_json():
        return EventDisplay(sys.stderr, name, pool)
    return (TerminalDisplay if redraws(sys.stderr) else PlainDisplay)(sys.stderr, name, pool)


class PlainDisplay:
    """Lines for logs and pipes: what starts and ends, and a look at the whole every minute."""

    def __init__(self, stream: TextIO, name: str, pool: Pool, clock: Callable[[], float] = time.monotonic) -> None:
        self._stream = stream
        self._name = name
        self._pool = pool
        self._clock = clock
        self._next = clock() + _LINE_EVERY_S

    def notice(self, text: str) -> None:
        write(self._stream, f"copepod: {text}\n")

    def ended(self, entry: Entry) -> None:
        if entry.state is State.DONE:
            self.notice(f"{entry.name}: done{_wall_text(entry)}")
        elif entry.state is State.FAILED:
            self.notice(f"{entry.name}: failed. {entry.remark}")
        else:
            self.notice(f"{entry.name}: stopped")

    def draw(self) -> None:
        now = self._clock()
        if now >= self._next:
            self._next = now + _LINE_EVERY_S
            self.notice(self.line())

    def close(self) -> None:
        pass

    def line(self) -> str:
        """«paper: 23 %, 3 of 17 done, 2:31:00 left; design_d 45 %, design_e 12 %»"""
        entries = self._pool.entries
        done = sum(entry.state is State.DONE for entry in entries)
        words = [f"{self._name}: {100 * self._pool.share():.0f} %", f"{done} of {len(entries)} done"]
        remaining = self._pool.remaining_s()
        if remaining is not None:
            words.append(f"{clock_text(remaining)} left")
        running = ", ".join(f"{job.entry.name} {100 * job.share:.0f} %" for job in self._pool.running)
        return ", ".join(words) + (f"; {running}" if running else "")


class QuietDisplay(PlainDisplay):
    """Only what fails."""

    def notice(self, text: str) -> None:
        ...

    def ended(self, entry: Entry) -> None:
        if entry.state is State.FAILED:
            super().notice(f"{entry.name}: failed. {entry.remark}")


class EventDisplay(PlainDisplay):
    """The same as JSON lines, for a program that shows them in its own way; step and steps count cases."""

    def notice(self, text: str) -> None:
        say(text)

    def draw(self) -> None:
        entries = self._pool.entries
        done = sum(entry.state is State.DONE for entry in entries)
        share, remaining_s = self._pool.share(), self._pool.remaining_s()
        report("progress", step=done, steps=len(entries), share=share, remaining_s=remaining_s)

    def close(self) -> None:
        self.draw()


class TerminalDisplay(PlainDisplay):
    """One line, redrawn in place; what starts and ends stands above it."""

    def notice(self, text: str) -> None:
        redraw(self._stream, f"copepod: {text}", "\n")

    def draw(self) -> None:
        text = f"copepod: {self.line()}"
        redraw(self._stream, text[: width_of(self._stream)])

    def close(self) -> None:
        redraw(self._stream, "")


def _wall_text(entry: Entry) -> str:
    wall_s = (entry.summary or {}).get("wall_s")
    return f" after {elapsed_text(wall_s)} of computing" if wall_s else ""
