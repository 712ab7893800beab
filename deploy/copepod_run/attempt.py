"""One attempt at a run: three processes, from their start until nothing of them is left."""

import errno
import fcntl
import os
import secrets
import shlex
from argparse import Namespace
from contextlib import ExitStack, suppress

from copepod_run import components, hosts
from copepod_run.errors import BadCase
from copepod_run.launcher import Launcher
from copepod_run.messages import complain, keep_drawn, say
from copepod_run.plan import Plan
from copepod_run.progress import Progress
from copepod_run.run_directory import RunDirectory
from copepod_run.scratch import Scratch
from copepod_run.signals import SignalRecorder
from copepod_run.watch import Ending, Watch

_COUPLER_PATIENCE_S = 2.0  # to close its files after a signal
_CHECKPOINT_PATIENCE_S = 120.0  # if a signal finds it writing a checkpoint, or makes it write one
_PIPE_BYTES = 1 << 20  # events of half an hour, should this command be stopped by Ctrl-Z


def attempt(options: Namespace, plan: Plan, directory: RunDirectory, resume: bool) -> Ending:
    """The three processes of a run, watched by this command and guarded by another process."""
    cells = plan.estimate.get("cells", 0)
    display = Progress(cells, directory.path / "logs" / "progress.json")
    size = f"{cells / 1e6:.3g} million cells, " if cells else ""
    say(f"{plan.name}: {size}{plan.steps} steps, in {directory.shown}")
    with ExitStack() as stack:
        signals = stack.enter_context(SignalRecorder())
        scratch = Scratch(directory.path, secrets.token_hex(16))
        stack.callback(scratch.close)
        locks = [directory.lock, *scratch.locks]
        session = secrets.token_hex(16)
        environment = components.environment(scratch, plan.fluid_ranks)
        environment[components.SESSION] = session
        launcher: Launcher
        if hosts.others(plan):
            from copepod_run.hosts_launcher import HostsLauncher  # runs on one machine start without it

            launcher = HostsLauncher(scratch, locks, plan)
            stack.callback(launcher.close)
            keys, endpoint = launcher.connect(components.program_of(plan, "fluid")[0])
            environment = launcher.environment(environment)
        else:
            keys, endpoint = scratch.keys(plan.transport), scratch.endpoint(plan.transport)
            launcher = Launcher(scratch, locks)
            stack.callback(launcher.close)
        connection = components.Connection(endpoint, session, keys, directory.path / "logs")
        commands = {"coupler": components.coupler_command(options, plan, directory.path, connection, resume)}
        if plan.transport != components.IN_PROCESS:
            commands |= {role: components.component_command(plan, role, connection) for role in components.ROLES}
        events, writing_end = os.pipe()
        stack.callback(os.close, events)
        with suppress(OSError):  # beyond the user's quota for pipes; the default size works too
            fcntl.fcntl(events, fcntl.F_SETPIPE_SZ, _PIPE_BYTES)
        processes = []
        try:
            for name, command in commands.items():
                stdout = writing_end if name == "coupler" else None  # takes its events
                processes.append(launcher.start(name, command, environment, connection.logs, stdout))
        except OSError as problem:
            if problem.errno in (errno.ENOSPC, errno.EDQUOT, errno.EROFS):  # its output cannot be written
                raise
            # Without what the run adds to it: the token must not be shown.
            shown = shlex.join(components.program_of(plan, name) if name in components.ROLES else command[:1])
            raise BadCase(f"{name} cannot be started ({problem}). Check this command: {shown}") from None
        finally:
            os.close(writing_end)
        watch = Watch(launcher, processes, events, signals, display, plan.fluid_ranks)
        stack.callback(watch.close)
        ending = watch.wait()
        keep_drawn()
        if ending.signal:
            processes[0].send(ending.signal)  # the coupler
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
