"""Waits for the three processes of a run and the coupler's events until it is clear how the run ended."""

import os
import selectors
import signal
import time
from dataclasses import dataclass

from copepod_run import exit_codes
from copepod_run.events import EventReader
from copepod_run.family import LOOK_EVERY_S, FamilyWatch
from copepod_run.outcome import Failure, describe_exit, failure_of_event, judge, told_by_mpirun

# How long to wait for a second opinion once something went wrong; together with the three seconds that stopping
# may take, everything is over within five.
_AFTER_KILL_S = 0.3  # the coupler may know the step
_AFTER_EXIT_S = 1.5  # the coupler has, or is about to get, the component's own Failure
_AFTER_REPORT_S = 0.2  # a complete report: nothing more will come
_AFTER_LOSS_S = 1.5  # the coupler lost the fluid: mpirun may still tell which rank died, and how
_FOR_MPIRUN_S = 1.0  # longer, if a rank has ended and mpirun has no time to tell: others use the processors
_AFTER_FINISH_S = 10.0  # services say goodbye
_AFTER_TELLING_S = 0.7  # mpirun has told how a rank ended, and now ends itself


@dataclass(frozen=True)
class Ending:
    """Exactly one of the three is set."""

    summary: str = ""
    failure: Failure = None
    signal: int = 0


