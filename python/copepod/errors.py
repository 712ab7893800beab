"""What goes wrong, as exceptions. Their texts read «problem (why). What to do.»"""

import importlib
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from copepod_run.errors import ExitCode, Stop


class Error(Exception):
    """Something cannot be done; `code` is the exit code of the command, see README."""

    def __init__(self, message: str, code: int = ExitCode.FAILED) -> None:
        super().__init__(message)
        self.code = code


class CaseError(Error):
    """A case or an argument is wrong; lists every error of the case with its key."""


class RunError(Error):
    """A run did not finish: a solver failed, a component was lost, a disk is full. `directory` holds what there is."""

    def __init__(self, message: str, code: int = ExitCode.FAILED, directory: str | None = None) -> None:
        super().__init__(message, code)
        self.directory = directory


class CaseWarning(UserWarning):
    """A case can run, but may not give what is expected of it."""


@contextmanager
def stops_as_errors() -> Iterator[None]:
    """Context that turns the exception which would end the command into one of ours."""
    try:
        yield
    except Stop as stop:
        kind = CaseError if stop.code == ExitCode.BAD_CASE else Error
        raise kind(str(stop).strip(), stop.code) from None


def required(module: str) -> Any:
    """A module that only Python's users need. Raises ImportError with the command that installs it."""
    try:
        return importlib.import_module(module)
    except ImportError as missing:
        package = f"python3-{module.partition('.')[0]}"
        raise ImportError(
            f"{module} cannot be imported ({missing}). Install it: sudo apt-get install -y {package}, or pip install "
            f"{package.removeprefix('python3-')} in a virtual environment."
        ) from missing
