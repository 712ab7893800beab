"""Looks at the processes of a run: finds those that a signal has stopped, and ranks that ended unnoticed by mpirun."""

import time
from dataclasses import dataclass
from pathlib import Path

from copepod_run import cleanup
from copepod_run.components import COMPONENT

LOOK_EVERY_S = 0.5
STOPPED_FOR_S = 1.4  # no accident any more; with looks and cleaning up it stays below three seconds
ENDED_FOR_S = 2.0  # mpirun had its time to tell how a rank ended
_ENDED = (None, "Z", "X")
_AWAY_S = 1.5  # this command was stopped itself (Ctrl-Z, a suspended machine): everybody starts anew


@dataclass(frozen=True)
class Trouble:
    """Which process cannot go on, and why."""

    component: str
    rank: str
    reason: str


class FamilyWatch:
    """All processes of a run, looked at now and then; that costs some system calls per process."""

    def __init__(self, processes, clock=time.monotonic):
        self._processes = processes
        self._clock = clock
        self._last_look = clock()
        self._ranks = {}  # process id: rank
        self._since = {}  # (process id, what is wrong with it): when that was seen first

    def look(self):
        """What has been wrong for too long, or None."""
        now = self._clock()
        was_away = now - self._last_look > _AWAY_S
        self._last_look = now
        known = {} if was_away else self._since
        self._since = {wrong: known.get(wrong, now) for wrong in self._wrong()}
        for (pid, what), since in self._since.items():
            if what == "stopped" and now - since >= STOPPED_FOR_S:
                return self._stopped(pid)
            if what == "ended" and now - since >= ENDED_FOR_S:
                return Trouble("fluid", self._ranks[pid], "it has ended, and mpirun did not notice.")
        return None

    def has_ended_rank(self):
        """Whether the last look found a rank that ended while mpirun did not."""
        return any(what == "ended" for _, what in self._since)

    def _wrong(self):
        """(process id, stopped or ended) of every process that is not as it should be."""
        states = {pid: cleanup.process_state(pid) for process in self._processes for pid in _family(process.pid)}
        for pid in states:
            rank = None if pid in self._ranks else cleanup.environment_of(pid).get("OMPI_COMM_WORLD_RANK")
            if rank is not None:
                self._ranks[pid] = rank
        wrong = [(pid, "stopped") for pid, state in states.items() if state == "T"]
        fluid = next((process.pid for process in self._processes if process.name == "fluid"), None)
        if states.get(fluid) not in _ENDED:
            wrong += [(pid, "ended") for pid in self._ranks if states.get(pid) in _ENDED]
        return wrong

    @staticmethod
    def _stopped(pid):
        variables = cleanup.environment_of(pid)
        reason = f"frozen: its process {pid} ({_program(pid)}) is stopped (SIGSTOP, a terminal, or a debugger)."
        return Trouble(variables.get(COMPONENT, ""), variables.get("OMPI_COMM_WORLD_RANK", "0"), reason)


def _program(pid):
    try:
        return Path("/proc", str(pid), "comm").read_text().strip()
    except OSError:
        return "gone"


def _family(pid):
    """A process and all its descendants."""
    family = [pid]
    for member in family:
        for children in Path("/proc", str(member), "task").glob("*/children"):
            try:
                family += map(int, children.read_text().split())
            except OSError:  # gone meanwhile
                pass
    return family
