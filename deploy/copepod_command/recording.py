"""`copepod recording`: hands over to the tool of the component kit."""

import subprocess
import sys
from argparse import Namespace


def recording(options: Namespace) -> int:
    """Exit code of `python3 -m copepod_recording` with the same arguments."""
    return subprocess.run([sys.executable, "-m", "copepod_recording", *options.arguments]).returncode
