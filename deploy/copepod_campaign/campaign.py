"""`copepod campaign`: runs what is left to do of a list of cases and keeps one result table up to date."""

import json
import os
import shlex
from argparse import Namespace
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

from copepod_campaign import results
from copepod_campaign.cases import Entry, State, members_of
from copepod_campaign.pool import RESTARTS, Pool, keep_copy
from copepod_run import build
from copepod_run.checkout import called_as
from copepod_run.errors import BadCase, ExitCode, Stop
from copepod_run.plan import Plan, case_arguments, request
from copepod_run.run_directory import RunDirectory, folder_name, make_folder
from copepod_run.watch import SignalRecorder
from copepod_run.messages import report, say

_NAMED = 10  # cases in a message
_NOT_FOR_SWEEPS = {
    **dict.fromkeys(("ranks", "fluid", "body"), ". Use --set services.… instead."),
    "branch_from": " (its members start from the beginning). Leave it out.",
    "resume": " (the same command again continues where it stopped). Leave it out.",
    "restarts": f" (a member is started again up to {RESTARTS} times by itself). Leave it out.",
}


def campaign(options: Namespace) -> int:
    """Runs a campaign to its end. Returns 0 if every case is finished; every other ending is a Stop."""
    build.ensure_programs()
    plan = request(options)
    if isinstance(plan, Plan):
        raise BadCase(f"{options.case} is a case (it lists no cases). Run it with: copepod run {options.case}")
    return run_items(plan.name, plan.items, options.jobs or plan.jobs, options)


def item_of_sweep(options: Namespace, plan: Plan) -> dict[str, Any]:
    """A case with a sweep as the only item of a campaign. Raises Stop(2) for an option that a sweep cannot have."""
    for name, advice in _NOT_FOR_SWEEPS.items():
        if getattr(options, name, None) not in (False, 0, None):
            raise BadCase(f"--{name} is not for sweeps{advice}")
    return {"name": plan.name, "file": options.case, "set": options.set}


def run_items(
    name: str,
    items: Sequence[Mapping[str, Any]],
    jobs: int | None,
    options: Namespace,
    again: str = "",
    table: Callable[[Sequence[Entry]], str] = results.text,
) -> int:
    """Runs what is left to do of `items`; `again` is the command that continues them, by default that of the `options`,
    `table` makes the result that is printed.

    Of `options` it takes `out`, `rerun_other_builds`, `keep_going`, and `json` to print results.json, not the table.
    Returns 0 if every case is finished, else raises Stop.
    """
    folder = Path(options.out or Path("runs") / folder_name(name))
    members = members_of(items)  # all of them are in order before a folder is made
    make_folder(folder)
    with ExitStack() as stack:
        directory = stack.enter_context(closing(RunDirectory(folder)))
        report("directory", path=str(directory.path), holds="campaign")
        programs = keep_copy(folder)
        entries = [Entry(member, folder, programs.name) for member in members]
        for entry in entries:
            entry.look(options.rerun_other_builds)
        signals = stack.enter_context(SignalRecorder())
        done = sum(entry.state is State.DONE for entry in entries)
        say(f"{name}: {len(entries)} cases, {done} done already, in {directory.shown}")
        for entry in entries:
            if entry.remark:
                say(f"{entry.name}: {entry.remark}")
        results.write(folder, name, entries)
        pool = Pool(name, entries, jobs or len(os.sched_getaffinity(0)), programs, signals, options.keep_going)
        for _ in pool.run():
            results.write(folder, name, entries)
    shown = directory.shown
    again = again or shlex.join([options.command, *case_arguments(options), "--out", shown])
    command = f"{called_as()} {again}"
    if signals.received:
        code = 128 + signals.received[0]
        raise Stop(code, f"stopped by a signal; nothing is lost. Continue with the same command: {command}")
    failed = [entry for entry in entries if entry.state is State.FAILED]
    print(json.dumps(results.records(name, entries)) if options.json else table(entries), flush=True)
    say(f"results in {shown}/results.md, .csv, .json")
    if failed:
        names = ", ".join(entry.name for entry in failed[:_NAMED]) + ("" if len(failed) <= _NAMED else ", …")
        left = sum(entry.state in (State.NEW, State.HALF_DONE) for entry in entries)
        not_started = f", {left} were not started" if left else ""
        raise Stop(
            failed[0].exit_code,
            f"{len(failed)} of {len(entries)} cases failed{not_started} ({names}; the reasons are above and in "
            f"{shown}/logs). Fix them and continue: {command}",
        )
    if others := [entry.name for entry in entries if entry.of_another_build]:
        say(
            f"{len(others)} results are of another build ({', '.join(others)}). "
            "To run them again with this build: --rerun-other-builds"
        )
    return ExitCode.FINISHED
