"""Waits for the three processes of a run, the coupler's events and signals until it is clear how the run ended."""

import math
import os
import selectors
import signal
import time
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

from copepod_run.errors import ExitCode
from copepod_run.launcher import LOOK_EVERY_S, Launcher, Process
from copepod_run.outcome import Exit, Failure, failure_of_event, judge, lost, reported_by_mpirun
from copepod_run.messages import say
from copepod_run.progress import Event, EventReader, Progress

# How long to wait for further evidence once something has failed; with the three seconds that stopping may take,
# everything is over within five.
_AFTER_KILL_S = 0.3  # of the coupler, which reports nothing any more
_AFTER_EXIT_S = 1.5  # the coupler is about to report the step, or the component's own Failure
_AFTER_REPORT_S = 0.2  # a complete report: nothing more will come
_AFTER_LOSS_S = 1.5  # the coupler lost the fluid: mpirun may still report which rank died, and how
_FOR_MPIRUN_S = 1.0  # longer, if a rank has ended and mpirun had no time to report it: others use the processors
AFTER_FINISH_S = 10.0  # services end by themselves
_AFTER_MPIRUN_REPORT_S = 0.7  # mpirun has reported how a rank ended, and now ends itself


class SignalRecorder:
    """Context in which SIGINT, SIGTERM and SIGHUP only leave a note; ignored signals (nohup) stay ignored.

    SIGUSR1 asks for a checkpoint and does not end anything; deploy/copepod ignores it outside.
    """

    def __init__(self) -> None:
        self.received: list[int] = []
        self.checkpoint_wanted = False

    def __enter__(self) -> "SignalRecorder":
        self.descriptor, self._writing_end = os.pipe()
        for end in (self.descriptor, self._writing_end):
            os.set_blocking(end, False)
        self._former_wakeup = signal.set_wakeup_fd(self._writing_end, warn_on_full_buffer=False)
        self._former = {}
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) is not signal.SIG_IGN:
                self._former[number] = signal.signal(number, lambda number, _: self.received.append(number))
        self._former[signal.SIGUSR1] = signal.signal(signal.SIGUSR1, self._want_checkpoint)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._former.items():
            signal.signal(number, handler)
        signal.set_wakeup_fd(self._former_wakeup)
        os.close(self.descriptor)
        os.close(self._writing_end)

    def drain(self) -> None:
        """Empties the descriptor."""
        with suppress(BlockingIOError):
            os.read(self.descriptor, 4096)

    def _want_checkpoint(self, *_: object) -> None:
        self.checkpoint_wanted = True


@dataclass(frozen=True)
class Ending:
    """Exactly one of the three is set."""

    summary: str = ""
    failure: Failure | None = None
    signal: int = 0


