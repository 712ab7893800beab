"""Carries out a command line, and how each command ends."""

import argparse
import errno
import importlib
import os
import signal
import sys
import threading
from collections.abc import Sequence

from copepod_command.parser import make_parser
from copepod_run.errors import ExitCode, Stop
from copepod_run.messages import Voice, complain, say_lines, silence, speak

_TAKES_MORE = {"test": "ctest_arguments", "replay": "component"}  # what follows --
_ENDS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
# What to do about an OSError, by its number.
_ADVICE: dict[int | None, str] = {
    **dict.fromkeys((errno.ENOSPC, errno.EDQUOT), "Free space on that disk and run again."),
    **dict.fromkeys((errno.EACCES, errno.EPERM, errno.EROFS), "Use a place that you may write to, or ask its owner."),
    errno.EFBIG: "Raise the limit of the size of files (ulimit -f).",
}
_KIT_TOOLS = ("conformance", "recording", "python")  # tools with a command line of their own


def main(arguments: Sequence[str]) -> int:
    """Exit code of the command."""
    try:
        return _carry_out(arguments)
    except Stop as stop:
        if stop.errors:
            say_lines(stop.errors)
        if stop.message:
            complain(stop.message)
        return stop.code
    except KeyboardInterrupt:
        complain("stopped by Ctrl-C.")
        return ExitCode.INTERRUPTED
    except BrokenPipeError:  # the reader of our results has ended, as in `copepod check … | head`
        _flush_or_silence_stdout()
        return ExitCode.FAILED
    except OSError as problem:
        where = problem.filename or "the output"
        advice = _ADVICE.get(problem.errno, "Check that path, or use another one.")
        complain(f"{where} cannot be used ({problem.strerror or problem}). {advice}")
        _flush_or_silence_stdout()
        return ExitCode.STORAGE_FAILED


def _carry_out(arguments: Sequence[str]) -> int:
    try:
        _heed_signals()
        options = parse(arguments)
        if getattr(options, "quiet", False):
            speak(Voice.QUIET)
        if getattr(options, "progress", "auto") == "json":
            speak(Voice.JSON)
        module, _, function = options.action.partition(":")
        code: int = getattr(importlib.import_module(module), function)(options)
        sys.stdout.flush()  # a full disk is noticed here, not when Python has ended
        return code
    except RuntimeError as wrapped:  # as Python before 3.12 does where a class is being defined, as in an import
        if isinstance(wrapped.__cause__, (KeyboardInterrupt, Stop)):
            raise wrapped.__cause__ from None
        raise
    finally:  # Python, while it ends, would answer a signal by a traceback or by nothing
        signal.pthread_sigmask(signal.SIG_BLOCK, _ENDS)


def _flush_or_silence_stdout() -> None:
    try:
        sys.stdout.flush()
    except OSError:
        silence(sys.stdout)


def _heed_signals() -> None:
    """They end the command with a last line; deploy/copepod has blocked them so far. Ignored ones (nohup) stay so."""
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _terminate)
    sys.unraisablehook = _send_again
    signal.pthread_sigmask(signal.SIG_UNBLOCK, _ENDS)


def _send_again(lost: "sys.UnraisableHookArgs") -> None:
    """Python drops what a signal's handler raises while an object is destroyed: soon after, the signal comes again."""
    end = lost.exc_value
    number = signal.SIGINT if isinstance(end, KeyboardInterrupt) else end.code - 128 if isinstance(end, Stop) else 0
    if number > 0:
        threading.Timer(0.01, os.kill, (os.getpid(), number)).start()
    else:
        sys.__unraisablehook__(lost)


def _terminate(number: int, _: object) -> None:
    raise Stop(128 + number, f"stopped by {signal.Signals(number).name}.")


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """Options with `action`, «module:function» of what carries them out. Exits with 2 on a bad command line."""
    if arguments and arguments[0] in _KIT_TOOLS:
        return argparse.Namespace(action=f"copepod_command.kit_tools:{arguments[0]}", arguments=arguments[1:])
    place = arguments.index("--") if "--" in arguments else len(arguments)
    behind_dashes = arguments[place + 1 :]
    parser = make_parser()
    if "_ARGCOMPLETE" in os.environ:
        importlib.import_module("copepod_command.documentation").answer(parser)
    options = parser.parse_args(arguments[:place])
    if behind_dashes and options.command not in _TAKES_MORE:
        parser.error(f"{options.command} takes nothing after --")
    if options.command in _TAKES_MORE:
        setattr(options, _TAKES_MORE[options.command], behind_dashes)
    return options
