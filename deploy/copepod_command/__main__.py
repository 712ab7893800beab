"""Entry point; `deploy/copepod` starts this file with Debian's Python."""

import sys
from pathlib import Path

sys.path[0] = str(Path(__file__).resolve().parent.parent)

from copepod_command.main import main  # noqa: E402  (the path above must be set first)

sys.exit(main(sys.argv[1:]))
