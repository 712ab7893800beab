"""Types of command-line arguments: each reads a text or reports what would be right."""

import argparse
import functools
import json
import math


def command(text: str) -> str:
    """Words of a command line, not empty."""
    if not text.strip():
        raise argparse.ArgumentTypeError("the command is empty (a variable that is not set?). Name a program.")
    return text


def hosts(text: str) -> str:
    """The setting of the case that the hosts between commas stand for."""
    return f"services.hosts={json.dumps(text.split(','))}"


def integer(text: str, least: int = 1, what: str = "number") -> int:
    """An integer from `least` on; `what`: what messages call it."""
    try:
        value = int(text)
    except ValueError:
        value = least - 1
    if value < least:
        raise argparse.ArgumentTypeError(
            f"«{text}» is not a valid {what} (integer ≥ {least}). Use {max(least, 1)}, for example."
        )
    return value


port = functools.partial(integer, least=0, what="port")
count = functools.partial(integer, least=0)
ranks = functools.partial(integer, what="rank count")


def real(text: str, what: str) -> float:
    """A number, zero or more; `what`: what messages call it, and how to write it."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 <= value < math.inf:
        raise argparse.ArgumentTypeError(f"«{text}» is not a valid {what}.")
    return value


metres = functools.partial(real, what="length (metres ≥ 0). Write 50e-6 for 50 µm")
tolerance = functools.partial(real, what="relative difference (number ≥ 0, such as 1e-9)")


def time(text: str) -> str:
    """«auto», «mean», «last» or the step of a snapshot."""
    if text not in ("auto", "mean", "last") and not text.isdecimal():
        raise argparse.ArgumentTypeError(f"«{text}» is not a time of the flow. Use mean, last or a step such as 14058.")
    return text
