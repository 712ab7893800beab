"""Several cases at once: starts the next when one ends, until all are done or a signal comes."""

import os
import re
import selectors
import shutil
import signal
import sys
import tempfile
import time
from argparse import Namespace
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from copepod_campaign.cases import Entry, State
from copepod_run import cleanup, components
from copepod_run.checkout import build_digest, present_programs, program
from copepod_run.launcher import RunProcess
from copepod_run.plan import case_arguments
from copepod_run.messages import complain, draw, draws, elapsed_text, report, say, speaks_json
from copepod_run.progress import Event, clock_text
from copepod_run.watch import SignalRecorder
from copepod_run.run_directory import make_folder

RESTARTS = 3  # by itself, when a component is lost
FAILURES = 3  # of one kind, after which no other case is started
_REDRAW_S = 1.0
_LINE_EVERY_S = 60.0
_NUMBER = re.compile(r"-?\d[\d.]*(?:e[-+]?\d+)?")


def keep_copy(campaign_folder: Path) -> Path:
    """Copies the present programs, so that a build in the middle of a campaign changes nothing.

    Copies of other builds are removed, because this one continues their runs. The folder has the name of the build.
    """
    source = program("coupler").parent
    shelf = campaign_folder / "programs"
    target = shelf / build_digest()
    if not target.exists():
        make_folder(shelf)
        cleanup.remove_folders(shelf.iterdir())
        fresh = Path(tempfile.mkdtemp(prefix="new-", dir=shelf))
        cleanup.claim(fresh, target.name)
        for name in present_programs():
            shutil.copy2(source / name, fresh / name)
        fresh.rename(target)
    return target.absolute()


class Job(RunProcess):
    """A running case and its latest progress."""

    def __init__(self, entry: Entry, ranks: int, environment: Mapping[str, str]) -> None:
        self.entry = entry
        is_lattice = entry.plan.case.get("fluid", {}).get("solver") == "lattice_boltzmann"
        case = Namespace(case=entry.member.file, set=entry.member.settings, ranks=ranks if is_lattice else None)
        command = [sys.executable, "-P", "-m", "copepod_command", "run", *case_arguments(case)]
        command += ["--out", str(entry.path), "--restarts", str(RESTARTS)]
        command += ["--resume"] if entry.state is State.HALF_DONE else []
        entry.state = State.RUNNING
        self._log = open(entry.path.parent / "logs" / f"{entry.name}.log", "ab")
        super().__init__(command, environment, self._log)
        self._last_line = ""
        self.share = 0.0
        self.remaining_s: float | None = None
        self.weight_per_s: float | None = None

    def read(self) -> None:
        """Takes what the run has written; at its end the entry has its result."""
        super().read()
        if self.exit_code is None:
            return
        self._log.close()
        if self.exit_code == 0 and self.entry.summary:
            self.entry.state = State.DONE
            return
        self.entry.state = State.FAILED
        self.entry.exit_code = self.exit_code
        self.entry.remark = self._last_line or f"ended with code {self.exit_code} without reporting an error"

    def _note(self, line: str) -> None:
        """A line for people; the last one gives the reason if a run fails."""
        self._last_line = line.removeprefix("copepod: ") or self._last_line
        self._log.write(f"{line}\n".encode())
        self._log.flush()

    def _take(self, event: Event) -> None:
        if event["event"] != "progress":
            return
        self.share = event["step"] / max(event["steps"], 1)
        if event["steps_per_s"]:
            self.remaining_s = event["remaining_s"]
            self.weight_per_s = event["steps_per_s"] * self.entry.weight / max(event["steps"], 1)


def remaining_s(running: Sequence[Job], waiting_weights: Iterable[float], jobs: int) -> float | None:
    """Time until the last case ends if every waiting one takes the first place that becomes free, in their order.

    @param running          jobs with remaining_s and weight_per_s, None as long as their speed is unknown
    @param waiting_weights  costs of the cases that have not begun
    @return seconds, or None if no speed is known
    """
    if not (speeds := [job.weight_per_s for job in running if job.weight_per_s]):
        return None
    weight_per_s = sum(speeds) / len(speeds)
    places = [
        job.remaining_s or 0.0 if job.weight_per_s else job.entry.weight * (1.0 - job.share) / weight_per_s
        for job in running
    ]
    places += [0.0] * (jobs - len(places))
    return last_end(places, (weight / weight_per_s for weight in waiting_weights))


def last_end(places: list[float], durations: Iterable[float]) -> float:
    """When all are done if each takes, in their order, the first of the `places`, which are free at these times."""
    for duration in durations:
        places[places.index(min(places))] += duration
    return max(places)


