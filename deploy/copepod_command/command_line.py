"""The command line: subcommands and their options."""

import argparse
import math

from copepod_campaign import campaign
from copepod_bench import bench
from copepod_command import check, conformance, recording, replay, report, run, setup, suite
from copepod_run.checkout import called_as

_EXIT_CODES = """exit codes: 0 finished, 2 bad case or command line, 65 refused by the peer, 69 a component was lost,
70 a solver failed, 73 storage failed, 74 deadline passed, 130/143 stopped by a signal"""

_TAKES_MORE = {"test": "ctest_arguments", "replay": "component"}  # what comes after --


def parse(arguments):
    """Options with `action` set to the function that carries them out. Exits with 2 on a bad command line."""
    if arguments[:1] in (["conformance"], ["recording"]):  # tools of the component kit with a command line of their own
        tool = conformance.conformance if arguments[0] == "conformance" else recording.recording
        return argparse.Namespace(action=tool, arguments=arguments[1:])
    arguments, behind_dashes = _split_at_dashes(arguments)
    parser = argparse.ArgumentParser(
        prog=called_as(), description="Couples fluids and rigid bodies: one command.", epilog=_EXIT_CODES
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    _add_run(commands)
    _add_check(commands)
    _add_campaign(commands)
    _add_report(commands)
    _add_bench(commands)
    _add_replay(commands)
    commands.add_parser("recording", help="list, count or draw what a run recorded")
    _add_test(commands)
    commands.add_parser("conformance", help="check a component against the protocol")
    _add_setup(commands)
    options = parser.parse_args(arguments)
    if behind_dashes and options.command not in _TAKES_MORE:
        parser.error(f"{options.command} takes nothing after --")
    if options.command in _TAKES_MORE:
        setattr(options, _TAKES_MORE[options.command], behind_dashes)
    return options


def _split_at_dashes(arguments):
    if "--" in arguments:
        place = arguments.index("--")
        return arguments[:place], arguments[place + 1 :]
    return arguments, []


def _add_run(commands):
    parser = commands.add_parser(
        "run",
        help="run a case",
        epilog=_EXIT_CODES,
        description="Runs a case: builds what is missing, starts and watches the three "
        "processes, ends with the result table.",
    )
    _add_case(parser)
    parser.add_argument(
        "--out", metavar="DIR", help="run directory (default: runs/<case>, with a number if that exists)"
    )
    parser.add_argument("--resume", action="store_true", help="go on with the run in --out, or with the case's latest")
    parser.add_argument(
        "--restarts",
        type=_count,
        default=0,
        metavar="N",
        help="start again up to N times when a component is lost (default: 0)",
    )
    parser.add_argument(
        "--progress",
        choices=("auto", "json"),
        default="auto",
        help="json: one JSON object per line on stderr, for programs; 'event' tells what it is (default: auto)",
    )
    parser.set_defaults(action=run.run)


def _add_check(commands):
    parser = commands.add_parser(
        "check",
        help="validate a case without running it",
        epilog=_EXIT_CODES,
        description="Checks a case and prints its key figures, estimates and warnings.",
    )
    _add_case(parser)
    parser.set_defaults(action=check.check)


def _add_campaign(commands):
    parser = commands.add_parser(
        "campaign",
        help="run a list of cases, going on where it stopped",
        epilog=_EXIT_CODES,
        description="Runs what is left to do of a campaign, several cases at once, and writes one result table. "
        "The same command again goes on: finished cases are kept, begun ones go on from their checkpoint.",
    )
    parser.add_argument("campaign", metavar="CAMPAIGN.yaml")
    parser.add_argument("--out", metavar="DIR", help="folder of the campaign (default: runs/<campaign>)")
    parser.add_argument("--jobs", type=_positive_count, metavar="N", help="cases at once (default: see the campaign)")
    parser.add_argument(
        "--rerun-other-builds",
        action="store_true",
        help="run cases again that another build of the programs has finished (default: keep them, and say so)",
    )
    parser.set_defaults(action=campaign.campaign)


def _add_case(parser):
    """The options that change what the case is."""
    parser.add_argument("case", metavar="CASE.yaml")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY.PATH=VALUE", help="change one key of the case"
    )
    parser.add_argument("--ranks", type=_ranks, metavar="N", help="MPI ranks of the fluid service")
    parser.add_argument("--fluid", type=_command, metavar="CMD", help="command that replaces the fluid service")
    parser.add_argument("--body", type=_command, metavar="CMD", help="command that replaces the body service")


