"""Exit codes of every Copepod process; the same numbers as proto/contract/exit_code.hpp."""

FINISHED = 0
PREPARATION_FAILED = 1  # of this command alone: the build failed
NOT_CONFORMANT = 1  # of this command alone: a component breaks the protocol
BAD_CASE = 2  # bad case file or command line, missing packages
REFUSED = 65  # refused by the peer: version, role, key, capability
COMPONENT_LOST = 69  # a component died, froze or hung
SOLVER_FAILED = 70  # diverged, NaN
STORAGE_FAILED = 73  # output or checkpoint could not be written or read
DEADLINE_PASSED = 74  # nobody answered in time
INTERRUPTED = 130  # SIGINT
TERMINATED = 143  # SIGTERM

OF_COMPONENTS = (BAD_CASE, REFUSED, COMPONENT_LOST, SOLVER_FAILED, STORAGE_FAILED, DEADLINE_PASSED)
