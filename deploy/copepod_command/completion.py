"""What a shell offers to complete a line: commands, options, files, and the keys of a case after --set."""

import argparse
import json
from collections.abc import Iterator
from importlib import import_module
from typing import Any

import argcomplete

from copepod_run.checkout import ROOT

_SCHEMA = ROOT / "configs" / "schema" / "case.schema.json"
_WITH_A_PARSER = {"conformance": "copepod_conformance.__main__", "recording": "copepod_recording.__main__"}


def answer(parser: argparse.ArgumentParser) -> None:
    """Answers the shell that asks, and ends."""
    commands = next(action.choices for action in parser._actions if isinstance(action, argparse._SubParsersAction))
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
