"""The progress display on terminals and elsewhere, and the reader of the coupler's events."""

import contextlib
import io
import itertools
import json
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import copepod_session  # noqa: F401  (makes the command's modules importable)
from copepod_run import messages
from copepod_run.progress import EventReader, Progress, bar, clock_text, speed_text

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
    def setUp(self):
        self.path = Path(self.enterContext(tempfile.TemporaryDirectory())) / "progress.json"

    def lines_at(self, times, steps=None):
        """Lines written for one progress event at each of the times."""
        clock = iter(times)
        progress = Progress(2_000_000, self.path, lambda: next(clock))
        with contextlib.redirect_stderr(io.StringIO()) as stream:
            for step in steps or [500] * len(times):
                progress.step({**EVENT, "step": step})
        return stream.getvalue().splitlines()

    def test_line_shows_step_share_speed_and_time_left(self):
        self.assertEqual(
            self.lines_at([100.0]), ["copepod: step 500 of 1000 (50 %), 0:04 left, 123 steps/s, 247 MLUPS"]
        )

    def test_phase_and_last_step_are_in_a_file_for_those_who_watch(self):
        progress = Progress(8, self.path)
        with contextlib.redirect_stderr(io.StringIO()):
            progress.phase("running")
            progress.step({**EVENT, "step": 1000})
        self.assertEqual(json.loads(self.path.read_text()), {"phase": "running", **EVENT, "step": 1000})

    def test_speeds_have_three_digits(self):
        shown = [speed_text(speed, 0) for speed in (0.123, 1.234, 12.34, 123.4, 1234.5)]
        self.assertEqual(shown, [f"{text} steps/s" for text in ("0.12", "1.23", "12.3", "123", "1234")])

    def test_there_is_no_rate_before_the_first_step(self):
        with contextlib.redirect_stderr(io.StringIO()) as stream:
            Progress(8, self.path).step({**EVENT, "step": 0, "steps_per_s": 0.0, "remaining_s": 0.0})
        self.assertEqual(stream.getvalue(), "copepod: step 0 of 1000 (0 %)\n")

    def test_lines_come_every_five_seconds(self):
        self.assertEqual(len(self.lines_at([100.0, 100.2, 104.9, 105.1, 107.0, 110.2])), 3)

    def test_last_step_is_always_shown(self):
        self.assertEqual(len(self.lines_at([100.0, 100.1], steps=[0, 1000])), 2)

    def test_no_control_characters(self):
        self.assertTrue(all(character.isprintable() for character in self.lines_at([100.0])[0]))


class OnTerminal(unittest.TestCase):
    def setUp(self):
        self.terminal = self.enterContext(contextlib.redirect_stderr(Terminal()))
        self.enterContext(mock.patch.dict("os.environ", TERM="xterm"))

    def test_bar_never_exceeds_the_width(self):
        for width in range(8, 200):
            for step in (0, 1, 500, 999, 1000):
                self.assertLessEqual(len(bar({**EVENT, "step": step}, 2_000_000, width)), width)

    def test_figures_leave_from_the_right_when_it_is_narrow(self):
        self.assertIn("MLUPS", bar(EVENT, 2_000_000, 120))
        self.assertNotIn("MLUPS", bar(EVENT, 2_000_000, 60))
        self.assertIn("0:04 left", bar(EVENT, 2_000_000, 60))
        self.assertIn("50 %", bar(EVENT, 2_000_000, 20))

    def test_half_of_the_bar_is_full_at_half_time(self):
        line = bar(EVENT, 0, 200)
        self.assertEqual((line.count("━"), line.count("╌")), (20, 20))

    def test_line_is_redrawn_in_place(self):
        progress = Progress(0, Path("no such folder/progress.json"))
        progress.step(EVENT)
        progress.step(EVENT)
        self.assertEqual(self.terminal.text().count("\r"), 2)
        self.assertNotIn("\n", self.terminal.text())
        messages.keep_drawn()
        self.assertTrue(self.terminal.text().endswith("\033[K\n"))

    def test_what_is_said_replaces_the_bar(self):
        Progress(0, Path("no such folder/progress.json")).step(EVENT)
        messages.say("warned")
        self.assertTrue(self.terminal.text().endswith("\033[K\r\033[Kcopepod: warned\n"), self.terminal.text())

    def test_clock(self):
        self.assertEqual(
            [clock_text(seconds) for seconds in (-1, 7.4, 751, 11040)], ["0:00", "0:07", "12:31", "3:04:00"]
        )


class InAnotherVoice(unittest.TestCase):
    def shown_as(self, voice):
        """What a phase, two steps and a line become."""
        self.addCleanup(messages.speak, messages.Voice.LINES)
        messages.speak(voice)
        progress = Progress(0, Path("no such folder/progress.json"))
        with contextlib.redirect_stderr(Terminal()) as stream, mock.patch.dict("os.environ", TERM="xterm"):
            progress.phase("running")
            progress.step(EVENT)
            progress.step(EVENT)
            messages.say("slow")
        return stream.text()

    def test_programs_get_every_event_and_line_as_json(self):
        lines = [json.loads(line) for line in self.shown_as(messages.Voice.JSON).splitlines()]
        self.assertEqual(
            lines, [{"event": "phase", "phase": "running"}, EVENT, EVENT, {"event": "notice", "text": "slow"}]
        )

    def test_quiet_is_silent(self):
        self.assertEqual(self.shown_as(messages.Voice.QUIET), "")


class Stages(unittest.TestCase):
    def stage(self, stream):
        """What a stage writes that is counted twice, a quarter of a minute apart."""
        times = itertools.count(0, messages.UPDATE_EVERY_S)
        with contextlib.redirect_stderr(stream), mock.patch.dict("os.environ", TERM="xterm"):
            with mock.patch("time.monotonic", lambda: next(times)), messages.Stage("building") as stage:
                stage.count(1, 9)
                stage.count(8, 0)

    def test_a_stage_is_one_line_that_grows(self):
        stream = io.StringIO()
        self.stage(stream)
        self.assertEqual(stream.getvalue(), "copepod: building … 1/9 … 30 s … 45 s\n")

    def test_a_stage_is_redrawn_in_place_until_it_is_over(self):
        terminal = Terminal()
        self.stage(terminal)
        lines = [f"\rcopepod: building … {text}\033[K" for text in ("", "1/9 ", "30 s ", "45 s")]
        self.assertEqual(terminal.text(), "".join(lines) + "\n")

    def test_programs_get_a_notice_for_each_news_of_a_stage(self):
        self.addCleanup(messages.speak, messages.Voice.LINES)
        messages.speak(messages.Voice.JSON)
        stream = io.StringIO()
        self.stage(stream)
        texts = [json.loads(line)["text"] for line in stream.getvalue().splitlines()]
        self.assertEqual(texts, ["building …", "building … 1/9", "building … 30 s", "building … 45 s"])


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
