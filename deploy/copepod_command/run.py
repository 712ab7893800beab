"""`copepod run`: plan, folder, three processes, watching, result; restarts if asked for."""

import fcntl
import os
import secrets
import shlex
import sys
from contextlib import ExitStack
from pathlib import Path

from copepod_command import build, cleanup, components, exit_codes, progress, provenance, run_directory, speed
from copepod_command.checkout import called_as
from copepod_command.errors import Stop
from copepod_command.guard import Guard
from copepod_command.plan import request_plan
from copepod_command.process import Process, adopt_orphans
from copepod_command.scratch import Scratch
from copepod_command.signals import SignalRecorder
from copepod_command.stages import say
from copepod_command.table import result_table
from copepod_command.watch import Watch

_COUPLER_PATIENCE_S = 2.0  # to close its files after a signal
_CHECKPOINT_PATIENCE_S = 60.0  # if a signal finds it writing a checkpoint, or makes it write one
_PIPE_BYTES = 1 << 20  # events of half an hour, should this command be stopped by Ctrl-Z
_WORTH_A_RESTART = (exit_codes.COMPONENT_LOST, exit_codes.DEADLINE_PASSED)


def run(options):
    """Runs a case to its end. Returns 0; every other ending is a Stop."""
    build.ensure_programs()
    plan = request_plan(options)
    components.check_replacements(plan)
    for warning in plan.warnings:
        say(warning)
    if options.resume:
        directory = run_directory.reopen(plan.name, options.out)
    else:
        directory = run_directory.create(plan.name, options.out)
    try:
        return _attempts(options, plan, directory)
    finally:
        directory.close()


def _attempts(options, plan, directory):
    """One attempt, and up to --restarts more as long as a component is lost."""
    resume = options.resume
    for left in range(options.restarts, -1, -1):
        ending = Attempt(options, plan, directory, resume).run()
        if ending.summary:
            summary = directory.summary()
            if summary is None:
                raise Stop(
                    exit_codes.STORAGE_FAILED,
                    f"{ending.summary} cannot be read (the disk is full?). Make room and run again.",
                )
            speed.remember(summary)
            print(result_table(summary, _shown(directory.path)), flush=True)
            return exit_codes.FINISHED
        if ending.signal:
            raise _stopped_by(ending.signal, options, directory)
        if left == 0 or ending.failure.code not in _WORTH_A_RESTART:
            raise Stop(
                ending.failure.code, f"{ending.failure.sentence()} {_advice(ending.failure.code, options, directory)}"
            )
        resume = directory.has_checkpoint()
        say(ending.failure.sentence())
        say(f"starting again {'from the last checkpoint' if resume else 'from the beginning'}, {left} restart(s) left")


class Attempt:
    """The three processes of a run, from their start until nothing of them is left."""

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
        self._display = progress.for_stream(sys.stderr, cells)
        say(self._headline(cells))
        with ExitStack() as stack:
            self._signals = stack.enter_context(SignalRecorder())
            scratch = Scratch(self._directory.path)
            guard = Guard(f"{components.MARK}={self._mark}", scratch.folders)
            stack.callback(guard.dismiss)
            stack.callback(scratch.remove)
            events = self._start(scratch, stack)
            watch = Watch(self._processes, events, self._signals, self._display, self._plan.fluid_ranks, self._mark)
            stack.callback(watch.close)
            ending = watch.wait()
            self._stop(watch, ending)
            return ending

    def _headline(self, cells):
        size = f"{cells / 1e6:.3g} million cells, " if cells else ""
        return f"{self._plan.name}: {size}{self._plan.steps} steps, in {_shown(self._directory.path)}"

    def _start(self, scratch, stack):
        """Starts all three; returns the descriptor of the coupler's stdout."""
        path, session = self._directory.path, secrets.token_hex(16)
        endpoint = scratch.endpoint(self._plan.transport)
        environment = components.environment(self._mark, scratch, self._plan.fluid_ranks)
        reading_end, writing_end = os.pipe()
        stack.callback(os.close, reading_end)
        _enlarge(reading_end)
        self._processes = []
        stack.callback(self._forget_processes)
        commands = {
            "coupler": components.coupler_command(self._options, path, endpoint, session, self._resume),
            "fluid": components.fluid_command(self._plan, path, endpoint, session),
            "body": components.body_command(self._plan, path, endpoint, session),
        }
        try:
            for name, command in commands.items():
                self._processes.append(
                    Process(
                        name,
                        command,
                        {**environment, components.COMPONENT: name},
                        path / "logs" / f"{name}.out",
                        events=writing_end if name == "coupler" else None,
                    )
                )
        except OSError as problem:
            raise Stop(
                exit_codes.BAD_CASE, f"{name} cannot be started ({problem}). Check this command: {shlex.join(command)}"
            ) from None
        finally:
            os.close(writing_end)
        return reading_end

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


def _stopped_by(number, options, directory):
    name = {2: "Ctrl-C", 15: "SIGTERM", 1: "SIGHUP"}[number]
    code = exit_codes.INTERRUPTED if number == 2 else exit_codes.TERMINATED
    return Stop(code, f"stopped by {name}. {_advice(code, options, directory)}")


def _advice(code, options, directory):
    """How to go on after a run that did not finish."""
    logs = f"Logs: {_shown(directory.path)}/logs."
    if code in (exit_codes.BAD_CASE, exit_codes.REFUSED, exit_codes.SOLVER_FAILED):
        return logs
    if directory.has_checkpoint():
        return f"{logs} Go on from the last checkpoint: {_resume_command(options, directory)}"
    return f"{logs} There is no checkpoint (see output.checkpoint in the case file): run again from the start."


def _resume_command(options, directory):
    words = [called_as(), "run", options.case, "--out", _shown(directory.path)]
    for setting in options.set:
        words += ["--set", setting]
    for name in ("ranks", "fluid", "body"):
        if getattr(options, name) is not None:
            words += [f"--{name}", str(getattr(options, name))]
    return shlex.join([*words, "--resume"])


def _shown(path):
    """Path relative to the current directory if that is shorter."""
    relative = os.path.relpath(path)
    return relative if len(relative) < len(str(path)) else str(Path(path))
