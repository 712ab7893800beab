"""`copepod watch`: a live page of a run, on loopback."""

import time
from argparse import Namespace
from functools import partial
from pathlib import Path

from copepod_run import build
from copepod_run.errors import ExitCode, Stop
from copepod_run.messages import say
from copepod_run.plan import plan_of

_START_PATIENCE_S = 10.0  # for a run that has just been started to write its case


def watch(options: Namespace) -> int:
    """Serves the page until a signal ends it."""
    build.ensure_programs()
    # These need numpy and matplotlib: slow to load, and perhaps installed just now.
    from copepod_report.page import Canvas
    from copepod_report.report import opening_figures, page_of
    from copepod_watch.follower import RunFollower
    from copepod_watch.server import WatchServer

    directory = Path(options.directory)
    _require_run(directory)
    cases: dict[Path, dict[str, object]] = {}

    def follow(path: Path) -> RunFollower:
        plan = plan_of(path / "case.yaml")  # the coupler is the only parser of cases
        cases[path] = plan.drawn_case
        return RunFollower(path, cases[path], plan.estimate.get("cells", 0))

    def report(path: Path) -> str:
        return page_of(path, lambda case: cases.get(case.parent) or plan_of(case).drawn_case)

    draw = partial(opening_figures, canvas=Canvas(None))
    with WatchServer(directory, options.port, follow, report, draw, say) as server:
        if (directory / "case.yaml").is_file():
            server.watch("")
        print(server.address, flush=True)
        say("the page is for this machine only; Ctrl-C ends it")
        server.serve_forever(poll_interval=0.2)
    raise AssertionError("only a signal ends it")


def _require_run(directory: Path) -> None:
    """Raises Stop(2) unless the folder holds a run or runs; waits a moment for one that has just been started."""
    from copepod_report.run_status import state_of
    from copepod_watch.follower import runs_in

    if not directory.is_dir():
        raise Stop(ExitCode.BAD_CASE, f"{directory} is not a folder (no run has been started there). {_ADVICE}")
    deadline = time.monotonic() + _START_PATIENCE_S
    while not runs_in(directory):
        if state_of(directory)[0] != "running" or time.monotonic() > deadline:
            raise Stop(ExitCode.BAD_CASE, f"{directory} does not hold a run (no case.yaml). {_ADVICE}")
        time.sleep(0.1)


_ADVICE = "Start one with copepod run CASE.yaml --out DIR, then watch that folder."