class Pool:
    """Runs the entries of a campaign that are not done, `jobs` at a time."""

    def __init__(
        self, name: str, entries: Sequence[Entry], jobs: int, programs: Path, signals: SignalRecorder, keeps_going: bool
    ) -> None:
        """`name`: of the campaign; `programs`: their folder; `keeps_going`: also when the first cases fail alike."""
        self._name = name
        self.entries = entries
        self._keeps_going = keeps_going
        self._waiting = [entry for entry in entries if entry.state is not State.DONE]
        self._jobs = max(1, min(jobs, len(self._waiting)))
        self._ranks = max(1, len(os.sched_getaffinity(0)) // self._jobs)
        # Several mpirun at once would each bind their first rank to the same core.
        self._environment = {**components.ON_SHARED_CORES, **os.environ, "COPEPOD_BIN_DIR": str(programs)}
        self._signals = signals
        self._signals_seen = 0
        self._next_line = time.monotonic() + _LINE_EVERY_S
        self.running: list[Job] = []

    def run(self) -> Iterator[Entry]:
        """Yields every entry when it has ended."""
        with selectors.DefaultSelector() as selector:
            selector.register(self._signals.descriptor, selectors.EVENT_READ, None)
            while True:
                while self._waiting and len(self.running) < self._jobs and not self._signals.received:
                    entry = self._waiting.pop(0)
                    how = "continues from its checkpoint" if entry.state is State.HALF_DONE else "starts"
                    say(f"{entry.name}: {how}")
                    job = Job(entry, self._ranks, self._environment)
                    selector.register(job.descriptor, selectors.EVENT_READ, job)
                    self.running.append(job)
                if not self.running:
                    break
                for key, _ in selector.select(_REDRAW_S):
                    if key.data is None:
                        self._heed_signals()
                        continue
                    key.data.read()
                    if key.data.exit_code is not None:
                        selector.unregister(key.fileobj)
                        self.running.remove(key.data)
                        self._settle(key.data.entry)
                        yield key.data.entry
                self._show()
        if speaks_json():
            self._show()
        elif draws():
            draw("")

    def _progress(self) -> tuple[float, float | None]:
        """Part of the whole campaign that is done, by cost; time left, None as long as no speed is known."""
        total = sum(entry.weight for entry in self.entries)
        done = sum(entry.weight for entry in self.entries if entry.state in (State.DONE, State.FAILED))
        share = (done + sum(job.entry.weight * job.share for job in self.running)) / max(total, 1)
        return share, remaining_s(self.running, [entry.weight for entry in self._waiting], self._jobs)

    def line(self) -> str:
        """«paper: 23 %, 3 of 17 done, 2:31:00 left; design_d 45 %, design_e 12 %»"""
        share, left_s = self._progress()
        words = [f"{self._name}: {100 * share:.0f} %", f"{self._done()} of {len(self.entries)} done"]
        if left_s is not None:
            words.append(f"{clock_text(left_s)} left")
        running = ", ".join(f"{job.entry.name} {100 * job.share:.0f} %" for job in self.running)
        return ", ".join(words) + (f"; {running}" if running else "")

    def _done(self) -> int:
        return sum(entry.state is State.DONE for entry in self.entries)

    def _show(self) -> None:
        """A line that is redrawn on a terminal, one a minute elsewhere; of events, step and steps count cases."""
        if speaks_json():
            share, left_s = self._progress()
            report("progress", step=self._done(), steps=len(self.entries), share=share, remaining_s=left_s)
        elif draws():
            draw(f"copepod: {self.line()}")
        elif time.monotonic() >= self._next_line:
            self._next_line = time.monotonic() + _LINE_EVERY_S
            say(self.line())

    def _settle(self, entry: Entry) -> None:
        if entry.state is State.FAILED and self._signals.received:
            entry.state, entry.remark = State.HALF_DONE, ""
        if entry.state is State.FAILED:
            complain(f"{entry.name}: failed. {entry.remark}")
        else:
            wall_s = (entry.summary or {}).get("wall_s")
            time_text = f" after {elapsed_text(wall_s)} of computing" if wall_s else ""
            say(f"{entry.name}: {f'done{time_text}' if entry.state is State.DONE else 'stopped'}")
        if not self._keeps_going and self._waiting and self._failed_alike():
            self._waiting.clear()
            say(f"the first {FAILURES} fail alike: the others are not started (with --keep-going they are)")

    def _failed_alike(self) -> bool:
        """Whether nothing is done and some have failed for one reason, but for names and numbers."""
        ended = [entry for entry in self.entries if entry.state in (State.DONE, State.FAILED)]
        reasons = {_NUMBER.sub("#", entry.remark.replace(entry.name, "")) for entry in ended}
        return len(ended) >= FAILURES and len(reasons) == 1 and all(entry.state is State.FAILED for entry in ended)

    def _heed_signals(self) -> None:
        """The first signal lets all runs write a checkpoint, the second one ends them at once."""
        self._signals.drain()
        for number in self._signals.received[self._signals_seen :]:
            first = self._signals_seen == 0
            self._signals_seen += 1
            if first:
                say(f"{signal.Signals(number).name}: waits for the checkpoints of what runs (again: at once)")
            for job in self.running:
                job.send(signal.SIGTERM if first else signal.SIGKILL)
