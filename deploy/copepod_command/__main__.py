"""Entry point: `deploy/copepod` runs this package with Debian's Python."""

import signal
import sys

try:
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})  # blocked by deploy/copepod so far
    from copepod_run.messages import open_outputs  # late, so that Ctrl-C during the imports is handled

    open_outputs()
    from copepod_command.main import main

    code = main(sys.argv[1:])
except (KeyboardInterrupt, RuntimeError) as end:
    # Python before 3.12 wraps an interruption of a class that is being defined, as in an import.
    if KeyboardInterrupt not in (type(end), type(end.__cause__)):
        raise
    print("copepod: stopped by Ctrl-C.", file=sys.stderr)
    code = 130
sys.exit(code)
