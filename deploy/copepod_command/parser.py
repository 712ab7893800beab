"""The command line that command_line.toml describes; types that read an argument or report what would be right."""

import argparse
import json
import math
import tomllib
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from copepod_run.checkout import called_as, version

_COMMANDS = Path(__file__).with_name("command_line.toml")
_Options = Mapping[str, Any]  # as there
_EXIT_CODES = """Exit codes:
  0 finished, 1 a build, test or conformance check failed, 2 bad case or command line,
  65 refused by the peer, 69 a component was lost, 70 a solver failed, 73 storage failed, 74 deadline passed,
  129/130/143 stopped by a signal"""


def _command(text: str) -> str:
    """Words of a command line, not empty."""
    if not text.strip():
        raise argparse.ArgumentTypeError("the command is empty (a variable that is not set?). Name a program.")
    return text


def _number(kind: type[int] | type[float], what: str, text: str, least: int = 0) -> float:
    """A number from `least` on; `what`: what messages call it, and how to write it."""
    try:
        value = kind(text)
    except ValueError:
        value = math.nan
    if not least <= value < math.inf:
        raise argparse.ArgumentTypeError(f"«{text}» is not a valid {what}.")
    return value


def _time(text: str) -> str:
    """«auto», «mean», «last» or the step of a snapshot."""
    if text not in ("auto", "mean", "last") and not text.isdecimal():
        raise argparse.ArgumentTypeError(f"«{text}» is not a time of the flow. Use mean, last or a step such as 14058.")
    return text


_TYPES: dict[str, Any] = {
    "command": _command,
    "count": partial(_number, int, "number (integer ≥ 0). Use 1, for example"),
    "hosts": lambda text: f"services.hosts={json.dumps(text.split(','))}",  # a setting of the case
    "integer": partial(_number, int, "number (integer ≥ 1). Use 1, for example", least=1),
    "metres": partial(_number, float, "length (metres ≥ 0). Write 50e-6 for 50 µm"),
    "port": partial(_number, int, "port (integer ≥ 0). Use 1, for example"),
    "ranks": partial(_number, int, "rank count (integer ≥ 1). Use 1, for example", least=1),
    "time": _time,
    "tolerance": partial(_number, float, "relative difference (number ≥ 0, such as 1e-9)"),
}


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
        epilog=_epilog(["run configs/quick/three_sphere.yaml", "run --help"]),
        formatter_class=_Formatter,
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version and exit")
    kind: Any = partial(argparse.ArgumentParser, formatter_class=_Formatter)
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND", parser_class=kind)
    texts = tomllib.loads(_COMMANDS.read_text())
    shared = texts.pop("shared")
    for name, command in texts.items():
        _add_command(commands, shared, name, **command)
    return parser


def _add_command(
    commands: Any,
    shared: _Options,
    name: str,
    options: _Options = {},
    groups: Mapping[str, dict[str, Any]] = {},
    needs_one: bool = False,
    action: str = "",
    defaults: Mapping[str, Any] = {},
    examples: Sequence[str] = (),
    usage: str = "",
    **texts: str,
) -> None:
    heading = f"{called_as()} {usage}" if usage else None
    parser = commands.add_parser(name, epilog=_epilog(examples) if examples else None, usage=heading, **texts)
    parser.set_defaults(action=action, **defaults)
    _add_options(parser, options, shared, needs_one)
    for title, group in groups.items():
        _add_options(parser.add_argument_group(title, group.pop("description", None)), group, shared)


def _add_options(parser: Any, options: _Options, shared: _Options, needs_one: bool = False) -> None:
    exclusive: Any = None
    for words, given in options.items():
        described = shared[words] if given is True else given
        settings = {"help": described} if isinstance(described, str) else dict(described)
        *names, last = words.split()
        if names and not last.startswith("-"):
            settings["metavar"] = last
        else:
            names.append(last)
            settings |= {} if "choices" in settings else {"action": "store_true"}
        if "type" in settings:
            settings["type"] = _TYPES[settings["type"]]
        if settings.pop("exclusive", False):
            exclusive = exclusive or parser.add_mutually_exclusive_group(required=needs_one)
            exclusive.add_argument(*names, **settings)
        else:
            parser.add_argument(*names, **settings)


def _epilog(examples: Sequence[str]) -> str:
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
