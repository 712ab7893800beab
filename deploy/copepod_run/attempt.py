"""One attempt at a run: three processes, from their start until nothing of them is left."""

import errno
import fcntl
import os
import secrets
import shlex
from argparse import Namespace
from contextlib import ExitStack

from copepod_run import components, hosts
from copepod_run.errors import ExitCode, Stop
from copepod_run.launcher import Launcher, Process
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


class Attempt:
    """The three processes of a run, watched by this command and guarded by another process."""

    def __init__(self, options: Namespace, plan: Plan, directory: RunDirectory, resume: bool) -> None:
        self._options = options
        self._plan = plan
        self._directory = directory
        self._resume = resume

    def run(self) -> Ending:
        cells = self._plan.estimate.get("cells", 0)
        display = Progress(cells, self._directory.path / "logs" / "progress.json")
        size = f"{cells / 1e6:.3g} million cells, " if cells else ""
        say(f"{self._plan.name}: {size}{self._plan.steps} steps, in {self._directory.shown}")
        with ExitStack() as stack:
            signals = stack.enter_context(SignalRecorder())
            mark = secrets.token_hex(16)
            scratch = Scratch(self._directory.path, mark)
            stack.callback(scratch.close)
            locks = [self._directory.lock, *scratch.locks]
            session = secrets.token_hex(16)
            environment = components.environment(mark, scratch, self._plan.fluid_ranks)
            environment[components.SESSION] = session
            launcher: Launcher
            if hosts.others(self._plan):
                from copepod_run.hosts_launcher import HostsLauncher  # runs on one machine start without it

                launcher = HostsLauncher(mark, scratch, locks, self._plan)
                stack.callback(launcher.close)
                keys, endpoint = launcher.connect(components.fluid_program(self._plan)[0])
                environment = launcher.environment(environment)
            else:
                keys, endpoint = scratch.keys(self._plan.transport), scratch.endpoint(self._plan.transport)
                launcher = Launcher(mark, scratch.folders, locks)
                stack.callback(launcher.close)
            connection = components.Connection(endpoint, session, keys, self._directory.path / "logs")
            events, writing_end = _pipe(stack)
            try:
                processes = self._start(launcher, connection, environment, writing_end)
            finally:
                os.close(writing_end)
            watch = Watch(launcher, processes, events, signals, display, self._plan.fluid_ranks)
            stack.callback(watch.close)
            ending = watch.wait()
            keep_drawn()
            self._stop(launcher, processes, watch, ending)
        return ending

    def _start(
        self, launcher: Launcher, connection: components.Connection, environment: dict[str, str], events: int
    ) -> list[Process]:
        """Starts all three; the coupler writes its events to `events`."""
        path = self._directory.path
        commands = {
            "coupler": components.coupler_command(self._options, self._plan, path, connection, self._resume),
        }
        if self._plan.transport != components.IN_PROCESS:
            commands["fluid"] = components.fluid_command(self._plan, connection)
            commands["body"] = components.body_command(self._plan, connection)
        processes = []
        for name, command in commands.items():
            try:
                processes.append(
                    launcher.start(name, command, environment, path / "logs", events if name == "coupler" else None)
                )
            except OSError as problem:
                if problem.errno in (errno.ENOSPC, errno.EDQUOT, errno.EROFS):  # its output cannot be written
                    raise
                raise Stop(
                    ExitCode.BAD_CASE,
                    f"{name} cannot be started ({problem}). Check this command: {self._shown(name, command)}",
                ) from None
        return processes

    def _shown(self, name: str, command: list[str]) -> str:
        """The command without what the run adds to it: the token must not be shown."""
        programs = {"fluid": components.fluid_program(self._plan), "body": components.body_program(self._plan)}
        return shlex.join(programs.get(name, command[:1]))

    def _stop(self, launcher: Launcher, processes: list[Process], watch: Watch, ending: Ending) -> None:
        """Ends what still runs and records in provenance.json how the run ended."""
        if ending.signal:
            for process in processes:
                if process.name == "coupler":
                    process.send(ending.signal)
            watch.wait_for_coupler(_COUPLER_PATIENCE_S, _CHECKPOINT_PATIENCE_S)
        if left := launcher.end_all():
            complain(
                f"{left} process(es) of the run could not be ended (they hang in the kernel, perhaps on a network disk "
                "that does not answer). Find them with: ps -eo pid,stat,args"
            )
        if ending.failure:
            self._directory.record_exit(ending.failure.code, ending.failure.sentence())
        elif ending.signal:
            self._directory.record_exit(128 + ending.signal, f"stopped by signal {ending.signal}")


def _pipe(stack: ExitStack) -> tuple[int, int]:
    """(reading end, writing end), with room for many events; the reading end is closed by `stack`."""
    reading_end, writing_end = os.pipe()
    stack.callback(os.close, reading_end)
    try:
        fcntl.fcntl(reading_end, fcntl.F_SETPIPE_SZ, _PIPE_BYTES)
    except OSError:  # beyond the user's quota for pipes; the default size works too
        pass
    return reading_end, writing_end