class Watch:
    """One attempt of a run, from the start of its processes to its ending."""

    def __init__(self, processes, events, signals, display, ranks):
        """`processes`: started Process objects; `events`: descriptor of the coupler's stdout."""
        self._host = os.uname().nodename
        self._signals = signals
        self._display = display
        self._ranks = ranks
        self._family = FamilyWatch(processes)
        self._next_look = time.monotonic() + LOOK_EVERY_S
        self._mpirun_told_at = None
        self._waited_for_mpirun = False
        self._reader = EventReader()
        self._alive = {process.name: process for process in processes}
        self._exits = []
        self._reported = None
        self._summary = ""
        self._deadline = None
        self._output_open = True
        self.phase = ""
        self.last_step = -1
        self._selector = selectors.DefaultSelector()
        self._selector.register(events, selectors.EVENT_READ, self._read_events)
        self._selector.register(signals.descriptor, selectors.EVENT_READ, lambda _: self._read_signals())
        for process in processes:
            self._selector.register(
                process.descriptor, selectors.EVENT_READ, lambda _, process=process: self._note_exit(process)
            )

    def wait(self):
        """Ending of the run; processes may still be alive then."""
        while True:
            ending = self._ending()
            if ending is not None:
                return ending
            self._look_at_processes()
            self._turn(self._time_left())

    def wait_for_coupler(self, patience_s, checkpoint_patience_s):
        """After a signal: until the coupler has closed its files, longer if it writes a checkpoint."""
        start = time.monotonic()
        signals_so_far = len(self._signals.received)
        while "coupler" in self._alive and len(self._signals.received) == signals_so_far:
            patience = checkpoint_patience_s if self.phase == "checkpointing" else patience_s
            left = start + patience - time.monotonic()
            if left <= 0:
                return
            self._turn(min(left, 0.1))

    def close(self):
        self._selector.close()

    def _turn(self, timeout_s):
        for key, _ in self._selector.select(timeout_s):
            key.data(key.fileobj)

    def _time_left(self):
        """Until the next look, or the decision if that comes first."""
        next_turn = self._next_look if self._deadline is None else min(self._next_look, self._deadline)
        return max(0.0, next_turn - time.monotonic())

    def _look_at_processes(self):
        if time.monotonic() < self._next_look:
            return
        trouble = self._family.look()
        self._end_mpirun_that_is_stuck()
        self._next_look = time.monotonic() + LOOK_EVERY_S
        if trouble is None or self._signals.received:
            return
        step = self.last_step if self._reported is None else self._reported.step
        self._reported = Failure(
            exit_codes.COMPONENT_LOST, trouble.component, self._host, trouble.rank, step, trouble.reason
        )
        self._decide_within(0.0)

    def _end_mpirun_that_is_stuck(self):
        """mpirun whose rank was killed while MPI started tells so, and may then lock up in PMIx_server_finalize."""
        if self._told_by_living_mpirun() is None:
            return
        now = time.monotonic()
        self._mpirun_told_at = self._mpirun_told_at or now
        if now - self._mpirun_told_at >= _AFTER_TELLING_S:
            self._alive["fluid"].send(signal.SIGKILL)  # its exit is noted as it told it

    def _told_by_living_mpirun(self):
        """Exit of the rank whose end mpirun tells while it has not ended itself, or None."""
        fluid = self._alive.get("fluid")
        return None if fluid is None else told_by_mpirun(fluid.tail(), self._host)

    def _decide_within(self, seconds):
        deadline = time.monotonic() + seconds
        self._deadline = deadline if self._deadline is None else min(self._deadline, deadline)

    def _ending(self):
        if self._signals.received:
            return Ending(signal=self._signals.received[0])
        if self._summary and not self._alive and all(exit.code == 0 and not exit.signal for exit in self._exits):
            return Ending(summary=self._summary)
        if self._deadline is None or time.monotonic() < self._deadline:
            return None
        if self._mpirun_may_still_tell():
            self._waited_for_mpirun = True
            self._deadline += _FOR_MPIRUN_S
            return None
        return Ending(failure=self._failure())

    def _mpirun_may_still_tell(self):
        return (
            not self._waited_for_mpirun
            and self._reported is not None
            and self._is_loss_without_cause()
            and self._family.has_ended_rank()
            and self._told_by_living_mpirun() is None
        )

    def _read_signals(self):
        self._signals.drain()
        if self._signals.checkpoint_wanted and self.phase and "coupler" in self._alive:  # it expects the signal
            self._alive["coupler"].send(signal.SIGUSR1)
        self._signals.checkpoint_wanted = False

    def _read_events(self, descriptor):
        received = os.read(descriptor, 65536)
        if not received:
            self._selector.unregister(descriptor)
            self._output_open = False
            if "coupler" not in self._alive:
                self._decide_within(_AFTER_REPORT_S if not self._summary else _AFTER_FINISH_S)
        for event in self._reader.feed(received):
            self._take(event)

    def _take(self, event):
        kind = event["event"]
        if kind == "phase":
            self.phase = event["phase"]
            self._next_look = 0.0  # all ranks exist once the run starts: record them before one can end
            self._look_at_processes()
            self._display.phase(self.phase)
        elif kind == "progress":
            self.last_step = event["step"]
            self._display.step(event)
        elif kind == "notice":
            self._display.notice(event["text"])
        elif kind == "failure":
            self._reported = failure_of_event(event, self._host)
            self._decide_within(_AFTER_LOSS_S if self._is_loss_without_cause() else _AFTER_REPORT_S)
        elif kind == "finished":
            self._summary = event["summary"]

    def _is_loss_without_cause(self):
        """Whether the coupler only knows that the fluid went silent, while mpirun's exit may tell more."""
        return (
            self._reported.code == exit_codes.COMPONENT_LOST
            and self._reported.component == "fluid"
            and self._reported.component not in [exit.component for exit in self._exits]
            and not any(exit.signal for exit in self._exits)
        )

    def _note_exit(self, process):
        returncode = process.returncode
        if returncode is None:
            return
        self._selector.unregister(process.descriptor)
        del self._alive[process.name]
        exit = describe_exit(process.name, returncode, process.tail(), self._host, self._ranks, process.log_tail())
        self._exits.append(exit)
        if self._summary and not exit.signal and not exit.code:
            self._decide_within(_AFTER_FINISH_S)
        elif exit.signal:
            self._decide_within(_AFTER_KILL_S)
        elif self._reported is not None:  # the report has set the deadline; its component's end needs no more
            if process.name == self._reported.component:
                self._decide_within(_AFTER_REPORT_S)
        elif exit.code or process.name == "coupler" or self.phase != "finishing":
            self._decide_within(_AFTER_EXIT_S if self._output_open else _AFTER_REPORT_S)

    def _failure(self):
        if self._summary:
            return self._failure_after_finish()
        told = self._told_by_living_mpirun()
        exits = self._exits if told is None else [*self._exits, told]
        return judge(self._reported, exits, self.last_step, self._host)

    def _failure_after_finish(self):
        bad = next((exit for exit in self._exits if exit.code or exit.signal), None)
        if self._reported is not None:  # frozen on its way out
            return self._reported
        if bad is not None:
            return judge(None, [bad], self.last_step, self._host)
        return Failure(
            exit_codes.COMPONENT_LOST,
            next(iter(self._alive)),
            self._host,
            "0",
            self.last_step,
            f"it did not end within {_AFTER_FINISH_S:.0f} s after the run had finished.",
        )
