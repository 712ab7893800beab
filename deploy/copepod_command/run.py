"""`copepod run`: plan, folder, three processes, watching, result; restarts if asked for."""

import errno
import fcntl
import json
import os
import secrets
import select
import shlex
import sys
import time
from argparse import Namespace
from contextlib import ExitStack, closing, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from copepod_campaign import campaign
from copepod_run import build, components, estimate, hosts, run_directory
from copepod_run.checkout import called_as
from copepod_run.errors import BadCase, ExitCode, Stop, StorageFailed
from copepod_run.figures import result_table
from copepod_run.launcher import LOOK_EVERY_S, Launcher
from copepod_run.messages import complain, keep_drawn, report, say
from copepod_run.outcome import Failure, judge
from copepod_run.plan import Plan, case_arguments, request_plan
from copepod_run.processes import own_host
from copepod_run.progress import Progress
from copepod_run.run_directory import Lock, RunDirectory, last_checkpoint_step, lock_of, read_object
from copepod_run.scratch import Scratch
from copepod_run.watch import AFTER_FINISH_S, Ending, SignalRecorder, Watch

_WORTH_A_RESTART = (ExitCode.COMPONENT_LOST, ExitCode.DEADLINE_PASSED)
_SIGNALS = {2: "Ctrl-C", 15: "SIGTERM", 1: "SIGHUP"}
_COUPLER_PATIENCE_S = 2.0  # to close its files after a signal
_CHECKPOINT_PATIENCE_S = 120.0  # if a signal finds it writing a checkpoint, or makes it write one
_Prepared = tuple[Launcher, components.Connection, dict[str, str]]  # what starts processes, and their environment
_PIPE_BYTES = 1 << 20  # events of half an hour, should this command be stopped by Ctrl-Z


def run(options: Namespace) -> int:
    """Runs a case to its end. Returns 0; every other ending is a Stop."""
    build.ensure_programs(options)
    plan = request_plan(options, ["--resume"] if options.resume else [])
    if plan.sweep:  # a campaign of its members, which continues where it stopped
        return campaign.run_items(plan.name, [campaign.item_of_sweep(options, plan)], None, options)
    if options.branch_from:
        plan = request_plan(options, components.branch_arguments(options))
    plan = components.settled(plan, options.ranks)
    for problem in components.problems_of_components(plan, plan.commands):
        raise BadCase(problem)
    found = [*plan.warnings, *estimate.warnings(estimate.memory_of(plan))]
    for warning in [*found, *estimate.disk_warnings(plan.estimate["disk_bytes"], options.out or "runs")]:
        say(warning)
    directory = (run_directory.reopen if options.resume else run_directory.create)(plan.name, options.out)
    report("directory", path=str(directory.path), holds="run")
    with closing(directory):
        if options.resume:
            request_plan(options, ["--resume", "--out", str(directory.path)])
        return _attempts(options, plan, directory)


def _attempts(options: Namespace, plan: Plan, directory: RunDirectory) -> int:
    """One attempt, and up to --restarts more as long as a component is lost."""
    resume = options.resume
    for left in range(options.restarts, -1, -1):
        start = last_checkpoint_step(directory.path) if resume else -1
        ending = _attempt(options, plan, directory, resume)
        if ending.summary:
            if not (summary := read_object(directory.path / "summary.json")):
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
        resume = last_checkpoint_step(directory.path) >= 0
        say(failure.sentence())
        say(f"starting again {'from the last checkpoint' if resume else 'from the beginning'}, {left} restart(s) left")
    raise AssertionError("the last attempt returns or raises")


def _attempt(options: Namespace, plan: Plan, directory: RunDirectory, resume: bool) -> Ending:
    """Three processes, watched by this command and guarded by another one, until nothing of them is left."""
    cells = plan.estimate.get("cells", 0)
    display = Progress(cells, directory.path / "logs" / "progress.json")
    size = f"{cells / 1e6:.3g} million cells, " if cells else ""
    say(f"{plan.name}: {size}{plan.steps} steps, in {directory.shown}")
    with ExitStack() as stack:
        signals = stack.enter_context(SignalRecorder())
        scratch = stack.enter_context(closing(Scratch(directory.path, secrets.token_hex(16))))
        locks, logs = [directory.lock, *scratch.locks], directory.path / "logs"
        prepared = launcher, connection, _ = _prepare(stack, plan, scratch, locks, logs)
        commands = {"coupler": components.coupler_command(options, plan, directory.path, connection, resume)}
        if plan.transport != components.IN_PROCESS:
            commands |= {role: components.component_command(plan, role, connection) for role in plan.roles}
        events, writing_end = os.pipe()
        stack.callback(os.close, events)
        with suppress(OSError):  # beyond the user's quota for pipes; the default size works too
            fcntl.fcntl(events, fcntl.F_SETPIPE_SZ, _PIPE_BYTES)
        try:
            _start(plan, commands, prepared, writing_end)
        finally:
            os.close(writing_end)
        watch = stack.enter_context(closing(Watch(launcher, events, signals, display, plan.fluid_ranks)))
        ending = watch.wait()
        keep_drawn()
        if ending.signal:
            launcher.processes["coupler"].send(ending.signal)
            watch.wait_for_coupler(_COUPLER_PATIENCE_S, _CHECKPOINT_PATIENCE_S)
        if left := launcher.end_all():
            complain(
                f"{left} process(es) of the run could not be ended (they hang in the kernel, perhaps on a network disk "
                "that does not answer). Find them with: ps -eo pid,stat,args"
            )
        if ending.failure:
            directory.record_exit(ending.failure.code, ending.failure.sentence())
        elif ending.signal:
            directory.record_exit(128 + ending.signal, f"stopped by signal {ending.signal}")
    return ending


