"""How a run is watched, with processes of a launcher that starts none: the test decides when they end."""

import json
import os
import select
import signal
import time
import unittest
from pathlib import Path
from unittest import mock

import copepod_session  # noqa: F401  (makes the command's modules importable)
from copepod_run.hosts_launcher import HostsLauncher
from copepod_run.launcher import Launcher, Process
from copepod_run.outcome import Exit, lost
from copepod_run.processes import Wrong
from copepod_run.watch import SignalRecorder, Watch


class FakeProcess(Process):
    """A process on some host; `end` makes its descriptor readable."""

    def __init__(self, name, host):
        self.name, self.host = name, host
        self.log, self.output = Path(f"logs/{name}.log"), Path(f"logs/{name}.out")
        self.descriptor, self._writing_end = os.pipe()
        self._returncode = None

    @property
    def returncode(self):
        return self._returncode

    def end(self, returncode):
        self._returncode = returncode
        os.write(self._writing_end, b".")

    def send(self, number):
        pass

    def tail(self, path):
        return ""

    def close(self):
        os.close(self.descriptor)
        os.close(self._writing_end)


class FakeLauncher(Launcher):
    """Processes on three hosts."""

    def __init__(self):
        self.processes = {}
        self.trouble = None

    def start(self, name, command, environment, logs, events=None):
        self.processes[name] = FakeProcess(name, command[0])

    def look(self):
        return self.trouble

    def has_ended_rank(self):
        return False

    def end_all(self):
        return 0

    def close(self):
        for process in self.processes.values():
            process.close()


class Display:
    """Shows nothing."""

    def phase(self, name):
        pass

    def step(self, event):
        pass


class WatchOfThreeHosts(unittest.TestCase):
    def setUp(self):
        self.launcher = FakeLauncher()
        self.addCleanup(self.launcher.close)
        hosts = {"coupler": "a", "fluid": "b", "body": "c"}
        for name, host in hosts.items():
            self.launcher.start(name, [host], {}, Path("logs"))
        events, self.coupler_stdout = os.pipe()
        self.addCleanup(os.close, events)
        self.addCleanup(os.close, self.coupler_stdout)
        self.signals = SignalRecorder()
        self.addCleanup(self.signals.__exit__)
        self.display = Display()
        self.watch = Watch(self.launcher, events, self.signals.__enter__(), self.display, ranks=1)
        self.addCleanup(self.watch.close)

    def emit(self, **event):
        os.write(self.coupler_stdout, json.dumps(event).encode() + b"\n")

    def finish(self):
        self.emit(event="finished", summary="summary.json")
        for process in self.launcher.processes.values():
            process.end(0)

    def test_a_finished_run_ends_with_its_summary(self):
        self.finish()
        self.assertEqual(self.watch.wait().summary, "summary.json")

    def test_a_killed_component_is_named_with_its_host_and_the_reported_step(self):
        self.emit(event="failure", code=69, component="body", host="a", rank=0, step=700, reason="is gone.")
        self.launcher.processes["body"].end(-signal.SIGSEGV)
        failure = self.watch.wait().failure
        self.assertEqual((failure.component, failure.host, failure.step), ("body", "c", 700))
        self.assertIn("SIGSEGV", failure.reason)

    def test_only_the_loss_of_a_fluid_that_has_not_ended_waits_for_its_cause(self):
        for component, exits, waits in (
            ("fluid", [], True),
            ("fluid", [Exit("body")], True),
            ("body", [], False),
            ("fluid", [Exit("fluid")], False),
            ("fluid", [Exit("body", signal=9)], False),
        ):
            self.watch._reported, self.watch._exits = lost(component, "b", "0", "is silent."), exits
            self.assertIs(self.watch._is_loss_without_cause(), waits, (component, exits))
        self.watch._reported = None
        self.assertFalse(self.watch._is_loss_without_cause())

    def test_trouble_that_the_launcher_sees_ends_the_run(self):
        self.launcher.trouble = lost("fluid", "b", "3", "frozen: its process 7 is stopped.")
        start = time.monotonic()
        failure = self.watch.wait().failure
        self.assertLess(time.monotonic() - start, 5.0)
        self.assertEqual((failure.code, failure.host, failure.rank), (69, "b", "3"))

    def test_trouble_after_a_report_happened_at_the_reported_step(self):
        self.emit(event="failure", code=69, component="fluid", host="b", rank=0, step=700, reason="is silent.")
        report = self.watch._take
        frozen = lost("fluid", "b", "3", "frozen.")
        self.watch._take = lambda event: (report(event), setattr(self.launcher, "trouble", frozen))
        failure = self.watch.wait().failure
        self.assertEqual((failure.rank, failure.step), ("3", 700))

    def test_a_component_that_freezes_after_the_last_step_is_lost_after_that_step(self):
        self.emit(event="progress", step=2000, steps=2000, steps_per_s=1.0, remaining_s=0.0)
        self.emit(event="finished", summary="summary.json")
        self.display.step = lambda event: setattr(self.launcher, "trouble", lost("body", "c", "0", "frozen."))
        sentence = self.watch.wait().failure.sentence()
        self.assertEqual(sentence, "body service on host c, rank 0, after step 2000: frozen.")

    def test_a_wish_for_a_checkpoint_reaches_the_coupler_once_it_runs(self):
        received = []
        self.launcher.processes["coupler"].send = lambda number: (received.append(number), self.finish())
        self.display.phase = lambda name: os.kill(os.getpid(), signal.SIGUSR1)
        self.emit(event="phase", phase="running")
        self.watch.wait()
        self.assertEqual(received, [signal.SIGUSR1])
        self.assertEqual(select.select([self.signals.descriptor], [], [], 0)[0], [])


class CommandThatWasAway(unittest.TestCase):
    def test_what_was_stopped_meanwhile_counts_from_then_on(self):
        launcher = Launcher.__new__(Launcher)
        launcher._since, launcher._attention = {}, mock.Mock()
        launcher._wrong = lambda: [Wrong("a", 7, "stopped", "body", "0", "body_service")]
        launcher._attention.was_away.side_effect = [False, True, False]
        with mock.patch("time.monotonic", side_effect=[0.0, 5.0, 7.0]):
            self.assertEqual([launcher.look() is None for _ in range(3)], [True, True, False])

    def test_hosts_have_been_silent_from_then_on(self):
        launcher = HostsLauncher.__new__(HostsLauncher)
        launcher._connections, launcher._attention = [mock.Mock(answered=0.0)], mock.Mock()
        launcher._since, launcher._wrong, launcher._lost = {}, lambda: [], lambda: iter(())
        for was_away, answered in ((False, 0.0), (True, 5.0)):
            launcher._attention.was_away.return_value = was_away
            with mock.patch("time.monotonic", return_value=5.0):
                self.assertIsNone(launcher.look())
            self.assertEqual(launcher._connections[0].answered, answered)


if __name__ == "__main__":
    unittest.main()
