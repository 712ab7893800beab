"""Errors and exit codes, as in proto/contract/errors.hpp."""

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
    """The command line or the case demands something impossible."""

    code = ExitCode.BAD_CASE


class SolverError(ComponentError):
    """The solver cannot continue: it diverged or produced NaN."""


class StorageError(ComponentError):
    """A checkpoint could not be written or read."""

    code = ExitCode.STORAGE_FAILED


class Refused(ComponentError):
    """The coupler refused this component, or this component a message."""

    code = ExitCode.REFUSED


class DeadlinePassed(ComponentError):
    """An answer did not arrive in time."""

    code = ExitCode.DEADLINE_PASSED
