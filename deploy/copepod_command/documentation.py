"""`copepod completion` and `copepod man`: the command line for shells and for readers."""

import argparse
import json
import os
import shlex
import subprocess
import sys
import tempfile
from argparse import Namespace
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

from copepod_command.parser import make_parser
from copepod_run import packages
from copepod_run.checkout import PREFIX, ROOT, version
from copepod_run.errors import BadCase, ExitCode
from copepod_run.messages import is_utf8
from copepod_run.run_directory import make_folder

_SCHEMA = ROOT / "configs" / "schema" / "case.schema.json"
_WITH_A_PARSER = {"conformance": "copepod_conformance.__main__", "recording": "copepod_recording.__main__"}
# Every example is a paragraph of its own in a manual page.
_PROGRAM = """#!/bin/sh
{python} -P -m copepod_command "$@" | sed -e 's/^  copepod .*/&\\n/' -e 's/^usage:/Usage:/'
"""


def completion(options: Namespace) -> int:
    """Prints the script for a shell; it runs the command itself, so it completes the options of this version."""
    packages.require(("python3-argcomplete",), "they are needed for nothing else")
    import argcomplete

    prelude = "autoload -U +X bashcompinit && bashcompinit\n" if options.shell == "zsh" else ""
    print(prelude + argcomplete.shellcode(["copepod"], shell="fish" if options.shell == "fish" else "bash"))
    return ExitCode.FINISHED


def answer(parser: argparse.ArgumentParser) -> None:
    """Answers the shell that asks what completes a line: commands, options, files, keys of a case after --set."""
    import argcomplete

    commands = _commands(parser).choices
    for name, module in _WITH_A_PARSER.items():
        commands[name] = import_module(module).make_parser()
    for action in (action for command in commands.values() for action in command._actions):
        if "--set" in action.option_strings:
            setattr(action, "completer", lambda prefix, **_: list(keys(prefix)))
        elif action.dest == "page":
            setattr(action, "completer", lambda **_: list(commands))
    argcomplete.autocomplete(parser)


def keys(prefix: str) -> Iterator[str]:
    """Paths of the section that the text before the last dot names, «fluid.relaxation_time=»; items are 0, 1, …"""
    section: dict[str, Any] = json.loads(_SCHEMA.read_text())
    path, dot, _ = prefix.rpartition(".")
    for name in path.split(".") if path else []:
        items = _one_of(section, "items")
        section = items if items and name.isdigit() else _one_of(section, "properties").get(name, {})
    for name, schema in _one_of(section, "properties").items():
        has_keys = bool(_one_of(schema, "properties") or _one_of(schema, "items").get("properties"))
        may_be_a_word = any("enum" in each for each in schema.get("anyOf", ()))
        yield f"{path}{dot}{name}{'.' if has_keys and not may_be_a_word else '='}"
    if _one_of(section, "items"):
        yield f"{path}{dot}0."


def _one_of(schema: dict[str, Any], keyword: str) -> dict[str, Any]:
    """What the schema, or the first of its alternatives that has any, has of a keyword."""
    alternatives = (schema, *schema.get("anyOf", ()), *schema.get("oneOf", ()))
    return next((each[keyword] for each in alternatives if keyword in each), {})


def manual(options: Namespace) -> int:
    """Shows a page in the reader's pager, or writes all of them."""
    needed = ("help2man",) if options.out else ("man-db",) if PREFIX else ("help2man", "man-db")
    packages.require(needed, "they are needed for nothing else")
    lines = {action.dest: action.help or "" for action in _commands(make_parser())._choices_actions}
    summaries = {"": "couples fluids and rigid bodies", **lines}
    if options.page and options.page not in summaries:
        known = ", ".join(name for name in summaries if name)
        raise BadCase(f"there is no command «{options.page}». Choose one of: {known}.")
    if options.out:
        make_folder(Path(options.out))
        for name, summary in summaries.items():
            (Path(options.out) / f"{'-'.join(['copepod', name]).rstrip('-')}.1").write_text(_page(name, summary))
        print(f"{len(summaries)} pages in {options.out}")
        return ExitCode.FINISHED
    name = options.page or ""
    if PREFIX:
        return subprocess.run(["man", f"copepod-{name}".rstrip("-")]).returncode
    environment = {**os.environ, "LC_ALL": "C.UTF-8"} if is_utf8(sys.stdout) else None
    return subprocess.run(
        ["man", "-l", "-"], input=_page(name, summaries[name]), text=True, stdout=sys.stdout, env=environment
    ).returncode


def _commands(parser: argparse.ArgumentParser) -> Any:
    return next(action for action in parser._actions if isinstance(action, argparse._SubParsersAction))


def _page(name: str, summary: str) -> str:
    """The page of a command in the format of man, made from its --help."""
    with tempfile.TemporaryDirectory() as folder:
        script = Path(folder) / "copepod"
        script.write_text(_PROGRAM.format(python=shlex.quote(sys.executable)))
        script.chmod(0o700)
        words = ["--no-info", "--locale=C.UTF-8", "--name", summary, "--version-string", version()]
        command = ["help2man", *words, f"{script} {name}".rstrip()]
        environment = {**os.environ, "COPEPOD_CALLED_AS": "copepod", "COLUMNS": "1000"}
        text = subprocess.check_output(command, env=environment, text=True)
    if not name:
        return text
    text = text.replace(".TH COPEPOD ", f".TH COPEPOD-{name.upper()} ", 1)
    return text.replace(f"\ncopepod {name} \\-", f"\ncopepod-{name} \\-")  # what `man -k` finds
