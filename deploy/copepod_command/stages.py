"""One line on stderr per stage of the preparation: what is done, a counter on a terminal, the time it took."""

import sys
import time


def elapsed_text(seconds):
    """Duration for people: «4 s», «2 min 05 s», «3 h 20 min»."""
    seconds = int(seconds + 0.5)
    if seconds < 60:
        return f"{seconds} s"
    if seconds < 3600:
        return f"{seconds // 60} min {seconds % 60:02d} s"
    return f"{seconds // 3600} h {seconds % 3600 // 60:02d} min"


def write(stream, text):
    """Writes and flushes; a reader that went away (`copepod run … 2>&1 | head`) must not end a run."""
    try:
        stream.write(text)
        stream.flush()
    except BrokenPipeError:
        pass


def say(text):
    """A line of the command's own on stderr."""
    write(sys.stderr, f"copepod: {text}\n")


class Stage:
    """Context of one stage; the line is opened on entry and closed with the elapsed time on exit."""

    def __init__(self, text):
        self._text = text
        self._terminal = sys.stderr.isatty()

    def __enter__(self):
        self._start = time.monotonic()
        self._write(f"copepod: {self._text} … ")
        return self

    def count(self, done, total):
        """Shows how far the stage is; on a terminal only."""
        if self._terminal:
            self._write(f"\r\033[Kcopepod: {self._text} … {done}/{total} ")

    def __exit__(self, exception_type, exception, traceback):
        if self._terminal:
            self._write(f"\r\033[Kcopepod: {self._text} … ")
        outcome = "" if exception_type is None else "failed after "
        self._write(f"{outcome}{elapsed_text(time.monotonic() - self._start)}\n")

    @staticmethod
    def _write(text):
        write(sys.stderr, text)
