"""The component under test: what it announces, the case that it is tested with, and what an undisturbed run replies."""

import functools
import json
import tempfile
import threading
from pathlib import Path

from copepod_component.errors import CaseError
from copepod_conformance.cases import BodyCase, FluidCase
from copepod_conformance.component_process import Component
from copepod_conformance.trial import Trial
from copepod_conformance.verdicts import NotApplicable, Violation

STEPS = 6  # of the undisturbed run
SAVED_STEP = 3
_CASES = {"fluid": FluidCase, "body": BodyCase}


class Subject(Component):
    def __init__(self, role, command, environment, folder, context, patience_s, solver=None):
        """Raises CaseError if `command` does not print its capabilities."""
        super().__init__(command, environment, folder, context, patience_s)
        self.role = role
        self.capabilities = self._ask()
        self.features = set(self.capabilities.get("features", []))
        self.case = _CASES[role](self.features, solver)
        self.reference = _once(lambda: Reference(self))
        self.checkpoint = _once(self._save)

    @property
    def name(self):
        return self.capabilities.get("name", "") or " ".join(self.command)

    def can(self, feature):
        return feature in self.features

    def _save(self):
        """Path of a checkpoint of the middle of an undisturbed run, and the digest then."""
        if not self.can("checkpoint"):
            raise NotApplicable("it does not announce checkpoint")
        with Trial(self) as trial:
            trial.configure(SAVED_STEP)
            digest = digest_of(trial)
            message = trial.make("Save", Path(tempfile.mkdtemp(dir=self.folder)) / "checkpoint")
            trial.request(message)
            return message.save.path, digest

    def _ask(self):
        try:
            code, answer, words = self.run_to_end("--capabilities")
            if code != 0:
                how = "it did not end" if code is None else f"its exit code is {code}"
                raise ValueError(f"{how}; its last words: {words[:300]}" if words else how)
            capabilities = json.loads(answer)
            if not isinstance(capabilities, dict):
                raise ValueError("the JSON is not an object")
        except (OSError, ValueError) as error:
            raise CaseError(
                f"{' '.join(self.command)} --capabilities does not print what the component can do as JSON ({error}). "
                "See docs/adding_a_component.md."
            ) from error
        if capabilities.get("role") in _CASES and capabilities["role"] != self.role:
            raise CaseError(
                f"{' '.join(self.command)} is a {capabilities['role']} component. Use --role {capabilities['role']}."
            )
        return capabilities


def _once(make):
    """A function that returns what `make` returned when it was first called, also when several threads call at once."""
    lock, kept = threading.Lock(), functools.cache(make)

    def get():
        with lock:
            return kept()

    return get


class Reference:
    """What an undisturbed run replies: content of the `replies` to STEPS steps, and the `digest` after them."""

    def __init__(self, subject):
        with Trial(subject) as trial:
            trial.configure()
            self.replies, self.digest = trial.advance(STEPS), digest_of(trial)

    def compare(self, replies, first=0):
        """Raises Violation at the first reply that is not the one of the undisturbed run."""
        for number, reply in enumerate(replies, first):
            if reply != self.replies[number]:
                raise Violation(f"a reply to step {number} that differs from the one of an undisturbed run")

    def compare_end(self, trial):
        """The rest of the run, and its digest."""
        first = trial.next_step
        self.compare(trial.advance(STEPS - first), first)
        if (digest := digest_of(trial)) != self.digest:
            raise Violation(
                f"digest {digest:016x} after step {STEPS - 1}, but {self.digest:016x} in an undisturbed run"
            )


def digest_of(trial):
    return trial.request("Summarise").envelope.summary.digest
