"""Exit codes of every Copepod process, and the exceptions that end the command with a message of ours."""

import enum


class ExitCode(enum.IntEnum):
    """The same numbers as in proto/contract/errors.hpp."""

    FINISHED = 0
    FAILED = 1  # of this command alone: the build failed, or a component is not conformant
    BAD_CASE = 2  # bad case file or command line, missing packages
    REFUSED = 65  # refused by the peer: version, role, key, capability
    COMPONENT_LOST = 69  # a component died, froze or hung
    SOLVER_FAILED = 70  # diverged, NaN
    STORAGE_FAILED = 73  # output or checkpoint could not be written or read
    DEADLINE_PASSED = 74  # no answer in time
    HUNG_UP = 129  # SIGHUP
    INTERRUPTED = 130  # SIGINT
    TERMINATED = 143  # SIGTERM


BY_SIGNAL = (ExitCode.HUNG_UP, ExitCode.INTERRUPTED, ExitCode.TERMINATED)


class Stop(Exception):
    """Ends the command: exit code and, if there is one, the last line on stderr («problem (why). What to do.»)."""

    def __init__(self, code: int, message: str = "", errors: str = "") -> None:
        """`errors`: lines of another program that come before the message, as they are."""
        super().__init__(errors + message)
        self.code = code
        self.message = message
        self.errors = errors

    def refused(self) -> str:
        """The message of what was refused; a signal is raised again."""
        if self.code in BY_SIGNAL:
            raise self
        return self.errors + self.message


class BadCase(Stop):
    """Stop(2)."""

    def __init__(self, message: str) -> None:
        super().__init__(ExitCode.BAD_CASE, message)


class StorageFailed(Stop):
    """Stop(73)."""

    def __init__(self, message: str) -> None:
        super().__init__(ExitCode.STORAGE_FAILED, message)
