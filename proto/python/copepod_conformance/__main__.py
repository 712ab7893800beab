"""Checks a component against the protocol: python3 -m copepod_conformance --role fluid -- CMD…"""

import argparse
import math
import os
import shlex
import shutil
import signal
import sys
import tempfile
import time
import uuid
from pathlib import Path

_JOBS_PER_CORE = 2  # components mostly wait
_NOT_CONFORMANT, _BAD_COMMAND, _STORAGE_FAILED, _INTERRUPTED, _TERMINATED = 1, 2, 73, 130, 143


def main():
    """Prints the table, writes JUnit XML to --junit; exit code 0 only if no check failed."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(_TERMINATED))
    try:
        options = _options(sys.argv[1:])
        with tempfile.TemporaryDirectory(prefix="copepod-conformance-") as folder:
            return _check(options, folder)
    except KeyboardInterrupt:
        return _INTERRUPTED


def make_parser():
    """Of what stands before --."""
    parser = argparse.ArgumentParser(
        prog=called_as("conformance"),
        usage="%(prog)s --role fluid|body|controller [options] -- CMD…",
        description="Plays the coupler of a component, in many short runs, and compares what it does with "
        "docs/protocol.md. Exit code 0: conformant, 1: not, 2: CMD is not a component, or the command line is wrong.",
    )
    parser.add_argument("--role", required=True, choices=["fluid", "body", "controller"])
    parser.add_argument(
        "--solver",
        choices=["lattice_boltzmann", "stokes", "vacuum", "external"],
        help="solver of the fluid to be tested (default: the first that it announces)",
    )
    parser.add_argument("--quick", action="store_true", help="leave out checks that closely resemble others")
    parser.add_argument("--only", action="append", metavar="GROUP", help="only this group of checks; may be repeated")
    parser.add_argument("--junit", metavar="FILE", help="write the results as JUnit XML")
    parser.add_argument("--verbose", action="store_true", help="list every check, not only those that failed")
    count, seconds = number_type(int, 1, "positive number"), number_type(float, sys.float_info.min, "positive number")
    parser.add_argument("--jobs", type=count, metavar="N", help="components at a time (default: 2 per core)")
    parser.add_argument(
        "--patience", type=seconds, default=20.0, metavar="SECONDS", help="longest wait for an answer (default: 20)"
    )
    return parser


def _options(arguments):
    parser = make_parser()
    place = arguments.index("--") if "--" in arguments else len(arguments)
    options = parser.parse_args(arguments[:place])
    options.command = arguments[place + 1 :]
    if not options.command:
        end("No component is named. Give its command after --, for example: --role fluid -- ./my_fluid")
    if shutil.which(options.command[0]) is None:
        end(
            f"The {options.role} component {shlex.join(options.command)} cannot be started (no such program). "
            "Give its path, or put it in PATH."
        )
    if options.junit and not os.access(Path(options.junit).resolve().parent, os.W_OK):
        problem = f"{options.junit} cannot be written (its folder is missing or read-only). Choose another --junit."
        end(problem, _STORAGE_FAILED)
    return options


def end(problem, code=_BAD_COMMAND):
    """Ends a tool of the kit with a message «problem (why). What to do.»"""
    print(f"error: {problem}", file=sys.stderr)
    sys.exit(code)


def called_as(tool):
    """How the user started a tool of the kit: by the deploy command or by Python."""
    deploy = os.environ.get("COPEPOD_CALLED_AS")
    return f"{deploy} {tool}" if deploy else f"python3 -m copepod_{tool}"


def _check(options, folder):
    import zmq  # late: --help and wrong options are answered before packages are installed and messages generated

    from copepod_component.errors import CaseError
    from copepod_conformance.subject import Subject
    from copepod_conformance.suite import GROUPS, SUITE, Suite, all_checks, counts, junit, table

    groups = set(options.only or GROUPS)
    if unknown := groups - set(GROUPS):
        end(f"Unknown group of checks: {', '.join(unknown)}. Choose from: {', '.join(GROUPS)}.")
    environment = {**os.environ, SUITE: uuid.uuid4().hex}
    with zmq.Context() as context:
        try:
            subject = Subject(options, environment, folder, context)
        except CaseError as error:
            end(error)
        checks = [
            each for each in all_checks(subject) if each.group in groups and not (options.quick and each.thorough)
        ]
        start = time.monotonic()
        jobs = options.jobs or _JOBS_PER_CORE * len(os.sched_getaffinity(0))
        results = Suite(subject, checks, jobs, _show_progress).run()
    print(table(subject, results, options.verbose))
    if options.junit:
        Path(options.junit).write_bytes(junit(subject, results, time.monotonic() - start))
    return _NOT_CONFORMANT if counts(results)["failed"] else 0


def _show_progress(done, total):
    if sys.stderr.isatty():
        print(f"\r{done} of {total} checks", end="\n" if done == total else "", file=sys.stderr, flush=True)


def number_type(kind, least, what):
    """Type of an argument: int or float, from `least` on."""

    def read(text):
        try:
            value = kind(text)
        except ValueError:
            value = math.nan
        if not least <= value < math.inf:
            raise argparse.ArgumentTypeError(f"'{text}' is not a {what}.")
        return value

    return read


if __name__ == "__main__":
    sys.exit(main())
