"""Several cases at once: starts the next when one ends, until all are done or a signal comes."""

import os
import selectors
import signal

from copepod_campaign import forecast
from copepod_campaign.entry import State
from copepod_campaign.job import Job

_REDRAW_S = 1.0


class Pool:
    """Runs the entries of a campaign that are not done, `jobs` at a time."""

    def __init__(self, entries, jobs, programs, signals):
        self.entries = entries
        self._waiting = [entry for entry in entries if entry.state is not State.DONE]
        self._jobs = max(1, min(jobs, len(self._waiting)))
        self._ranks = max(1, len(os.sched_getaffinity(0)) // self._jobs)
        self._environment = programs.environment()
        self._signals = signals
        self._signals_seen = 0
        self.running = []

    @property
    def stopping(self):
        return bool(self._signals.received)

    def run(self, screen):
        """Yields every entry when it has ended."""
        with selectors.DefaultSelector() as selector:
            selector.register(self._signals.descriptor, selectors.EVENT_READ, None)
            while True:
                self._start_what_fits(selector, screen)
                if not self.running:
                    return
                for key, _ in selector.select(_REDRAW_S):
                    if key.data is None:
                        self._heed_signals(screen)
                        continue
                    key.data.read()
                    if key.data.ended:
                        selector.unregister(key.fileobj)
                        self.running.remove(key.data)
                        self._settle(key.data.entry, screen)
                        yield key.data.entry
                screen.draw()

    def share(self):
        """Part of the whole campaign that is done, by cost."""
        total = sum(entry.weight for entry in self.entries)
        done = sum(entry.weight for entry in self.entries if entry.state in (State.DONE, State.FAILED))
        return (done + sum(job.entry.weight * job.share for job in self.running)) / max(total, 1)

    def remaining_s(self):
        """Time left, or None as long as no run has told its speed."""
        return forecast.remaining_s(self.running, [entry.weight for entry in self._waiting], self._jobs)

    def _start_what_fits(self, selector, screen):
        while self._waiting and len(self.running) < self._jobs and not self.stopping:
            entry = self._waiting.pop(0)
            screen.notice(
                f"{entry.name}: {'goes on from its checkpoint' if entry.state is State.HALF_DONE else 'starts'}"
            )
            job = Job(entry, self._ranks, self._environment)
            selector.register(job.descriptor, selectors.EVENT_READ, job)
            self.running.append(job)

    def _settle(self, entry, screen):
        if entry.state is State.FAILED and self.stopping:
            entry.state, entry.remark = State.HALF_DONE, ""
        screen.ended(entry)

    def _heed_signals(self, screen):
        """The first signal lets all runs write a checkpoint, the second one ends them at once."""
        self._signals.drain()
        for number in self._signals.received[self._signals_seen :]:
            first = self._signals_seen == 0
            self._signals_seen += 1
            if first:
                screen.notice(f"{signal.Signals(number).name}: waits for the checkpoints of what runs (again: at once)")
            for job in self.running:
                job.stop() if first else job.kill()
