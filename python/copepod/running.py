"""Checks and runs of cases. Every run is a `copepod run` in a process of its own, which this one reads and can stop."""

import json
import os
import re
import select
import signal
import subprocess
import sys
import tempfile
import time
import warnings
from argparse import Namespace
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from copepod.case import Case
from copepod.errors import CaseError, CaseWarning, Error, RunError, stops_as_errors
from copepod.results import Campaign, Run, Sample, TrajectoryReader, load
from copepod_campaign.check import Check, findings
from copepod_run.checkout import COMMAND
from copepod_run.errors import ExitCode
from copepod_run.launcher import RunProcess
from copepod_run.progress import Event, clock_text

_LOOK_EVERY_S = 0.2  # at new samples of the trajectory
_DRAW_EVERY_S = 0.5

AnyCase = Case | Mapping[str, Any] | str | Path
Settings = Mapping[str, Any] | Sequence[str]


@dataclass(frozen=True)
class Progress:
    """How far a run or campaign is."""

    share: float  #: 0 to 1
    step: int  #: done; of a campaign: members
    steps: int  #: in all; of a campaign: members
    remaining_s: float | None  #: time left [s]; None as long as the speed is unknown


def check(case: AnyCase, set: Settings = (), ranks: int | None = None) -> Check:
    """Key figures, estimates, warnings and problems of a case; nothing of it is run.

    @param case   a Case, a dictionary or the path of a case file
    @param set    other values of some keys: {"run.steps": 1000} or ["run.steps=1000"]
    @param ranks  MPI ranks of the fluid
    @throws CaseError with every error in the case
    """
    with case_file(case) as file:
        options = {"set": assignments(set), "ranks": ranks, "fluid": None, "body": None, "start_components": False}
        try:
            with stops_as_errors():
                found = findings(Namespace(case=str(file.path), **options))
        except CaseError as error:
            raise CaseError(file.shown(str(error)), error.code) from None
    return replace(found, warnings=[file.shown(warning) for warning in found.warnings])


def run(
    case: AnyCase,
    out: str | Path | None = None,
    *,
    set: Settings = (),
    ranks: int | None = None,
    fluid: str | None = None,
    body: str | None = None,
    resume: bool = False,
    restarts: int = 0,
    on_progress: Callable[[Progress], object] | None = None,
    on_sample: Callable[[Sample], object] | None = None,
    quiet: bool = False,
) -> Any:
    """Runs a case to its end; a case with a sweep: all its members, several at once.

    An interrupt (Ctrl-C, "stop" in a notebook) and any exception in a callback stop the run: it writes a checkpoint,
    and the exception continues. Several threads may run cases at the same time.

    @param case         a Case, a dictionary or the path of a case file
    @param out          run directory; default: runs/<case> in the current directory, with a number if that exists. The
                        folder of a sweep continues where it stopped
    @param set          other values of some keys: {"run.steps": 1000} or ["run.steps=1000"]
    @param ranks        MPI ranks of the fluid
    @param fluid, body  commands that replace these components
    @param resume       continues the run in `out` from its last checkpoint
    @param restarts     starts again up to this many times when a component is lost
    @param on_progress  called about once a second with a `Progress`, instead of the line on stderr
    @param on_sample    called with each `Sample` of the trajectory, within about a second; own observables go here. It
                        receives copies: nothing that it does changes the run. Not for sweeps
    @param quiet        no line on stderr, no warnings
    @return a `Run`, or a `Campaign` of a case with a sweep
    @throws CaseError for a bad case or argument, RunError for a run that did not finish
    """
    words = [f"--set={assignment}" for assignment in assignments(set)]
    for name, value in (("out", out), ("ranks", ranks), ("fluid", fluid), ("body", body), ("restarts", restarts)):
        words += [f"--{name}={value}"] if value else []
    words += ["--resume"] if resume else []
    if not COMMAND.exists():
        raise Error(f"{COMMAND} does not exist (was the checkout moved?). Install copepod from it again.")
    with case_file(case) as file:
        command = [str(COMMAND), "run", str(file.path), *words]
        show = on_progress or (None if quiet else _ProgressLine(file.name))
        return _Conversation(command, file, show, on_sample, quiet).finish()


