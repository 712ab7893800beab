"""`copepod conformance`: checks a component against the protocol."""

import os
import time
from pathlib import Path

from copepod_run import build, components, destinations
from copepod_run.errors import ExitCode, Stop
from copepod_run.scratch import guarded_folder
from copepod_run.messages import Stage

_JOBS_PER_CORE = 2  # components mostly wait


def conformance(options):
    """Prints the table, writes JUnit XML to --junit; exit code 0 only if nothing failed."""
    if not options.component:
        raise Stop(
            ExitCode.BAD_CASE,
            "which component? Give its command after --, for example: "
            "copepod conformance --role fluid -- build/bin/fluid_service",
        )
    components.require_program(options.role, options.component)
    destinations.require_file(options.junit, "--junit")
    build.ensure_programs()
    with guarded_folder() as folder:
        environment = components.environment(folder.mark, folder.scratch, ranks=_cores())
        return _check(options, environment, str(folder.path))


def _check(options, environment, folder):
    os.environ.setdefault("COPEPOD_BUILD_PYTHON", environment["COPEPOD_BUILD_PYTHON"])
    import zmq  # these need packages that were installed just now
    from copepod_conformance import report
    from copepod_conformance.subject import Subject
    from copepod_conformance.suite import Suite, all_checks, groups

    unknown = set(options.only or ()) - set(groups())
    if unknown:
        raise Stop(
            ExitCode.BAD_CASE,
            f"there is no group {', '.join(unknown)} of checks. Choose from: {', '.join(groups())}.",
        )
    with zmq.Context() as context:
        subject = Subject(
            options.role, options.component, environment, folder, context, options.patience, options.solver
        )
        checks = [
            check
            for check in all_checks(subject)
            if (not options.only or check.group in options.only) and not (options.quick and check.thorough)
        ]
        start = time.monotonic()
        with Stage(f"{len(checks)} checks of {subject.name}") as stage:
            results = Suite(subject, checks, options.jobs or _JOBS_PER_CORE * _cores(), stage.count).run()
    print(report.table(subject, results, options.verbose))
    if options.junit:
        Path(options.junit).write_bytes(report.junit(subject, results, time.monotonic() - start))
    return ExitCode.FAILED if report.counts(results)["failed"] else ExitCode.FINISHED


def _cores():
    return len(os.sched_getaffinity(0))