def _prepare(stack: ExitStack, plan: Plan, scratch: Scratch, locks: list[int], logs: Path) -> _Prepared:
    """For processes that end with the `stack`. Raises Stop(2) if a host cannot take part."""
    session = secrets.token_hex(16)
    environment = components.environment(scratch, plan.fluid_ranks)
    environment[components.SESSION] = session
    launcher: Launcher
    if hosts.others(plan):
        from copepod_run.hosts_launcher import HostsLauncher  # runs on one machine start without it

        launcher = stack.enter_context(closing(HostsLauncher(scratch, locks, plan)))
        keys, endpoint = launcher.connect(components.program_of(plan, "fluid")[0])
        environment = launcher.environment(environment)
    else:
        keys, endpoint = scratch.keys(plan.transport, plan.roles), scratch.endpoint(plan.transport)
        launcher = stack.enter_context(closing(Launcher(scratch, locks)))
    return launcher, components.Connection(endpoint, session, keys, logs), environment


def _start(plan: Plan, commands: dict[str, list[str]], prepared: _Prepared, events: int | None = None) -> None:
    """Processes by name; the coupler's stdout is the pipe end `events`. Raises Stop(2) if one cannot be started."""
    launcher, connection, environment = prepared
    try:
        for name, command in commands.items():
            launcher.start(name, command, environment, connection.logs, events if name == "coupler" else None)
    except OSError as problem:
        if problem.errno in (errno.ENOSPC, errno.EDQUOT, errno.EROFS):  # its output cannot be written
            raise
        # Without what the run adds to it: the token must not be shown.
        shown = shlex.join(components.program_of(plan, name) if name in plan.roles else command[:1])
        raise BadCase(f"{name} cannot be started ({problem}). Check this command: {shown}") from None


def _services(order: dict[str, Any]) -> None:
    """Starts the services of a simulation, whose coupler is in the process that has started this one, and watches them.

    `order`: case, set, ranks, directory (None: none), resumes. A line of JSON on standard output has `settings` for the
    coupler, or a `problem` and its `code`; such a line follows once a service has failed. The services end with
    standard input, by themselves if a byte came before.
    """
    options = Namespace(**order, fluid=None, body=None)
    build.ensure_programs(options)
    plan = components.settled(request_plan(options), options.ranks)
    plan = replace(plan, transport="ipc") if plan.transport == components.IN_PROCESS else plan
    for problem in components.problems_of_components(plan, plan.commands):
        raise BadCase(problem)
    directory = Path(options.directory) if options.directory else None
    if directory and directory.exists():
        is_other = (directory / "case.yaml").exists() is not options.resumes
        directory = None if is_other or lock_of(directory) is Lock.HELD else directory  # the simulation will refuse it
    with ExitStack() as stack:
        if directory:
            run_directory.make_folder(directory / "logs")
        scratch = stack.enter_context(closing(Scratch(directory, secrets.token_hex(16))))
        logs = directory / "logs" if directory else scratch.files
        prepared = launcher, connection, _ = _prepare(stack, plan, scratch, scratch.locks, logs)
        _start(plan, {role: components.component_command(plan, role, connection) for role in plan.roles}, prepared)
        keys = [f"--keys={connection.keys['coupler']}"] if connection.keys else []
        settings = [f"--endpoint={connection.endpoint}", f"--session={connection.session}", *keys]
        print(json.dumps({"settings": settings}), flush=True)
        processes, failure = launcher.processes.values(), None
        while not failure and not select.select([sys.stdin], [], [], LOOK_EVERY_S)[0]:
            exits = [process.exit(plan.fluid_ranks) for process in processes if process.returncode is not None]
            failure = judge(None, exits, -1, own_host()) if exits else launcher.look()
        if failure:
            failure = failure if directory else replace(failure, log="")  # which is removed
            print(json.dumps({"problem": failure.sentence(), "code": failure.code}), flush=True)
        deadline = time.monotonic() + AFTER_FINISH_S if sys.stdin.read(1) else 0.0
        while any(process.returncode is None for process in processes) and time.monotonic() < deadline:
            time.sleep(0.02)


def _advice(failure: Failure, start: int, options: Namespace, directory: RunDirectory) -> str:
    """How to continue after a failure; `start`: step of the checkpoint that the attempt resumed from, -1 if none."""
    logs = "" if failure.log else f" Logs: {directory.shown}/logs."
    if failure.code in (ExitCode.BAD_CASE, ExitCode.REFUSED, ExitCode.SOLVER_FAILED):
        return logs
    if start >= 0 and failure.step <= start and not failure.was_killed:  # the same command would fail in the same way
        return logs
    return f"{logs} {_way_to_continue(options, directory)}"


def _way_to_continue(options: Namespace, directory: RunDirectory) -> str:
    if last_checkpoint_step(directory.path) < 0:
        return "There is no checkpoint: run again from the start."
    case, *changes = case_arguments(options)
    command = [called_as(), "run", case, "--out", directory.shown, *changes, "--resume"]
    return f"Continue from the last checkpoint: {shlex.join(command)}"


if __name__ == "__main__":
    try:
        _services(json.loads(sys.argv[1]))
    except Stop as stop:
        print(json.dumps({"problem": str(stop).strip(), "code": stop.code}))
