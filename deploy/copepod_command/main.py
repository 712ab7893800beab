"""Runs one subcommand and turns its ending into exit code and last line."""

import signal
import sys

from copepod_run import destinations
from copepod_command.command_line import parse
from copepod_run.errors import ExitCode, Stop
from copepod_run.messages import say, silence


def main(arguments):
    """Exit code of the command."""
    signal.signal(signal.SIGTERM, _terminate)
    try:
        code = _carry_out(arguments)
        sys.stdout.flush()  # a full disk is noticed here, not when Python has ended
        return code
    except KeyboardInterrupt:
        say("stopped by Ctrl-C.")
        return ExitCode.INTERRUPTED
    except BrokenPipeError:  # the reader of our results went away, as in `copepod check … | head`
        _flush_or_silence_stdout()
        return ExitCode.FAILED
    except OSError as problem:
        where = problem.filename or "the output"
        say(f"{where} cannot be used ({problem.strerror or problem}). {destinations.advice(problem)}")
        _flush_or_silence_stdout()
        return ExitCode.STORAGE_FAILED


def _carry_out(arguments):
    try:
        options = parse(arguments)
        return options.action(options)
    except Stop as stop:
        if stop.message:
            say(stop.message)
        return stop.code


def _flush_or_silence_stdout():
    try:
        sys.stdout.flush()
    except OSError:
        silence(sys.stdout)


def _terminate(number, frame):
    raise Stop(128 + number, "stopped by SIGTERM.")
