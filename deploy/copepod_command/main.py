"""Runs one subcommand and turns its ending into exit code and last line."""

import signal
import sys

from copepod_command import exit_codes
from copepod_command.command_line import parse
from copepod_command.errors import Stop


def main(arguments):
    """Exit code of the command."""
    signal.signal(signal.SIGTERM, _terminate)
    options = parse(arguments)
    try:
        return options.action(options)
    except Stop as stop:
        if stop.message:
            print(f"copepod: {stop.message}", file=sys.stderr, flush=True)
        return stop.code
    except KeyboardInterrupt:
        print("\ncopepod: stopped by Ctrl-C.", file=sys.stderr, flush=True)
        return exit_codes.INTERRUPTED
    except BrokenPipeError:  # the reader of our output went away, as in `copepod check … | head`
        sys.stderr.close()
        return exit_codes.FINISHED


def _terminate(number, frame):
    raise Stop(128 + number, "stopped by SIGTERM.")