class _Conversation(RunProcess):
    """A run that is on: reads what it reports, and stops it if anything is raised meanwhile."""

    def __init__(
        self,
        command: Sequence[str],
        file: "_CaseFile",
        show: Callable[[Progress], object] | None,
        on_sample: Callable[[Sample], object] | None,
        quiet: bool,
    ) -> None:
        self._file = file
        self._show = show
        self._on_sample = on_sample
        self._quiet = quiet
        self._directory: str | None = None
        self._lines: list[str] = []
        self._samples: TrajectoryReader | None = None
        super().__init__(command, os.environ, subprocess.DEVNULL)

    def finish(self) -> "Run | Campaign":
        try:
            while self.exit_code is None:
                patience_s = _LOOK_EVERY_S if self._samples else None
                if select.select([self.descriptor], [], [], patience_s)[0]:
                    self.read()
                self._pass_on_samples()
            self._pass_on_samples(is_last=True)
        except BaseException as problem:
            self._stop()
            if self._directory and not isinstance(problem, Exception):
                problem.add_note(
                    f"{self._directory} holds what was computed; run the case with resume=True to continue."
                )
            raise
        finally:
            if isinstance(self._show, _ProgressLine):
                self._show.close()
        if self.exit_code:
            raise self._failure(self.exit_code)
        assert self._directory is not None
        return load(self._directory)

    def _note(self, line: str) -> None:
        text = line.removeprefix("copepod: ")
        self._lines.append(text)
        if not self._quiet and re.search(r"(?:^|: )warning: ", text):
            warnings.warn(self._file.shown(text), CaseWarning, stacklevel=5)

    def _take(self, event: Event) -> None:
        kind = event["event"]
        if kind == "directory":
            self._directory = str(event["path"])
            if self._on_sample and event["holds"] == "run":
                self._samples = TrajectoryReader(Path(self._directory))
        elif kind == "progress" and self._show:
            share = event["step"] / max(event["steps"], 1)
            remaining_s = event["remaining_s"] if event.get("steps_per_s", True) else None
            self._show(Progress(event.get("share", share), event["step"], event["steps"], remaining_s))

    def _pass_on_samples(self, is_last: bool = False) -> None:
        if self._samples and self._on_sample:
            for sample in self._samples.read(is_last):
                self._on_sample(sample)

    def _stop(self) -> None:
        """Until the run has written its checkpoint; another interrupt ends it at once."""
        try:
            self.send(signal.SIGTERM)
            while self.exit_code is None:
                self.read()
        except BaseException:
            self.send(signal.SIGKILL)  # its guard cleans up
            raise

    def _failure(self, code: int) -> CaseError | RunError:
        lines = [_in_python(self._file.shown(line)) for line in self._lines]
        if code == ExitCode.BAD_CASE:
            errors = [line for line in lines if "error: " in line]
            return CaseError("\n".join(errors or lines[-1:]), code)
        reasons = [line for line in lines[:-1] if ": failed. " in line]  # of the members of a sweep
        return RunError("\n".join([*reasons, *lines[-1:]]) or f"the run ended with code {code}", code, self._directory)


def _in_python(message: str) -> str:
    """What the command advises, as arguments of `run`."""
    message = re.sub(
        r"Continue from the last checkpoint: .*|Continue (?:it )?with --resume", "Continue with resume=True", message
    )
    message = re.sub(
        r"reasons are above and in (\S+)\)\. Fix them and continue: .*", r"logs: \1). The same call continues.", message
    )
    return re.sub(r"^.* run: error: (?:argument )?", "", message).replace("--out", "out")


@dataclass(frozen=True)
class _CaseFile:
    """A case as the command takes it; `is_ours`: written for one call, at a path of no interest to the user."""

    path: Path
    name: str
    is_ours: bool

    def shown(self, message: str) -> str:
        """A message with keys rather than lines of our own file."""
        return re.sub(rf"{re.escape(str(self.path))}(?::\d+)?(?:: )?", "", message) if self.is_ours else message


@contextmanager
def case_file(case: AnyCase) -> Iterator[_CaseFile]:
    if isinstance(case, (str, Path)):
        yield _CaseFile(Path(case), Path(case).stem, is_ours=False)
        return
    with tempfile.TemporaryDirectory(prefix="copepod_case_") as folder:
        case = case if isinstance(case, Case) else Case(case)
        path = Path(folder) / "case.yaml"
        case.save(path)
        yield _CaseFile(path, str(case.get("case", "case")), is_ours=True)


def assignments(settings: Settings) -> list[str]:
    """As after --set; JSON is YAML."""
    if isinstance(settings, Mapping):
        return [f"{key}={json.dumps(value)}" for key, value in Case({"set": settings})["set"].items()]
    return list(settings)


class _ProgressLine:
    """A line on stderr that is drawn again and again."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._next_s = 0.0
        self._drawn = False

    def __call__(self, progress: Progress) -> None:
        now = time.monotonic()
        if now < self._next_s and progress.step != progress.steps:
            return
        self._next_s = now + _DRAW_EVERY_S
        self._drawn = True
        left = "" if progress.remaining_s is None else f", {clock_text(progress.remaining_s)} left"
        print(f"\r{self._name}: {progress.share:.0%}{left:<20}", end="", file=sys.stderr, flush=True)

    def close(self) -> None:
        if self._drawn:
            print(file=sys.stderr)