class Watch:
    """One attempt of a run, from the start of its processes to its ending."""

    def __init__(self, launcher: Launcher, events: int, signals: SignalRecorder, display: Progress, ranks: int) -> None:
        """`launcher`: has started all processes; `events`: descriptor of the coupler's stdout."""
        self._launcher = launcher
        self._host = launcher.processes["coupler"].host
        self._signals = signals
        self._display = display
        self._ranks = ranks
        self._next_look = time.monotonic() + LOOK_EVERY_S
        self._mpirun_reported_at: float | None = None
        self._waited_for_mpirun = False
        self._reader = EventReader()
        self._alive = dict(launcher.processes)
        self._exits: list[Exit] = []
        self._reported: Failure | None = None
        self._summary = ""
        self._deadline = math.inf
        self._output_open = True
        self.phase = ""
        self.last_step = -1
        self._selector = selectors.DefaultSelector()
        self._selector.register(events, selectors.EVENT_READ, partial(self._read_events, events))
        self._selector.register(signals.descriptor, selectors.EVENT_READ, self._pass_on_request)
        for process in launcher.processes.values():
            self._selector.register(process.descriptor, selectors.EVENT_READ, partial(self._note_exit, process))

    def wait(self) -> Ending:
        """Ending of the run; processes may still be alive then."""
        while (ending := self._ending()) is None:
            self._look_at_processes()
            self._turn(max(0.0, min(self._next_look, self._deadline) - time.monotonic()))
        return ending

    def wait_for_coupler(self, patience_s: float, checkpoint_patience_s: float) -> None:
        """After a signal: until the coupler has closed its files, longer if it writes a checkpoint."""
        start = time.monotonic()
        signals_so_far = len(self._signals.received)
        is_said = False
        while "coupler" in self._alive and len(self._signals.received) == signals_so_far:
            saves = self.phase == "checkpointing"
            if saves and not is_said:
                say("waits for the checkpoint that is being written (again: at once)")
            is_said = is_said or saves
            if (left := start + (checkpoint_patience_s if saves else patience_s) - time.monotonic()) <= 0:
                return
            self._turn(min(left, 0.1))

    def close(self) -> None:
        self._selector.close()

    def _turn(self, timeout_s: float) -> None:
        for key, _ in self._selector.select(timeout_s):
            key.data()

    def _look_at_processes(self) -> None:
        if time.monotonic() < self._next_look:
            return
        trouble = self._launcher.look()
        if self._reported_by_living_mpirun() is not None:
            # An mpirun whose rank was killed while MPI started reports that, and may then hang in PMIx_server_finalize.
            self._mpirun_reported_at = self._mpirun_reported_at or time.monotonic()
            if time.monotonic() - self._mpirun_reported_at >= _AFTER_MPIRUN_REPORT_S:
                self._alive["fluid"].send(signal.SIGKILL)  # its exit is taken from its report
        self._next_look = time.monotonic() + LOOK_EVERY_S
        if trouble is None or self._signals.received:
            return
        self._reported = replace(trouble, step=self._reported.step) if self._reported else trouble
        self._decide_within(0.0)

    def _reported_by_living_mpirun(self) -> Exit | None:
        """Exit of the rank whose end mpirun has reported while it has not ended itself."""
        fluid = self._alive.get("fluid")
        return None if fluid is None else reported_by_mpirun(fluid.tail(fluid.output), fluid.host)

    def _decide_within(self, seconds: float) -> None:
        self._deadline = min(self._deadline, time.monotonic() + seconds)

    def _ending(self) -> Ending | None:
        if self._signals.received:
            return Ending(signal=self._signals.received[0])
        if self._summary and not self._alive and all(exit.code == 0 and not exit.signal for exit in self._exits):
            return Ending(summary=self._summary)
        if time.monotonic() < self._deadline:
            return None
        may_still_report = not self._waited_for_mpirun and self._is_loss_without_cause()
        if may_still_report and self._launcher.has_ended_rank() and self._reported_by_living_mpirun() is None:
            self._waited_for_mpirun = True
            self._deadline += _FOR_MPIRUN_S
            return None
        return Ending(failure=self._failure())

    def _pass_on_request(self) -> None:
        """For a checkpoint, once the coupler expects the signal."""
        self._signals.drain()
        if self._signals.checkpoint_wanted and self.phase and "coupler" in self._alive:
            self._signals.checkpoint_wanted = False
            self._alive["coupler"].send(signal.SIGUSR1)

    def _read_events(self, descriptor: int) -> None:
        received = os.read(descriptor, 65536)
        if not received:
            self._selector.unregister(descriptor)
            self._output_open = False
            if "coupler" not in self._alive:
                self._decide_within(_AFTER_REPORT_S if not self._summary else AFTER_FINISH_S)
        for event in self._reader.feed(received):
            self._take(event)

    def _take(self, event: Event) -> None:
        kind = event["event"]
        if kind == "phase":
            self.phase = event["phase"]
            self._pass_on_request()
            self._next_look = 0.0  # all ranks exist once the run starts: record them before one can end
            self._look_at_processes()
            self._display.phase(self.phase)
        elif kind == "progress":
            self.last_step = event["step"]
            self._display.step(event)
        elif kind == "notice":
            say(event["text"])
        elif kind == "failure":
            self._reported = failure_of_event(event, self._host)
            self._decide_within(_AFTER_LOSS_S if self._is_loss_without_cause() else _AFTER_REPORT_S)
        elif kind == "finished":
            self._summary = event["summary"]

    def _is_loss_without_cause(self) -> bool:
        """Whether the coupler has only noticed that the fluid went silent, while mpirun's exit may give the cause."""
        reported = self._reported
        is_loss = reported is not None and reported.code == ExitCode.COMPONENT_LOST and reported.component == "fluid"
        return is_loss and not any(exit.signal or exit.component == "fluid" for exit in self._exits)

    def _note_exit(self, process: Process) -> None:
        if process.returncode is None:
            return
        self._selector.unregister(process.descriptor)
        del self._alive[process.name]
        exit = process.exit(self._ranks)
        self._exits.append(exit)
        if self._summary and not exit.signal and not exit.code:
            self._decide_within(AFTER_FINISH_S)
        elif exit.signal and process.name == "coupler":
            self._decide_within(_AFTER_KILL_S)
        elif self._reported is not None:  # the report has set the deadline; its component's end needs no more
            if process.name == self._reported.component:
                self._decide_within(_AFTER_REPORT_S)
        elif exit.signal or exit.code or process.name == "coupler" or self.phase != "finishing":
            self._decide_within(_AFTER_EXIT_S if self._output_open else _AFTER_REPORT_S)

    def _failure(self) -> Failure:
        if not self._summary:
            last = self._reported_by_living_mpirun()
            exits = self._exits if last is None else [*self._exits, last]
            return judge(self._reported, exits, self.last_step, self._host)
        bad = [exit for exit in self._exits if exit.code or exit.signal][:1]
        if bad or self._reported is not None:  # such as one that froze while it ended
            return judge(self._reported, bad, self.last_step, self._host)
        late = next(iter(self._alive.values()))
        reason = f"it did not end within {AFTER_FINISH_S:.0f} s after the run had finished."
        return lost(late.name, late.host, "0", reason, self.last_step, is_after_step=True)
