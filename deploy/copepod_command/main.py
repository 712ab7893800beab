"""Runs one subcommand and turns its ending into exit code and last line."""

import os
import signal
import sys

from copepod_command import destinations, exit_codes
from copepod_command.command_line import parse
from copepod_command.errors import Stop
from copepod_command.stages import say


def main(arguments):
    """Exit code of the command."""
    signal.signal(signal.SIGTERM, _terminate)
    try:
        code = _carry_out(arguments)
        sys.stdout.flush()  # a full disk is noticed here, not when Python has ended
        return code
    except KeyboardInterrupt:
        say("stopped by Ctrl-C.")
        return exit_codes.INTERRUPTED
    except BrokenPipeError:  # the reader of our results went away, as in `copepod check … | head`
        _give_up_stdout()
        return exit_codes.PREPARATION_FAILED
    except OSError as problem:
        where = problem.filename or "the output"
        say(f"{where} cannot be used ({problem.strerror or problem}). {destinations.advice(problem)}")
        _give_up_stdout()
        return exit_codes.STORAGE_FAILED


def _carry_out(arguments):
    try:
        options = parse(arguments)
        return options.action(options)
    except Stop as stop:
        if stop.message:
            say(stop.message)
        return stop.code


def _give_up_stdout():
    """What could not be printed is forgotten; Python would complain about it once more at its end."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _terminate(number, frame):
    raise Stop(128 + number, "stopped by SIGTERM.")
