"""Entry point: `deploy/copepod` runs this package with Debian's Python."""

import sys

try:  # signals, which deploy/copepod has blocked, are heeded from main() on; other ways to start Python block none
    from copepod_run.messages import open_outputs

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
