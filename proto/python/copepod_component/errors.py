"""Errors and exit codes, as in proto/contract/errors.hpp and exit_code.hpp."""

import enum


class ExitCode(enum.IntEnum):
    FINISHED = 0
    BAD_CASE = 2
    REFUSED = 65
    COMPONENT_LOST = 69
    SOLVER_FAILED = 70
    STORAGE_FAILED = 73
    DEADLINE_PASSED = 74


class ComponentError(Exception):
    """Ends the run. The text reads "problem (why). What to do."."""

    code = ExitCode.SOLVER_FAILED


class CaseError(ComponentError):
    """The command line or the case asks for something impossible."""

    code = ExitCode.BAD_CASE


class SolverError(ComponentError):
    """The solver cannot go on: diverged, not a number."""


class StorageError(ComponentError):
    """A checkpoint could not be written or read."""

    code = ExitCode.STORAGE_FAILED


class Refused(ComponentError):
    """The coupler refused us, or we a message."""

    code = ExitCode.REFUSED


class DeadlinePassed(ComponentError):
    """Nobody answered in time."""

    code = ExitCode.DEADLINE_PASSED
