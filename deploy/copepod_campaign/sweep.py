"""The cases of a campaign, sweeps taken apart: every one is read, checked and named before anything is started."""

import json
from argparse import Namespace
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from copepod_run import components
from copepod_run.errors import ExitCode, Stop
from copepod_run.names import distinct_folders, short_keys
from copepod_run.plan import Plan, plan_of

_AS_IN_THE_CASE = Namespace(ranks=None, fluid=None, body=None)


@dataclass(frozen=True)
class Member:
    """A case that is to be run: one of the campaign's list, or one member of its sweep."""

    name: str  # of its folder
    item: str  # name in the campaign's list
    file: str
    settings: tuple[str, ...]
    parameters: Mapping[str, Any]  # value of each swept key
    scales: Mapping[str, str]  # «linear» or «logarithmic», by swept key
    plan: Plan


class Problems:
    """What is wrong with several cases, by text: what they share appears once."""

    def __init__(self) -> None:
        self._names: dict[str, list[str]] = {}  # by text

    def add(self, name: str, text: str) -> None:
        for line in text.splitlines():
            self._names.setdefault(line, []).append(name)

    def __bool__(self) -> bool:
        return bool(self._names)

    def lines(self) -> list[str]:
        """«NAME: problem», «NAME and 3 others: problem»."""
        return [f"{names[0]}{_others(len(names) - 1)}: {text}" for text, names in self._names.items()]

    def names(self) -> set[str]:
        """Cases that have any."""
        return {name for names in self._names.values() for name in names}


def _others(count: int) -> str:
    return f" and {count} other{'s' if count > 1 else ''}" if count else ""


def members_of(items: Sequence[Mapping[str, Any]], trusted: bool = True) -> list[Member]:
    """The members of all `items` (name, file and settings, as the coupler lists them). Components that cases name are
    asked what they can do, which starts their commands, if the cases are `trusted`.

    Raises Stop(2) after naming the problems of all of them.
    """
    problems = Problems()
    members = [member for item in items for member in _members_of(item, trusted, problems)]
    for member in members:
        for problem in components.problems_of_components(member.plan, only_replaced=True):
            problems.add(member.name, problem)
    if problems:
        cases = problems.names() | {member.name for member in members}
        count = f"{len(problems.names())} of {len(cases)} cases cannot run."
        raise Stop(ExitCode.BAD_CASE, count, "".join(f"{line}\n" for line in problems.lines()))
    return _named(members)


def _members_of(item: Mapping[str, Any], trusted: bool, problems: Problems) -> list[Member]:
    whole = _plan_of(item["name"], item["file"], item["set"], trusted, problems)
    if whole is None:
        return []
    if not whole.sweep:
        return [Member(item["name"], item["name"], item["file"], tuple(item["set"]), {}, {}, whole)]
    keys = [parameter["key"] for parameter in whole.sweep["parameters"]]
    scales = {parameter["key"]: parameter["scale"] for parameter in whole.sweep["parameters"]}
    labels = short_keys(keys)
    members = []
    for swept in whole.sweep["members"]:
        parameters = dict(zip(keys, swept["values"]))
        name = "_".join([item["name"], *(f"{labels[key]}={value_text(parameters[key])}" for key in keys)])
        settings = (*item["set"], *swept["set"])
        plan = _plan_of(name, item["file"], settings, trusted, problems)
        if plan is not None:
            members.append(Member(name, item["name"], item["file"], settings, parameters, scales, plan))
    return members


def _plan_of(name: str, file: str, settings: Sequence[str], trusted: bool, problems: Problems) -> Plan | None:
    """The plan as it can be carried out, or None if there is none."""
    try:
        plan = plan_of(file, settings)
        if not trusted:
            plan = replace(plan, unasked=frozenset(filter(plan.command_of, components.ROLES)))
        return components.settled(plan, _AS_IN_THE_CASE)
    except Stop as refusal:
        if refusal.code != ExitCode.BAD_CASE:
            raise
        problems.add(name, refusal.refused())
        return None


def _named(members: Sequence[Member]) -> list[Member]:
    """With names of folders that stay apart."""
    swept = [member for member in members if member.parameters]
    identities = [json.dumps([member.item, member.parameters]) for member in swept]
    folders = distinct_folders(
        [member.name for member in swept], identities, [member.name for member in members if not member.parameters]
    )
    name_of = {id(member): folder for member, folder in zip(swept, folders)}
    return [replace(member, name=name_of.get(id(member), member.name)) for member in members]


def value_text(value: Any) -> str:
    """A swept value: «30», «1e-06», «vacuum», «[6e-06, 2e-05]»."""
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def swept_keys(members: Sequence[Member]) -> dict[str, str]:
    """Column heading of each key that a sweep of the campaign varies."""
    return short_keys(list(dict.fromkeys(key for member in members for key in member.parameters)))