def _add_report(commands):
    parser = commands.add_parser(
        "report",
        help="tables and plots from run directories",
        epilog=_EXIT_CODES,
        description="Writes report.html, one page that needs no network, and its plots as PNG.",
    )
    parser.add_argument("directories", nargs="+", metavar="DIR", help="run directory of a finished run")
    parser.add_argument(
        "--out", metavar="FOLDER", help="where to write (default: DIR/report, or report for several runs)"
    )
    parser.set_defaults(action=report.report)


def _add_bench(commands):
    parser = commands.add_parser(
        "bench",
        help="measure this machine",
        description="Measures memory, the fluid alone and coupled runs for a few minutes; prints a table.",
    )
    parser.add_argument(
        "--samples", type=_positive_count, default=5, metavar="N", help="of which medians are shown (5)"
    )
    parser.add_argument("--quick", action="store_true", help="the smallest domain only, for a first look")
    parser.add_argument(
        "--exchange", action="store_true", help="only the exchange between processes, beside a plain ZeroMQ echo"
    )
    parser.add_argument("--out", metavar="FILE.json", help="write every sample there")
    parser.set_defaults(action=bench.bench)


def _add_replay(commands):
    parser = commands.add_parser(
        "replay",
        help="replay a recorded run against a component",
        usage=f"{called_as()} replay RUN_DIR (--fluid | --body | --as ROLE) [options] [-- CMD …]",
        description="Plays the coupler of a run that was recorded with output.wire to a real component, the one that "
        "CMD starts or the one that was recorded, and compares its replies; or (--as) runs the case again with one component replaced by "
        "what it said. Ends with 0 if nothing differs.",
    )
    parser.add_argument("directory", metavar="RUN_DIR")
    which = parser.add_mutually_exclusive_group(required=True)
    which.add_argument("--fluid", action="store_true", help="to a fluid component")
    which.add_argument("--body", action="store_true", help="to a body component")
    which.add_argument("--as", dest="stand_in", choices=("fluid", "body"), help="play this component to a real coupler")
    parser.add_argument(
        "--tolerance", type=_tolerance, default=0.0, metavar="X", help="relative; default 0: every bit counts"
    )
    parser.add_argument("--ranks", type=_ranks, default=1, metavar="N", help="MPI ranks of our fluid (1)")
    parser.add_argument("--attempt", type=_positive_count, metavar="N", help="of a resumed run (default: the last)")
    parser.add_argument(
        "--out",
        metavar="DIR",
        help="with --as: run directory of the new run (default: none is kept, unless the run fails)",
    )
    parser.set_defaults(action=replay.replay)


def _add_test(commands):
    parser = commands.add_parser(
        "test",
        help="build and run the test suite",
        usage=f"{called_as()} test [-- CTEST ARGS]",
        description="Builds everything and runs ctest; arguments after -- go to ctest, for example: -- -L unit",
    )
    parser.set_defaults(action=suite.test)


def _add_setup(commands):
    parser = commands.add_parser("setup", help="install packages and build, nothing else")
    parser.add_argument("--ci", action="store_true", help="also what .ci/run needs: clang-format, clang-tidy, gcovr")
    parser.add_argument("--packages-only", action="store_true", help="do not build")
    parser.set_defaults(action=setup.setup)


def _command(text):
    if not text.strip():
        raise argparse.ArgumentTypeError("the command is empty (a variable that is not set?). Name a program.")
    return text


def _count(text):
    return _whole_number(text, least=0)


def _positive_count(text):
    return _whole_number(text, least=1)


def _ranks(text):
    return _whole_number(text, least=1, of=" of ranks")


def _whole_number(text, least, of=""):
    try:
        value = int(text)
    except ValueError:
        value = least - 1
    if value < least:
        raise argparse.ArgumentTypeError(
            f"{text} is no number{of} (whole, from {least} on). Use {max(least, 1)}, for example."
        )
    return value


def _tolerance(text):
    return _number(text, lambda value: 0 <= value < math.inf, "no relative difference (a number from 0 on, as 1e-9)")


def _number(text, is_fine, otherwise):
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not is_fine(value):
        raise argparse.ArgumentTypeError(f"«{text}» is {otherwise}.")
    return value
