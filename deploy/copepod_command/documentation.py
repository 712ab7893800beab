"""`copepod completion` and `copepod man`: the command line for shells and for readers."""

import argparse
import os
import shlex
import subprocess
import sys
import tempfile
from argparse import Namespace
from pathlib import Path

from copepod_run import packages
from copepod_run.checkout import version
from copepod_run.destinations import make_folder
from copepod_run.errors import ExitCode, Stop
from copepod_run.messages import is_utf8

# Every example is a paragraph of its own in a manual page.
_PROGRAM = """#!/bin/sh
{python} -P -m copepod_command "$@" | sed 's/^  copepod .*/&\\n/'
"""


def completion(options: Namespace) -> int:
    """Prints the script for a shell; it runs the command itself, so it completes the options of this version."""
    packages.require(("python3-argcomplete",), "they are needed for nothing else")
    import argcomplete

    prelude = "autoload -U +X bashcompinit && bashcompinit\n" if options.shell == "zsh" else ""
    shell = "fish" if options.shell == "fish" else "bash"
    print(prelude + argcomplete.shellcode(["copepod"], shell=shell))
    return ExitCode.FINISHED


def manual(options: Namespace) -> int:
    """Shows a page in the reader's pager, or writes all of them."""
    packages.require(("help2man", "man-db"), "they are needed for nothing else")
    summaries = _summaries()
    if options.page and options.page not in summaries:
        known = ", ".join(name for name in summaries if name)
        raise Stop(ExitCode.BAD_CASE, f"there is no command «{options.page}». Choose one of: {known}.")
    if options.out:
        make_folder(Path(options.out))
        for name, summary in summaries.items():
            (Path(options.out) / f"{'-'.join(['copepod', name]).rstrip('-')}.1").write_text(_page(name, summary))
        print(f"{len(summaries)} pages in {options.out}")
        return ExitCode.FINISHED
    name = options.page or ""
    environment = {**os.environ, "LC_ALL": "C.UTF-8"} if is_utf8(sys.stdout) else None
    return subprocess.run(
        ["man", "-l", "-"], input=_page(name, summaries[name]), text=True, stdout=sys.stdout, env=environment
    ).returncode


def _summaries() -> dict[str, str]:
    """A line about the command, "", and about each of its commands."""
    from copepod_command.parser import make_parser

    commands = next(action for action in make_parser()._actions if isinstance(action, argparse._SubParsersAction))
    lines = {action.dest: action.help or "" for action in commands._choices_actions}
    return {"": "couples fluids and rigid bodies", **lines}


def _page(name: str, summary: str) -> str:
    """The page of a command in the format of man, made from its --help."""
    with tempfile.TemporaryDirectory() as folder:
        script = Path(folder) / "copepod"
        script.write_text(_PROGRAM.format(python=shlex.quote(sys.executable)))
        script.chmod(0o700)
        made = subprocess.run(
            [
                "help2man",
                "--no-info",
                "--locale=C.UTF-8",
                "--name",
                summary,
                "--version-string",
                version(),
                f"{script} {name}".rstrip(),
            ],
            env={**os.environ, "COPEPOD_CALLED_AS": "copepod", "COLUMNS": "1000"},
            stdout=subprocess.PIPE,
            text=True,
            check=True,
        )
    return made.stdout
