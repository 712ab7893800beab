"""Where the processes of a run live: the interface that starts, watches, signals and cleans up, whatever the host."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

LOOK_EVERY_S = 0.5  # how often look() is called


@dataclass(frozen=True)
class Trouble:
    """A process that cannot continue, and why."""

    component: str
    host: str
    rank: str
    reason: str


class Process(ABC):
    """A component's process, or the starter of its ranks (mpirun)."""

    name: str  # of the component: coupler, fluid, body
    host: str
    descriptor: int  # becomes readable when the process ends
    log: Path  # what the component reports itself
    output: Path  # what it writes to stdout and stderr

    @property
    @abstractmethod
    def returncode(self) -> int | None:
        """As in subprocess: None while it lives, minus the signal's number if a signal ended it."""

    @abstractmethod
    def send(self, number: int) -> None:
        """Signal to the process and all its descendants; does nothing if it has ended."""

    @abstractmethod
    def tail(self) -> str:
        """The end of its output in this attempt."""

    @abstractmethod
    def log_tail(self) -> str:
        """The end of its log in this attempt."""


class Launcher(ABC):
    """Starts the processes of one attempt of a run and leaves nothing of them behind.

    Calls: start() for every component, then any others, then close(), also after an error. Processes end with the
    command, even if that is killed.
    """

    @abstractmethod
    def start(
        self, name: str, command: Sequence[str], environment: Mapping[str, str], logs: Path, events: int | None = None
    ) -> Process:
        """Starts `command`; both outputs go to NAME.out in `logs`, except that stdout may be the pipe end `events`.

        Raises OSError if it cannot be started.
        """

    @abstractmethod
    def look(self) -> Trouble | None:
        """What has been wrong for too long: a process stopped by a signal, or a rank that ended unnoticed by mpirun."""

    @abstractmethod
    def has_ended_rank(self) -> bool:
        """Whether the last look() found a rank that had ended while mpirun had not."""

    @abstractmethod
    def end_all(self) -> int:
        """Ends every process, with SIGTERM first; returns how many could not be ended."""

    @abstractmethod
    def close(self) -> None:
        """Ends what is left and removes every temporary file."""
