"""The command line: subcommands and their options, with the texts of --help; types that read an argument or report what
would be right."""

import argparse
import json
import math
from functools import partial
from typing import Any

from copepod_run.checkout import called_as, version

_EXIT_CODES = """Exit codes:
  0 finished, 1 a build, test or conformance check failed, 2 bad case or command line,
  65 refused by the peer, 69 a component was lost, 70 a solver failed, 73 storage failed, 74 deadline passed,
  129/130/143 stopped by a signal"""


def _command(text: str) -> str:
    """Words of a command line, not empty."""
    if not text.strip():
        raise argparse.ArgumentTypeError("the command is empty (a variable that is not set?). Name a program.")
    return text


def _hosts(text: str) -> str:
    """The setting of the case that the hosts between commas stand for."""
    return f"services.hosts={json.dumps(text.split(','))}"


def _number(kind: type[int] | type[float], what: str, text: str, least: int = 0) -> float:
    """A number from `least` on; `what`: what messages call it, and how to write it."""
    try:
        value = kind(text)
    except ValueError:
        value = math.nan
    if not least <= value < math.inf:
        raise argparse.ArgumentTypeError(f"«{text}» is not a valid {what}.")
    return value


_integer = partial(_number, int, "number (integer ≥ 1). Use 1, for example", least=1)
_port = partial(_number, int, "port (integer ≥ 0). Use 1, for example")
_count = partial(_number, int, "number (integer ≥ 0). Use 1, for example")
_ranks = partial(_number, int, "rank count (integer ≥ 1). Use 1, for example", least=1)
_metres = partial(_number, float, "length (metres ≥ 0). Write 50e-6 for 50 µm")
_tolerance = partial(_number, float, "relative difference (number ≥ 0, such as 1e-9)")


def _time(text: str) -> str:
    """«auto», «mean», «last» or the step of a snapshot."""
    if text not in ("auto", "mean", "last") and not text.isdecimal():
        raise argparse.ArgumentTypeError(f"«{text}» is not a time of the flow. Use mean, last or a step such as 14058.")
    return text


class _Version(argparse.Action):
    """Looks for the version only when it is asked for."""

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        print(f"copepod {version()}")
        parser.exit()


