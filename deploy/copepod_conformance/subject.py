"""The component under test: its command, what it says it can do, and the case that it is tried with."""

import json
import subprocess

from copepod_command import exit_codes
from copepod_command.errors import Stop
from copepod_conformance.body_case import BodyCase
from copepod_conformance.fluid_case import FluidCase
from copepod_conformance.reference import Reference

_CASES = {"fluid": FluidCase, "body": BodyCase}
_ANSWER_S = 30.0


class Subject:
    def __init__(self, role, command, environment, context, patience_s, solver=None):
        """Raises Stop if `command` does not tell its capabilities."""
        self.role, self.command = role, command
        self.environment, self.context, self.patience_s = environment, context, patience_s
        self.capabilities = self._ask()
        self.features = set(self.capabilities.get("features", []))
        self.case = _CASES[role](self.features, solver)
        self.reference = Reference(self)

    @property
    def name(self):
        return self.capabilities.get("name", "") or " ".join(self.command)

    def can(self, feature):
        return feature in self.features

    def _ask(self):
        asked = [*self.command, "--capabilities"]
        try:
            answer = subprocess.run(asked, env=self.environment, stdin=subprocess.DEVNULL, capture_output=True,
                                    text=True, timeout=_ANSWER_S, check=False)
            return _only_object(answer.stdout)
        except (OSError, subprocess.TimeoutExpired, ValueError) as error:
            raise Stop(exit_codes.BAD_CASE,
                       f"{' '.join(asked)} does not print what the component can do as JSON ({error}). "
                       "See docs/adding_a_component.md.") from error


def _only_object(text):
    capabilities = json.loads(text)
    if not isinstance(capabilities, dict):
        raise ValueError("it is no object")
    return capabilities
