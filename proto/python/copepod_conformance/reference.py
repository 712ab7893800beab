"""What an undisturbed run replies, and a checkpoint of its middle: made once, compared with by many checks."""

import tempfile
import threading
from pathlib import Path

from copepod_conformance.trial import Trial
from copepod_conformance.verdicts import NotApplicable, Violation

STEPS = 6
SAVED_STEP = 3


class _Once:
    """A value that is made when it is first asked for, also when several ask at once."""

    def __init__(self, make):
        self._make, self._lock, self._values = make, threading.Lock(), []

    def __call__(self):
        with self._lock:
            if not self._values:
                self._values.append(self._make())
            return self._values[0]


class Reference:
    """replies(): content of the replies to STEPS steps; digest(): after them; checkpoint(): its path, with digest."""

    def __init__(self, subject):
        self._subject = subject
        self._folder = Path(tempfile.mkdtemp(dir=subject.folder))
        self._run = _Once(self._undisturbed)
        self.checkpoint = _Once(self._save)

    def replies(self):
        return self._run()[0]

    def digest(self):
        return self._run()[1]

    def compare(self, replies, first=0):
        """Raises Violation at the first reply that is not the one of the undisturbed run."""
        for number, reply in enumerate(replies, first):
            if reply != self.replies()[number]:
                raise Violation(f"a reply to step {number} that differs from the one of an undisturbed run")

    def compare_end(self, trial):
        """The rest of the run, and its digest."""
        first = trial.next_step
        self.compare(trial.advance(STEPS - first), first)
        if (digest := digest_of(trial)) != self.digest():
            raise Violation(
                f"digest {digest:016x} after step {STEPS - 1}, but {self.digest():016x} in an undisturbed run"
            )

    def _undisturbed(self):
        with Trial(self._subject) as trial:
            trial.configure()
            return trial.advance(STEPS), digest_of(trial)

    def _save(self):
        if not self._subject.can("checkpoint"):
            raise NotApplicable("it does not announce checkpoint")
        with Trial(self._subject) as trial:
            trial.configure()
            trial.advance(SAVED_STEP)
            digest = digest_of(trial)
            message = trial.make("Save")
            message.save.path = str(self._folder / "checkpoint")
            trial.request(message)
            return message.save.path, digest


def digest_of(trial):
    return trial.request("Summarise").envelope.summary.digest
