"""`copepod setup` and `copepod test`: packages, the build, and the test suite."""

import os
import subprocess
from argparse import Namespace

from copepod_run import build, packages
from copepod_run.checkout import ROOT
from copepod_run.errors import ExitCode


def setup(options: Namespace) -> int:
    """Prepares the machine and builds, nothing else; for containers and continuous integration."""
    if options.ci:
        packages.ensure(packages.BUILD_AND_RUN + packages.CONTINUOUS_INTEGRATION)
    if options.packages_only:
        packages.ensure()
    else:
        build.ensure_everything()
    return ExitCode.FINISHED


def test(options: Namespace) -> int:
    """Exit code of ctest, which writes the summary itself."""
    build.ensure_everything()
    jobs = str(len(os.sched_getaffinity(0)) + 1)  # tests of processes spend most of their time waiting
    return subprocess.run(["ctest", "--preset", "release", "-j", jobs, *options.ctest_arguments], cwd=ROOT).returncode
