"""Runs one subcommand and turns its ending into exit code and last line."""

import os
import signal
import sys

from copepod_command import exit_codes
from copepod_command.command_line import parse
from copepod_command.errors import Stop
from copepod_command.stages import say


def main(arguments):
    """Exit code of the command."""
    signal.signal(signal.SIGTERM, _terminate)
    options = parse(arguments)
    try:
        return options.action(options)
    except Stop as stop:
        if stop.message:
            say(stop.message)
        return stop.code
    except KeyboardInterrupt:
        say("stopped by Ctrl-C.")
        return exit_codes.INTERRUPTED
    except BrokenPipeError:  # the reader of our results went away, as in `copepod check … | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return exit_codes.PREPARATION_FAILED


def _terminate(number, frame):
    raise Stop(128 + number, "stopped by SIGTERM.")
