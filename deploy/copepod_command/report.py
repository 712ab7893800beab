"""`copepod report`: tables and plots of run directories."""

from argparse import Namespace
from pathlib import Path

from copepod_run import build
from copepod_run.errors import ExitCode, Stop
from copepod_run.plan import plan_of


def report(options: Namespace) -> int:
    """Writes the report and prints where it is."""
    build.ensure_programs()
    # These need numpy and matplotlib: slow to load, and perhaps installed just now.
    from copepod_report.flow import View
    from copepod_report.report import write_report
    from copepod_report.sweeps import Choice

    out = options.out or (f"{options.directories[0]}/report" if len(options.directories) == 1 else "report")
    if not options.out and Path(out).is_symlink():
        raise Stop(
            ExitCode.STORAGE_FAILED, f"{out} leads elsewhere (it is a symbolic link). Name the folder with --out."
        )
    # The coupler is the only parser of cases.
    view = View(options.plane, options.at, options.time, options.zoom, options.margin, options.frame)
    choice = Choice(options.x, options.y)
    path = write_report(
        options.directories,
        out,
        lambda path: plan_of(path).drawn_case,
        view,
        options.format,
        choice,
        options.video,
    )
    print(path)
    return ExitCode.FINISHED
