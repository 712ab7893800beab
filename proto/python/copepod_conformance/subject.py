"""The component under test: its command, what it says it can do, and the case that it is tried with."""

import json

from copepod_run.errors import ExitCode, Stop
from copepod_conformance.body_case import BodyCase
from copepod_conformance.component_process import run_to_end
from copepod_conformance.fluid_case import FluidCase
from copepod_conformance.reference import Reference

_CASES = {"fluid": FluidCase, "body": BodyCase}


class Subject:
    def __init__(self, role, command, environment, folder, context, patience_s, solver=None):
        """Everything that is written goes below `folder`. Raises Stop if `command` does not tell its capabilities."""
        self.role, self.command, self.folder = role, command, folder
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
            code, answer, words = run_to_end(asked, self.environment, self.patience_s)
            if code != 0:
                how = "it did not end" if code is None else f"its exit code is {code}"
                raise ValueError(f"{how}; its last words: {words[:300]}" if words else how)
            capabilities = json.loads(answer)
            if not isinstance(capabilities, dict):
                raise ValueError("it is no object")
        except (OSError, ValueError) as error:
            raise Stop(
                ExitCode.BAD_CASE,
                f"{' '.join(asked)} does not print what the component can do as JSON ({error}). "
                "See docs/adding_a_component.md.",
            ) from error
        if capabilities.get("role") in _CASES and capabilities["role"] != self.role:
            raise Stop(
                ExitCode.BAD_CASE,
                f"{' '.join(self.command)} is a {capabilities['role']} component. "
                f"Use --role {capabilities['role']}.",
            )
        return capabilities
