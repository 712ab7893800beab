"""`copepod run`: plan, folder, three processes, watching, result; restarts if asked for."""

import json
import shlex
from argparse import Namespace

from copepod_campaign import campaign
from copepod_run import build, components, estimate, run_directory
from copepod_run.attempt import attempt
from copepod_run.checkout import called_as
from copepod_run.errors import BadCase, ExitCode, Stop, StorageFailed
from copepod_run.figures import result_table
from copepod_run.messages import report, say
from copepod_run.outcome import Failure
from copepod_run.plan import Plan, case_arguments, check_beginning, request_plan
from copepod_run.run_directory import RunDirectory, has_checkpoint, last_checkpoint_step

_WORTH_A_RESTART = (ExitCode.COMPONENT_LOST, ExitCode.DEADLINE_PASSED)
_SIGNALS = {2: "Ctrl-C", 15: "SIGTERM", 1: "SIGHUP"}


def run(options: Namespace) -> int:
    """Runs a case to its end. Returns 0; every other ending is a Stop."""
    build.ensure_programs(options)
    plan = request_plan(options)
    if plan.sweep:
        return campaign.run_sweep(options, plan)
    plan = components.settled(plan, options)
    for problem in components.problems_of_components(plan, only_replaced=True):
        raise BadCase(problem)
    found = [*plan.warnings, *estimate.warnings(estimate.memory_of(plan))]
    for warning in [*found, *estimate.disk_warnings(plan.estimate["disk_bytes"], options.out or "runs")]:
        say(warning)
    if options.resume:
        directory = run_directory.reopen(plan.name, options.out)
    else:
        if options.branch_from:
            check_beginning(options, components.branch_arguments(options))
        directory = run_directory.create(plan.name, options.out)
    report("directory", path=str(directory.path), holds="run")
    try:
        if options.resume:
            check_beginning(options, ["--resume", "--out", str(directory.path)])
        return _attempts(options, plan, directory)
    finally:
        directory.close()


def _attempts(options: Namespace, plan: Plan, directory: RunDirectory) -> int:
    """One attempt, and up to --restarts more as long as a component is lost."""
    resume = options.resume
    for left in range(options.restarts, -1, -1):
        start = last_checkpoint_step(directory.path) if resume else -1
        ending = attempt(options, plan, directory, resume)
        if ending.summary:
            summary = directory.summary()
            if summary is None:
                raise StorageFailed(
                    f"{ending.summary} cannot be read (is the disk full?). Free some space and run again."
                )
            estimate.remember(plan, summary)
            shown = {"directory": directory.shown, **summary} if options.json else None
            print(json.dumps(shown) if shown else result_table(summary, directory.shown), flush=True)
            return ExitCode.FINISHED
        if ending.failure is None:
            how = f"stopped by {_SIGNALS[ending.signal]}. Logs: {directory.shown}/logs."
            raise Stop(128 + ending.signal, f"{how} {_way_to_continue(options, directory)}")
        failure = ending.failure
        if left == 0 or failure.code not in _WORTH_A_RESTART:
            raise Stop(failure.code, f"{failure.sentence()}{_advice(failure, start, options, directory)}")
        resume = has_checkpoint(directory.path)
        say(failure.sentence())
        say(f"starting again {'from the last checkpoint' if resume else 'from the beginning'}, {left} restart(s) left")
    raise AssertionError("the last attempt returns or raises")


def _advice(failure: Failure, start: int, options: Namespace, directory: RunDirectory) -> str:
    """How to continue after a failure; `start`: step of the checkpoint that the attempt resumed from, -1 if none."""
    logs = "" if failure.log else f" Logs: {directory.shown}/logs."
    if failure.code in (ExitCode.BAD_CASE, ExitCode.REFUSED, ExitCode.SOLVER_FAILED):
        return logs
    if start >= 0 and failure.step <= start and not failure.was_killed:  # the same command would fail in the same way
        return logs
    return f"{logs} {_way_to_continue(options, directory)}"


def _way_to_continue(options: Namespace, directory: RunDirectory) -> str:
    if not has_checkpoint(directory.path):
        return "There is no checkpoint: run again from the start."
    case, *changes = case_arguments(options)
    command = [called_as(), "run", case, "--out", directory.shown, *changes, "--resume"]
    return f"Continue from the last checkpoint: {shlex.join(command)}"
