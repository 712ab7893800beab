"""One case of a campaign: what is to be run, and how far it is according to its folder."""

import enum
import json
import os
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from copepod_campaign.sweep import Member
from copepod_run.errors import BadCase, ExitCode, Stop
from copepod_run.plan import plan_of
from copepod_run.run_directory import Lock, has_checkpoint, lock_of, read_object
from copepod_run.messages import say

_ENDING_PATIENCE_S = 180.0  # a run that was left behind writes its checkpoint


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
        self._wait_until_free()
        if not self._holds_this_case():
            self._set_aside("the case has changed")
        elif self.summary:
            self.state = State.DONE
            if self.of_another_build and rerun_other_builds:
                self._set_aside("the build has changed")
                self.state = State.NEW
            elif self.of_another_build:
                self.remark = "done, by another build"
        elif has_checkpoint(self.path):
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

    def _wait_until_free(self) -> None:
        """Runs of a killed campaign write a checkpoint and end."""
        if lock_of(self.path) is Lock.HELD:
            say(f"{self.name}: waiting for an earlier run in this folder to end")
            if lock_of(self.path, _ENDING_PATIENCE_S) is Lock.HELD:
                raise BadCase(f"{self.path} is in use (another copepod runs there). Wait for it to end.")

    def _set_aside(self, reason: str) -> None:
        number = 1
        while (target := self.path.with_name(f"{self.name}.before-{number}")).exists():
            number += 1
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
