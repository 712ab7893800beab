"""One attempt at a run: three processes, from their start until nothing of them is left."""

import fcntl
import os
import secrets
import shlex
import sys
from contextlib import ExitStack

from copepod_run import cleanup, components, exit_codes, progress, provenance
from copepod_run.errors import Stop
from copepod_run.guard import Guard
from copepod_run.process import Process, adopt_orphans
from copepod_run.scratch import Scratch
from copepod_run.signals import SignalRecorder
from copepod_run.stages import say
from copepod_run.watch import Watch

_COUPLER_PATIENCE_S = 2.0  # to close its files after a signal
_CHECKPOINT_PATIENCE_S = 120.0  # if a signal finds it writing a checkpoint, or makes it write one
_PIPE_BYTES = 1 << 20  # events of half an hour, should this command be stopped by Ctrl-Z


class Attempt:
    """The three processes of a run, watched by this command and guarded by another process."""

    def __init__(self, options, plan, directory, resume):
        self._options = options
        self._plan = plan
        self._directory = directory
        self._resume = resume
        self._mark = secrets.token_hex(16)

    def run(self):
        """Ending of the attempt."""
        adopt_orphans()
        cells = self._plan.estimate.get("cells", 0)
        as_json = self._options.progress == "json"
        self._display = progress.EventProgress(sys.stderr) if as_json else progress.for_stream(sys.stderr, cells)
        say(self._headline(cells))
        with ExitStack() as stack:
            self._signals = stack.enter_context(SignalRecorder())
            scratch = Scratch(self._directory.path)
            keys = scratch.keys(self._plan.transport)
            guard = Guard(f"{components.MARK}={self._mark}", scratch.folders, self._directory.lock)
            stack.callback(guard.dismiss)
            stack.callback(scratch.remove)
            events = self._start(scratch, keys, stack)
            watch = Watch(self._processes, events, self._signals, self._display, self._plan.fluid_ranks)
            stack.callback(watch.close)
            ending = watch.wait()
            self._stop(watch, ending)
            return ending

    def _headline(self, cells):
        size = f"{cells / 1e6:.3g} million cells, " if cells else ""
        return f"{self._plan.name}: {size}{self._plan.steps} steps, in {self._directory.shown}"

    def _start(self, scratch, keys, stack):
        """Starts all three; returns the descriptor of the coupler's stdout."""
        path, session = self._directory.path, secrets.token_hex(16)
        connection = components.Connection(scratch.endpoint(self._plan.transport), session, keys, path / "logs")
        environment = components.environment(self._mark, scratch, self._plan.fluid_ranks)
        reading_end, writing_end = os.pipe()
        stack.callback(os.close, reading_end)
        _enlarge(reading_end)
        self._processes = []
        stack.callback(self._forget_processes)
        commands = {
            "coupler": components.coupler_command(self._options, self._plan, path, connection, self._resume),
        }
        if self._plan.transport != components.IN_PROCESS:
            commands["fluid"] = components.fluid_command(self._plan, connection)
            commands["body"] = components.body_command(self._plan, connection)
        try:
            for name, command in commands.items():
                self._processes.append(
                    Process(
                        name,
                        command,
                        {**environment, components.COMPONENT: name},
                        path / "logs",
                        events=writing_end if name == "coupler" else None,
                    )
                )
        except OSError as problem:
            raise Stop(
                exit_codes.BAD_CASE,
                f"{name} cannot be started ({problem}). Check this command: {self._shown(name, command)}",
            ) from None
        finally:
            os.close(writing_end)
        return reading_end

    def _shown(self, name, command):
        """The command without what the run adds to it: the token is nobody's business."""
        programs = {"fluid": components.fluid_program(self._plan), "body": components.body_program(self._plan)}
        return shlex.join(programs.get(name, command[:1]))

    def _stop(self, watch, ending):
        """Ends whatever still runs and says in provenance.json how the run ended."""
        self._display.close()
        if ending.signal:
            for process in self._processes:
                if process.name == "coupler":
                    process.send(ending.signal)
            watch.wait_for_coupler(_COUPLER_PATIENCE_S, _CHECKPOINT_PATIENCE_S)
        self._end_processes()
        if ending.failure:
            provenance.record_exit(self._directory.path, ending.failure.code, ending.failure.sentence())
        elif ending.signal:
            provenance.record_exit(self._directory.path, 128 + ending.signal, f"stopped by signal {ending.signal}")

    def _end_processes(self):
        left = cleanup.end_marked(f"{components.MARK}={self._mark}")
        if left:
            say(
                f"{left} process(es) of the run could not be killed (they hang in the kernel, a dead network disk?). "
                f"Look for them with: ps -eo pid,stat,args"
            )

    def _forget_processes(self):
        """Whatever happened, nothing of the attempt outlives it."""
        self._end_processes()
        for process in self._processes:
            process.wait()
        cleanup.reap_orphans()


def _enlarge(pipe):
    try:
        fcntl.fcntl(pipe, fcntl.F_SETPIPE_SZ, _PIPE_BYTES)
    except OSError:  # over the user's pipe quota; the default size works too
        pass
