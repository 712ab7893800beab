"""`copepod report`: hands run directories to copepod_report."""

from copepod_run.errors import ExitCode
from copepod_run import build
from copepod_run.plan import plan_of


def report(options):
    """Writes the report and prints where it is."""
    build.ensure_programs()
    from copepod_report.report import write_report  # numpy and matplotlib: slow to load, and installed just now

    out = options.out or (f"{options.directories[0]}/report" if len(options.directories) == 1 else "report")
    print(write_report(options.directories, out, read_case))
    return ExitCode.FINISHED


def read_case(path):
    """The resolved case as the coupler reads it: there is one parser."""
    return plan_of(path).case
