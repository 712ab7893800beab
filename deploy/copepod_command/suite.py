"""`copepod test`: builds everything and runs the test suite."""

import os
import subprocess

from copepod_run import build
from copepod_run.checkout import ROOT


def test(options):
    """Exit code of ctest, which writes the summary itself."""
    build.ensure_everything()
    jobs = str(len(os.sched_getaffinity(0)))
    return subprocess.run(["ctest", "--preset", "release", "-j", jobs, *options.ctest_arguments], cwd=ROOT).returncode
