"""`copepod conformance`: builds what is missing, then hands over to the tool of the component kit."""

import os
import subprocess
import sys
from argparse import Namespace

from copepod_run import build, components
from copepod_run.scratch import guarded_folder


def conformance(options: Namespace) -> int:
    """Exit code of `python3 -m copepod_conformance` with the same arguments; nothing of it is left, however it ends."""
    command = [sys.executable, "-m", "copepod_conformance", *options.arguments]
    if options.arguments[:1] in (["-h"], ["--help"]):
        return subprocess.run(command).returncode
    build.ensure_programs()
    with guarded_folder() as folder:
        environment = components.environment(folder.mark, folder.scratch, ranks=len(os.sched_getaffinity(0)))
        return subprocess.run(command, env={**environment, "TMPDIR": str(folder.path)}).returncode
