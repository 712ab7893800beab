"""Entry point; `deploy/copepod` starts this file with Debian's Python."""

import signal
import sys
from pathlib import Path

_DEPLOY = Path(__file__).resolve().parent.parent
sys.path[:1] = [str(_DEPLOY), str(_DEPLOY.parent / "proto" / "python")]

try:
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})  # deploy/copepod blocks it until somebody can say so
    from copepod_command.main import main  # the path above must be set first

    code = main(sys.argv[1:])
except KeyboardInterrupt:
    print("copepod: stopped by Ctrl-C.", file=sys.stderr)
    code = 130
sys.exit(code)
