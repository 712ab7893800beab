"""The progress display on terminals and elsewhere, and the reader of the coupler's events."""

import io
import unittest

import copepod_session  # noqa: F401  (makes the command's modules importable)
from copepod_run.progress import EventReader, PlainProgress, TerminalProgress, clock_text, for_stream

EVENT = {"event": "progress", "step": 500, "steps": 1000, "steps_per_s": 123.4, "remaining_s": 4.05}


class Terminal(io.TextIOWrapper):
    """A UTF-8 stream that pretends to be a terminal."""

    def __init__(self):
        super().__init__(io.BytesIO(), encoding="utf-8")

    def isatty(self):
        return True

    def text(self):
        self.flush()
        return self.buffer.getvalue().decode()


class Plain(unittest.TestCase):
    def lines_at(self, times, steps=None):
        """Lines written for one progress event at each of the times."""
        stream, clock = io.StringIO(), iter(times)
        display = PlainProgress(stream, cells=2_000_000, clock=lambda: next(clock))
        for step in steps or [500] * len(times):
            display.step({**EVENT, "step": step})
        return stream.getvalue().splitlines()

    def test_line_shows_step_share_speed_and_time_left(self):
        self.assertEqual(
            self.lines_at([100.0]), ["copepod: step 500 of 1000 (50 %), 0:04 left, 123 steps/s, 247 MLUPS"]
        )

    def test_there_is_no_rate_before_the_first_step(self):
        stream = io.StringIO()
        PlainProgress(stream, cells=8).step({**EVENT, "step": 0, "steps_per_s": 0.0, "remaining_s": 0.0})
        self.assertEqual(stream.getvalue(), "copepod: step 0 of 1000 (0 %)\n")

    def test_lines_come_every_five_seconds(self):
        self.assertEqual(len(self.lines_at([100.0, 100.2, 104.9, 105.1, 107.0, 110.2])), 3)

    def test_last_step_is_always_shown(self):
        self.assertEqual(len(self.lines_at([100.0, 100.1], steps=[0, 1000])), 2)

    def test_no_control_characters(self):
        self.assertTrue(all(character.isprintable() for character in self.lines_at([100.0])[0]))


class OnTerminal(unittest.TestCase):
    def test_bar_never_exceeds_the_width(self):
        display = TerminalProgress(Terminal(), cells=2_000_000)
        for width in range(8, 200):
            for step in (0, 1, 500, 999, 1000):
                self.assertLessEqual(len(display.line({**EVENT, "step": step}, width)), width)

    def test_figures_leave_from_the_right_when_it_is_narrow(self):
        display = TerminalProgress(Terminal(), cells=2_000_000)
        self.assertIn("MLUPS", display.line(EVENT, 120))
        self.assertNotIn("MLUPS", display.line(EVENT, 60))
        self.assertIn("0:04 left", display.line(EVENT, 60))
        self.assertIn("50 %", display.line(EVENT, 20))

    def test_half_of_the_bar_is_full_at_half_time(self):
        line = TerminalProgress(Terminal(), cells=0).line(EVENT, 200)
        self.assertEqual((line.count("━"), line.count("╌")), (20, 20))

    def test_line_is_redrawn_in_place(self):
        terminal = Terminal()
        display = TerminalProgress(terminal, cells=0)
        display.step(EVENT)
        display.step(EVENT)
        self.assertEqual(terminal.text().count("\r"), 2)
        self.assertNotIn("\n", terminal.text())
        display.close()
        self.assertTrue(terminal.text().endswith("\n"))

    def test_pipe_gets_plain_lines(self):
        self.assertIsInstance(for_stream(io.StringIO(), 0), PlainProgress)

    def test_clock(self):
        self.assertEqual(
            [clock_text(seconds) for seconds in (-1, 7.4, 751, 11040)], ["0:00", "0:07", "12:31", "3:04:00"]
        )


class Events(unittest.TestCase):
    def test_event_may_arrive_in_pieces(self):
        reader = EventReader()
        self.assertEqual(reader.feed(b'{"event":"pha'), [])
        self.assertEqual(
            reader.feed(b'se","phase":"running"}\n{"event":"x"}\n{"ev'),
            [{"event": "phase", "phase": "running"}, {"event": "x"}],
        )

    def test_other_lines_are_set_apart(self):
        others = []
        reader = EventReader(others.append)
        self.assertEqual(reader.feed(b'hello\n[1]\n{"no": "event"}\n\xff\xfe\n{"event":"x"}\n'), [{"event": "x"}])
        self.assertEqual(others, [b"hello", b"[1]", b'{"no": "event"}', b"\xff\xfe"])


if __name__ == "__main__":
    unittest.main()
