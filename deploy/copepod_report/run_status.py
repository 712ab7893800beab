"""How far a run is and how it ended, from what its directory holds; it may still be running."""

import re
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from copepod_run.errors import BY_SIGNAL
from copepod_run.figures import at
from copepod_run.run_directory import Lock, last_checkpoint_step, lock_of, read_object

_RECORDED_WITHIN_S = 60.0  # by a run that continues


@dataclass(frozen=True)
class RunStatus:
    """`state`: «finished», «running», «stopped», «failed» or, without a record of its end, «interrupted»."""

    state: str
    step: int  # the last in the files
    steps: int  # of the whole run; 0 if unknown
    reason: str = ""  # of a failure
    checkpoint: int = -1  # step of the last complete one; -1: none

    @property
    def is_finished(self) -> bool:
        return self.state == "finished"

    def sentences(self) -> str:
        """For the head of a page: state, how far, and why it ended."""
        if self.is_finished:
            return f"Finished after {self.step} steps."
        share = f" of {self.steps} ({100 * self.step // self.steps} %)" if self.steps else ""
        text = {
            "running": f"Running, at step {self.step}{share}. This page shows the run so far.",
            "stopped": f"Stopped by a signal at step {self.step}{share}, or shortly after.",
            "failed": f"Failed at step {self.step}{share}, or shortly after: {self.reason or 'no reason recorded'}",
            "interrupted": f"Ended at step {self.step}{share}, or shortly after, without a record (killed, or the "
            "machine went down).",
        }[self.state]
        if self.state == "running":
            return text
        last = f"The last checkpoint is of step {self.checkpoint}; «copepod run … --resume» continues from it."
        return f"{text} {last if self.checkpoint >= 0 else 'There is no checkpoint.'}"


def state_of(directory: Path) -> tuple[str, str]:
    """(state, reason) from provenance.json; without one a summary is that of a finished run."""
    provenance = read_object(directory / "provenance.json")
    reason = re.sub(r"\s+", " ", str(provenance.get("exit_reason") or ""))
    status = provenance.get("status")
    if status == "finished" or (status is None and (directory / "summary.json").exists()):
        return "finished", ""
    if status == "failed":
        return ("stopped" if provenance.get("exit_code") in BY_SIGNAL else "failed"), reason
    is_in_use = False
    with suppress(OSError):  # no such folder, or no progress yet
        found = lock_of(directory)
        is_in_use = found is Lock.HELD  # by the command that runs there
        if found is Lock.IMPOSSIBLE:
            is_in_use = time.time() - (directory / "logs/progress.json").stat().st_mtime < _RECORDED_WITHIN_S
    return ("running" if is_in_use else "interrupted"), ""


def status_of(directory: Path, case: dict[str, Any], state: tuple[str, str], step: int) -> RunStatus:
    """`step`: the last in its tables; a checkpoint, or the progress that was recorded, may be of a later one."""
    checkpoint = last_checkpoint_step(directory)
    recorded = 0 if state[0] == "finished" else int(read_object(directory / "logs" / "progress.json").get("step") or 0)
    return RunStatus(state[0], max(step, checkpoint, recorded), at(case, "run.steps") or 0, state[1], checkpoint)