def make_parser() -> argparse.ArgumentParser:
    """The parser of all commands but for what follows --."""
    parser = argparse.ArgumentParser(
        prog=called_as(),
        description="Couples fluids and rigid bodies: one command.",
        epilog=_epilog("run configs/quick/three_sphere.yaml", "run --help"),
        formatter_class=_Formatter,
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version and exit")
    kind: Any = partial(argparse.ArgumentParser, formatter_class=_Formatter)
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND", parser_class=kind)
    for add_to in (
        *(_add_run, _add_check, _add_campaign, _add_report, _add_export, _add_watch, _add_validate),
        *(_add_bench, _add_replay, _add_tools),
    ):
        add_to(commands)
    return parser


def _epilog(*examples: str) -> str:
    """Examples, and how every command ends."""
    return "Examples:\n" + "".join(f"  {called_as()} {example}\n" for example in examples) + "\n" + _EXIT_CODES


class _Formatter(argparse.HelpFormatter):
    """Wraps texts, and leaves those with line breaks of their own as they are. Headings as manual pages have them."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        return text if "\n" in text else super()._fill_text(text, width, indent)

    def add_usage(self, usage: Any, actions: Any, groups: Any, prefix: str | None = None) -> None:
        super().add_usage(usage, actions, groups, "Usage: " if prefix is None else prefix)

    def start_section(self, heading: str | None) -> None:
        super().start_section({"positional arguments": "Arguments", "options": "Options"}.get(heading or "", heading))


def _add(parser: argparse._ActionsContainer, words: str, text: str, **settings: Any) -> None:
    """An option, with its value if it takes one: «--out DIR»; `text`: what it does."""
    *names, last = words.split()
    if last.startswith("-"):
        parser.add_argument(*names, last, help=text, action="store_true")
    else:
        parser.add_argument(*names, metavar=last, help=text, **settings)


def _add_output(parser: argparse.ArgumentParser, what: str) -> None:
    _add(parser, "-q --quiet", "only errors on stderr: no progress, no warnings")
    _add(parser, "--json", f"{what} as JSON on stdout")


_Commands = argparse._SubParsersAction  # argparse has no public name for it


def _add_run(commands: _Commands) -> None:
    parser = commands.add_parser(
        "run",
        help="run a case",
        epilog=_epilog(
            "run configs/quick/three_sphere.yaml",
            "run case.yaml --set fluid.relaxation_time=0.8 --ranks 2 --out runs/coarse",
            "run case.yaml --out runs/coarse --resume",
        ),
        description="Runs a case: builds what is missing, starts and watches the three processes, and prints the "
        "result table.",
    )
    _add_case(parser)
    _add(parser, "--out DIR", "run directory (default: runs/<case>, with a number if that exists)")
    beginning = parser.add_mutually_exclusive_group()
    _add(beginning, "--resume", "continue the run in --out, or the case's latest run")
    _add(
        beginning,
        "--branch-from DIR[:STEP]",
        "start this case, in a new folder, from a checkpoint of the run in DIR (default: its newest)",
    )
    _add(
        parser,
        "--restarts N",
        "start again up to N times when a component is lost (default: 0)",
        type=_count,
        default=0,
    )
    parser.add_argument(
        "--progress",
        choices=("auto", "json"),
        default="auto",
        help="json: one JSON object per line on stderr, for programs; 'event' is its kind (default: auto)",
    )
    _add_keep_going(parser)
    _add_output(parser, "summary.json with the run directory")
    parser.set_defaults(action="copepod_command.run:run", rerun_other_builds=False)


def _add_check(commands: _Commands) -> None:
    parser = commands.add_parser(
        "check",
        help="validate a case or campaign without running it",
        epilog=_epilog("check case.yaml", "check case.yaml --set run.steps=1000 --json", "check campaign.yaml"),
        description="Checks a case, every member of a sweep or every case of a campaign, and prints key figures, "
        "estimates and warnings. Nothing that a case names is started.",
    )
    _add_case(parser)
    _add(
        parser,
        "--start-components",
        "ask the components that the case names what they can do and need, which starts their commands",
    )
    _add_output(parser, "figures, estimates, warnings and problems")
    parser.set_defaults(action="copepod_command.actions:check")


def _add_campaign(commands: _Commands) -> None:
    parser = commands.add_parser(
        "campaign",
        help="run a list of cases, or continue where it stopped",
        epilog=_epilog("campaign configs/paper/campaign.yaml --jobs 2"),
        description="Runs the remaining cases of a campaign, several at once, and writes one result table. Repeat the "
        "command to continue: finished cases are kept, interrupted ones resume from their checkpoints.",
    )
    parser.add_argument("case", metavar="CAMPAIGN.yaml")
    _add(parser, "--set KEY.PATH=VALUE", "change one key of every case", action="append", default=[])
    _add(parser, "--out DIR", "folder of the campaign (default: runs/<campaign>)")
    _add(parser, "--jobs N", "cases at once (default: see the campaign)", type=_integer)
    _add(
        parser,
        "--rerun-other-builds",
        "run cases again that another build of the programs has finished (default: keep and list them)",
    )
    _add_keep_going(parser)
    _add_output(parser, "results.json")
    parser.set_defaults(action="copepod_campaign.campaign:campaign")


def _add_keep_going(parser: argparse.ArgumentParser) -> None:
    _add(parser, "--keep-going", "start every case, also when the first three of a sweep or campaign fail alike")


def _add_case(parser: argparse.ArgumentParser) -> None:
    """The options that change what the case is."""
    parser.add_argument("case", metavar="CASE.yaml")
    _add(parser, "--set KEY.PATH=VALUE", "change one key of the case", action="append", default=[])
    _add(parser, "--ranks N", "MPI ranks of the fluid service", type=_ranks)
    _add(
        parser,
        "--hosts A,B:N,…",
        "hosts and their ranks of the fluid (default: 1 each); the first one is this machine",
        type=_hosts,
        action="append",
        dest="set",
    )
    _add(parser, "--fluid CMD", "command that replaces the fluid service", type=_command)
    _add(parser, "--body CMD", "command that replaces the body service", type=_command)


def _add_report(commands: _Commands) -> None:
    parser = commands.add_parser(
        "report",
        help="tables and plots from run directories",
        epilog=_epilog(
            "report runs/three_sphere",
            "report runs/coarse runs/fine --out comparison",
            "report runs/three_sphere --format pdf svg --plane xz --at 24e-6 --time 12000",
            "report runs/three_sphere --zoom swimmer --frame B1",
        ),
        description="Writes report.html, a page that needs no network, and its plots as files.",
    )
    parser.add_argument("directories", nargs="+", metavar="DIR", help="run directory, also of an unfinished run")
    _add(parser, "--out FOLDER", "where to write (default: DIR/report; several runs: report)")
    _add(
        parser,
        "--format FORMAT",
        "of the plots' files: png, svg, pdf; several are allowed (default: png)",
        nargs="+",
        choices=("png", "svg", "pdf"),
        default=["png"],
    )
    _add(parser, "--video", "also the flow as a film, RUN_flow.mp4, of runs with snapshots (needs Debian's ffmpeg)")
    sweep = parser.add_argument_group("first figure of a sweep")
    _add(sweep, "--x KEY", "swept key, or its end (default: that of most values)", default="")
    _add(sweep, "--y FIGURE", "column of the table (default: the swimming speed)", default="")
    flow = parser.add_argument_group("picture of the flow", "of runs that recorded one (output.fields)")
    planes = ("auto", "xy", "xz", "yz", "yx", "zx", "zy")
    _add(
        flow,
        "--plane AXES",
        "xy, xz, yz, …: two axes, the horizontal one first (default: the plane that contains the motion)",
        choices=planes,
        default="auto",
    )
    _add(
        flow,
        "--at METRES",
        "where the plane is along its normal (default: through the first swimmer or body, else the middle)",
        type=_metres,
    )
    _add(
        flow,
        "--time TIME",
        "mean, last or the step of a snapshot (default: the mean if there is one, else the last snapshot)",
        type=_time,
        default="auto",
    )
    _add(flow, "--zoom NAME", "around this swimmer or body (default: everything)", default="")
    _add(flow, "--margin METRES", "with --zoom: beyond its surface (default: half its length)", type=_metres)
    _add(
        flow,
        "--frame NAME",
        "subtract the velocity of this swimmer or body (default: the laboratory frame)",
        default="",
    )
    parser.set_defaults(action="copepod_command.actions:report")


def _add_export(commands: _Commands) -> None:
    parser = commands.add_parser(
        "export",
        help="a finished run as an RO-Crate, for an archive",
        epilog=_epilog("export runs/three_sphere --author 'Ada Lovelace' --license CC-BY-4.0"),
        description="Copies case, provenance, results and report into a folder with checksums and a description that "
        "machines read (RO-Crate 1.1); `run` of its case.yaml repeats the run. Checkpoints and logs stay behind.",
    )
    parser.add_argument("directory", metavar="DIR", help="directory of a finished run")
    _add(parser, "--author NAME", "who made the run", required=True)
    _add(parser, "--license LICENSE", "of the exported files: an SPDX identifier or a URL", required=True)
    _add(parser, "--out FOLDER", "new folder (default: DIR.crate)")
    parser.set_defaults(action="copepod_command.actions:export")


def _add_watch(commands: _Commands) -> None:
    parser = commands.add_parser(
        "watch",
        help="a live page of a run",
        epilog=_epilog("watch runs/three_sphere", "watch runs/three_sphere --port 8000"),
        description="Serves a page that shows a run while it continues: progress, time left, speeds cycle by cycle and "
        "the moving bodies in 3-D; at its end also the report. Prints the address, which only this machine can open, "
        "and stays until Ctrl-C. For a campaign, the page lists its runs.",
    )
    parser.add_argument("directory", metavar="DIR", help="run directory, or folder of a campaign")
    _add(parser, "--port N", "port (default: a free one)", type=_port, default=0)
    parser.set_defaults(action="copepod_command.actions:watch")


def _add_validate(commands: _Commands) -> None:
    parser = commands.add_parser(
        "validate",
        help="measure the accuracy of the schemes against theory",
        epilog=_epilog("validate --fast", "validate --cases sphere_array --schemes parabolic"),
        description="Runs experiments with a reference for every scheme at the surfaces of bodies, several at once, "
        "and writes accuracy.md with its figures. Runs are kept in runs/validation: repeat the command to continue, or "
        "to make the page of other cases and schemes; only runs of another build are repeated. With --all every "
        "combination of schemes that `check` admits runs beside the most accurate one, and the page is all_schemes.md.",
    )
    _add(parser, "--all", "every combination of schemes, for all_schemes.md")
    _add(parser, "--cases CASE", "experiments (default: all; an unknown one lists them)", nargs="+")
    _add(parser, "--schemes SCHEME", "schemes (default: all)", nargs="+")
    _add(parser, "--fast", "a few points of each case, or a few combinations")
    _add(parser, "--fluid CMD", "command that replaces the fluid service", type=_command)
    _add(parser, "--jobs N", "runs at once (default: one per core)", type=_integer)
    _add(parser, "--out FOLDER", "where to write (default: docs/results of the checkout)")
    parser.set_defaults(action="copepod_command.actions:validate", json=False)


def _add_bench(commands: _Commands) -> None:
    parser = commands.add_parser(
        "bench",
        epilog=_epilog("bench --quick"),
        help="measure this machine",
        description="Measures memory, the fluid alone and coupled runs for a few minutes; prints a table.",
    )
    _add(parser, "--samples N", "samples per median (default: 5)", type=_integer, default=5)
    _add(parser, "--quick", "the smallest domain only, for a first look")
    _add(parser, "--exchange", "only the exchange between processes, beside a plain ZeroMQ echo")
    _add(parser, "--out FILE.json", "write every sample there")
    parser.set_defaults(action="copepod_bench.bench:bench")


def _add_replay(commands: _Commands) -> None:
    parser = commands.add_parser(
        "replay",
        epilog=_epilog("replay runs/quick --body -- ./my_body_component", "replay runs/quick --as fluid"),
        help="replay a recorded run against a component",
        usage=f"{called_as()} replay RUN_DIR (--fluid | --body | --controller NAME | --as ROLE) [options] [-- CMD …]",
        description="Replays the coupler of a run recorded with output.wire to a component, the one that CMD starts or "
        "the recorded one, and compares the replies; or (--as) runs the case again with one component replaced by its "
        "recording. Exit code 0: nothing differs.",
    )
    parser.add_argument("directory", metavar="RUN_DIR")
    which = parser.add_mutually_exclusive_group(required=True)
    _add(which, "--fluid", "to a fluid component")
    _add(which, "--body", "to a body component")
    _add(which, "--controller NAME", "to the controller of this name")
    _add(which, "--as ROLE", "play fluid, body, or a controller by its name to a real coupler", dest="stand_in")
    _add(parser, "--tolerance X", "relative difference allowed (default: 0)", type=_tolerance, default=0.0)
    _add(parser, "--ranks N", "MPI ranks of our fluid (default: 1)", type=_ranks, default=1)
    _add(parser, "--attempt N", "of a resumed run (default: the last)", type=_integer)
    _add(parser, "--out DIR", "with --as: keep the new run in this directory")
    parser.set_defaults(action="copepod_command.kit_tools:replay")


def _add_tools(commands: _Commands) -> None:
    commands.add_parser("python", help="run Python, or a script, with `import copepod`")
    commands.add_parser("recording", help="list, count or draw what a run recorded")
    parser = commands.add_parser(
        "test",
        epilog=_epilog("test", "test -- -L unit"),
        help="build and run the test suite",
        usage=f"{called_as()} test [-- CTEST ARGS]",
        description="Builds everything and runs ctest; arguments after -- are ctest's, for example: -- -L unit",
    )
    parser.set_defaults(action="copepod_command.actions:test")
    commands.add_parser("conformance", help="check a component against the protocol")
    parser = commands.add_parser("setup", help="install packages and build, nothing else")
    _add(parser, "--ci", "also the packages of .ci/run: clang-tidy, black, gcovr, …")
    _add(parser, "--packages-only", "do not build")
    parser.set_defaults(action="copepod_command.actions:setup")
    parser = commands.add_parser(
        "completion",
        help="completion of this command for a shell",
        epilog=_epilog("completion bash > /etc/bash_completion.d/copepod", "completion fish | source"),
        description="Prints the script with which a shell completes commands, options and files. For one session: "
        'eval "$(copepod completion bash)".',
    )
    parser.add_argument("shell", choices=("bash", "zsh", "fish"))
    parser.set_defaults(action="copepod_command.documentation:completion")
    parser = commands.add_parser(
        "man",
        help="manual pages",
        epilog=_epilog("man run", "man --out /usr/local/share/man/man1"),
        description="Shows the manual page of the command or of one of its subcommands, or writes all of them.",
    )
    parser.add_argument("page", nargs="?", metavar="COMMAND", help="subcommand (default: the page of copepod)")
    _add(parser, "--out FOLDER", "write copepod.1, copepod-run.1, … there")
    parser.set_defaults(action="copepod_command.documentation:manual")
