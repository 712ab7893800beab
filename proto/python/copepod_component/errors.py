"""Errors and exit codes, as in proto/contract/errors.hpp."""

import enum


class ExitCode(enum.IntEnum):
    """Exit codes of a component."""

    FINISHED = 0  #: the run has ended well
    BAD_CASE = 2  #: bad case or command line
    REFUSED = 65  #: refused by the peer, or the peer by it
    COMPONENT_LOST = 69  #: the coupler is gone
    SOLVER_FAILED = 70  #: diverged, NaN
    STORAGE_FAILED = 73  #: a checkpoint could not be written or read
    DEADLINE_PASSED = 74  #: no answer came in time


class ComponentError(Exception):
    """Ends the run. The text reads "problem (why). What to do."."""

    code = ExitCode.SOLVER_FAILED  #: of the process


class CaseError(ComponentError):
    """The command line or the case demands something impossible."""

    code = ExitCode.BAD_CASE  #: of the process


class SolverError(ComponentError):
    """The solver cannot continue: it diverged or produced NaN."""


class StorageError(ComponentError):
    """A checkpoint could not be written or read."""

    code = ExitCode.STORAGE_FAILED  #: of the process


class Refused(ComponentError):
    """The coupler refused this component, or this component a message."""

    code = ExitCode.REFUSED  #: of the process


class DeadlinePassed(ComponentError):
    """An answer did not arrive in time."""

    code = ExitCode.DEADLINE_PASSED  #: of the process
