"""What a check is, and how it can end."""

import dataclasses
import functools
from typing import Callable


class Violation(Exception):
    """The component broke the rule; the text describes its reaction."""


class Silence(Violation):
    """Nothing came within the patience that every wait has."""


class NotApplicable(Exception):
    """The rule does not apply to this component; the text gives the reason."""


@dataclasses.dataclass(frozen=True)
class Rule:
    """What docs/protocol.md demands, and under which heading."""

    section: str
    text: str


implied = functools.partial(Rule, "What a role implies")  # rules of physics


@dataclasses.dataclass(frozen=True)
class Check:
    group: str
    name: str
    rule: Rule
    run: Callable  # of the open Trial and the arguments; raises Violation or NotApplicable
    arguments: tuple = ()
    needs: tuple = ()  # features that the component must announce
    steps: int | None = None  # done before it begins; None: it sets the component up itself
    thorough: bool = False  # left out by --quick
    options: tuple = ()  # for the component's command line
    alone: bool = False  # needs the machine's memory or cores for itself


@dataclasses.dataclass
class Result:
    check: Check
    outcome: str  # passed, failed, skipped
    seconds: float
    came: str = ""  # or why it was skipped
    sent: str = ""
