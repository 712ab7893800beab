"""The cases of a campaign, sweeps taken apart: every one is read, checked and named before anything is started. Its
folder shows how far it is."""

import enum
import itertools
import json
import os
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from copepod_run import components
from copepod_run.errors import BadCase, ExitCode, Stop
from copepod_run.messages import say
from copepod_run.names import distinct_folders, short_keys
from copepod_run.plan import Plan, plan_of
from copepod_run.run_directory import Lock, last_checkpoint_step, lock_of, read_object

_ENDING_PATIENCE_S = 180.0  # a run that was left behind writes its checkpoint


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


class Problems(dict[str, list[str]]):
    """What is wrong with several cases: their names by text, so that what they share appears once."""

    def add(self, name: str, *texts: str) -> None:
        for line in "\n".join(texts).splitlines():
            self.setdefault(line, []).append(name)

    def lines(self) -> list[str]:
        """«NAME: problem», «NAME and 3 others: problem»."""
        found = ((names[0], len(names) - 1, text) for text, names in self.items())
        others = {0: "", 1: " and 1 other"}
        return [f"{first}{others.get(more, f' and {more} others')}: {text}" for first, more, text in found]


def members_of(items: Sequence[Mapping[str, Any]], trusted: bool = True) -> list[Member]:
    """The members of all `items` (name, file and settings, as the coupler lists them). Components that cases name are
    asked what they can do, which starts their commands, if the cases are `trusted`.

    Raises Stop(2) after naming the problems of all of them.
    """
    problems = Problems()
    members = [member for item in items for member in _members_of(item, trusted, problems)]
    for member in members:
        problems.add(member.name, *components.problems_of_components(member.plan, member.plan.commands))
    if problems:
        bad = {name for names in problems.values() for name in names}
        cases = bad | {member.name for member in members}
        count = f"{len(bad)} of {len(cases)} cases cannot run."
        raise Stop(ExitCode.BAD_CASE, count, "".join(f"{line}\n" for line in problems.lines()))
    return _named(members)


def _members_of(item: Mapping[str, Any], trusted: bool, problems: Problems) -> list[Member]:
    if not (whole := _plan_of(item["name"], item["file"], item["set"], trusted, problems)):
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
        if plan := _plan_of(name, item["file"], settings, trusted, problems):
            members.append(Member(name, item["name"], item["file"], settings, parameters, scales, plan))
    return members


def _plan_of(name: str, file: str, settings: Sequence[str], trusted: bool, problems: Problems) -> Plan | None:
    """The plan as it can be carried out, or None if there is none."""
    try:
        plan = plan_of(file, settings)
        if not trusted:
            plan = replace(plan, unasked=frozenset(plan.commands))
        return components.settled(plan)
    except Stop as refusal:
        if refusal.code != ExitCode.BAD_CASE:
            raise
        problems.add(name, refusal.refused())
        return None


def _named(members: Sequence[Member]) -> list[Member]:
    """With names of folders that stay apart."""
    swept = [member for member in members if member.parameters]
    identities = [json.dumps([member.item, member.parameters]) for member in swept]
    single = [member.name for member in members if not member.parameters]
    folders = iter(distinct_folders([member.name for member in swept], identities, single))
    return [replace(member, name=next(folders)) if member.parameters else member for member in members]


def value_text(value: Any) -> str:
    """A swept value: «30», «1e-06», «vacuum», «[6e-06, 2e-05]»."""
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def swept_keys(members: Sequence[Member]) -> dict[str, str]:
    """Column heading of each key that a sweep of the campaign varies."""
    return short_keys(list(dict.fromkeys(key for member in members for key in member.parameters)))


class State(enum.Enum):
    NEW = "to do"
    HALF_DONE = "half done"
    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"


class Entry:
    """A case of the campaign. Its progress is read from its run directory."""

    def __init__(self, member: Member, folder: Path, build: str) -> None:
        """`build`: digest of the programs that would run it now."""
        self.member = member
        self.name = member.name
        self.path = folder / member.name
        self.plan = member.plan
        self.state = State.NEW
        self.remark = ""
        self.exit_code: int = ExitCode.FINISHED
        self._this_build = build

    @property
    def weight(self) -> float:
        """Cost in updates of a cell; a step without a fluid costs about as much as one of a thousand cells."""
        return self.plan.steps * max(self.plan.estimate.get("cells", 0), 1000)

    @property
    def summary(self) -> dict[str, Any] | None:
        """summary.json of a finished run, else None."""
        summary = read_object(self.path / "summary.json")
        return summary if summary.get("status") == "finished" else None

    @property
    def builds(self) -> list[str]:
        """Builds that took part in the run, the last one last."""
        provenance = read_object(self.path / "provenance.json")
        attempts = [*provenance.get("earlier_attempts", []), provenance]
        return list(dict.fromkeys(attempt.get("build") or "unknown" for attempt in attempts))

    @property
    def of_another_build(self) -> bool:
        return self.state is State.DONE and self.builds != [self._this_build]

    def look(self, rerun_other_builds: bool) -> None:
        """Finds out how far the case is. What cannot be continued is set aside, never removed, if it has any files."""
        if not self.path.exists():
            return
        if lock_of(self.path) is Lock.HELD:  # runs of a killed campaign write a checkpoint and end
            say(f"{self.name}: waiting for an earlier run in this folder to end")
            if lock_of(self.path, _ENDING_PATIENCE_S) is Lock.HELD:
                raise BadCase(f"{self.path} is in use (another copepod runs there). Wait for it to end.")
        if not self._holds_this_case():
            self._set_aside("the case has changed")
        elif self.summary:
            self.state = State.DONE
            if self.of_another_build and rerun_other_builds:
                self._set_aside("the build has changed")
                self.state = State.NEW
            elif self.of_another_build:
                self.remark = "done, by another build"
        elif last_checkpoint_step(self.path) >= 0:
            self.state = State.HALF_DONE
        elif any(files for _, _, files in os.walk(self.path)):
            self._set_aside("it has no checkpoint to continue from")
        else:
            shutil.rmtree(self.path)

    def _holds_this_case(self) -> bool:
        """Whether the folder is of this case, or of a run that ended before it had written its case."""
        if not (self.path / "case.yaml").exists():
            return all(child.name == "logs" for child in self.path.iterdir())
        try:
            return _physics(plan_of(self.path / "case.yaml").case) == _physics(self.plan.case)
        except Stop as refusal:  # a case that the present coupler cannot read
            refusal.refused()
            return False

    def _set_aside(self, reason: str) -> None:
        names = (f"{self.name}.before-{number}" for number in itertools.count(1))
        target = next(path for path in map(self.path.with_name, names) if not path.exists())
        self.path.rename(target)
        self.remark = f"{reason}; the former run is now {target.name}"


def _physics(case: Mapping[str, Any]) -> dict[str, Any]:
    """The resolved case without what changes no result: services, checkpoints, published figures."""
    copy: dict[str, Any] = json.loads(json.dumps(case))
    copy.pop("services", None)
    copy.get("output", {}).pop("checkpoint", None)
    for swimmer in copy.get("swimmers", []):
        swimmer.pop("published", None)
    return copy
