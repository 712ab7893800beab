"""`copepod setup`: only prepares the machine and builds; for containers and continuous integration."""

from copepod_run.errors import ExitCode
from copepod_run import build, packages


def setup(options):
    if options.ci:
        packages.ensure(packages.BUILD_AND_RUN + packages.CONTINUOUS_INTEGRATION)
    if options.packages_only:
        packages.ensure()
    else:
        build.ensure_everything()
    return ExitCode.FINISHED
