"""The component under test: its command, what it announces, and the case that it is tested with."""

import json

from copepod_component.errors import CaseError
from copepod_conformance.cases import BodyCase, FluidCase
from copepod_conformance.component_process import Component, run_to_end
from copepod_conformance.reference import Reference

_CASES = {"fluid": FluidCase, "body": BodyCase}


class Subject(Component):
    def __init__(self, role, command, environment, folder, context, patience_s, solver=None):
        """Raises CaseError if `command` does not print its capabilities."""
        super().__init__(command, environment, folder, context, patience_s)
        self.role = role
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
                raise ValueError("the JSON is not an object")
        except (OSError, ValueError) as error:
            raise CaseError(
                f"{' '.join(asked)} does not print what the component can do as JSON ({error}). "
                "See docs/adding_a_component.md."
            ) from error
        if capabilities.get("role") in _CASES and capabilities["role"] != self.role:
            raise CaseError(
                f"{' '.join(self.command)} is a {capabilities['role']} component. Use --role {capabilities['role']}."
            )
        return capabilities
