"""What `copepod check`, `report`, `watch`, `validate`, `setup` and `test` do."""

import json
import os
import shlex
import subprocess
import time
from argparse import Namespace
from dataclasses import asdict
from pathlib import Path

from copepod_run import build, packages
from copepod_run.checkout import PREFIX, ROOT, build_digest
from copepod_run.errors import BadCase, ExitCode, Stop, StorageFailed
from copepod_run.messages import say
from copepod_run.run_directory import make_folder

_START_PATIENCE_S = 10.0  # of `watch`, for a run that has just been started to write its case
_ADVICE = "Start one with copepod run CASE.yaml --out DIR, then watch that folder."


def check(options: Namespace) -> int:
    """Prints the key figures of a case, sweep or campaign that can run; errors end in Stop(2)."""
    from copepod_campaign.check import findings  # commands start without what others need

    found = findings(options)
    if options.json:
        print(json.dumps(asdict(found)))
    else:
        print(f"{options.case}: {found.name}, {found.text()}")
    if found.problems:
        raise Stop(ExitCode.BAD_CASE)
    if not options.json:
        print("ok")
    return ExitCode.FINISHED


def report(options: Namespace) -> int:
    """Writes the report and prints where it is."""
    build.ensure_programs()
    # These need numpy and matplotlib: slow to load, and perhaps installed just now.
    from copepod_report.report import write_report

    out = options.out or (f"{options.directories[0]}/report" if len(options.directories) == 1 else "report")
    if not options.out and Path(out).is_symlink():
        raise StorageFailed(f"{out} leads elsewhere (it is a symbolic link). Name the folder with --out.")
    print(write_report(options, out))
    return ExitCode.FINISHED


def export(options: Namespace) -> int:
    """Writes the crate and prints where its description is."""
    from copepod_report.crate import export as write  # commands start without what others need

    folder = Path(options.out or f"{Path(options.directory).absolute()}.crate")
    print(write(Path(options.directory), folder, options.author, options.license))
    return ExitCode.FINISHED


def watch(options: Namespace) -> int:
    """Serves the page until a signal ends it. Raises Stop(2) unless the folder holds a run or runs."""
    build.ensure_programs()
    # These need numpy and matplotlib: slow to load, and perhaps installed just now.
    from copepod_report.run_status import state_of
    from copepod_watch.follower import runs_in
    from copepod_watch.server import WatchServer

    directory, deadline = Path(options.directory), time.monotonic() + _START_PATIENCE_S
    if not directory.is_dir():
        raise BadCase(f"{directory} is not a folder (no run has been started there). {_ADVICE}")
    while not runs_in(directory):
        if state_of(directory)[0] != "running" or time.monotonic() > deadline:
            raise BadCase(f"{directory} does not hold a run (no case.yaml). {_ADVICE}")
        time.sleep(0.1)
    with WatchServer(directory, options.port) as server:
        if (directory / "case.yaml").is_file():
            server.follower("")  # so that its end is announced, whether the page is open or not
        print(server.address, flush=True)
        say("the page is for this machine only; Ctrl-C ends it")
        server.serve_forever(poll_interval=0.2)
    raise AssertionError("only a signal ends it")


def validate(options: Namespace) -> int:
    """Runs the matrix, writes the page and prints where it is."""
    if options.all or not options.out:
        _require_checkout("validate --all" if options.all else "validate without --out")
    folder = Path(options.out or ROOT / "docs/results")
    make_folder(folder)
    build.ensure_programs()
    # These need numpy and matplotlib: slow to load, and perhaps installed just now.
    from copepod_validation import all_schemes, matrix

    if options.all:
        for name in ("cases", "schemes", "fluid"):
            if getattr(options, name):
                raise BadCase(f"--all has no --{name} (it runs every combination). Leave one of them out.")
        command = "deploy/copepod validate --all" + (" --fast" if options.fast else "")
        digest, kept = build_digest(), matrix.FOLDER / "all_schemes.jsonl"
        results = all_schemes.judged(list(all_schemes.combinations(options.fast)), options.jobs, digest, kept)
        path = all_schemes.write(folder, results, command, digest)
        print(path)
        if not options.fast:
            print(all_schemes.write_errors(folder if options.out else ROOT / "coupler/config/checks", results))
        if wrong := sum(row["verdict"] == "wrong" for row in results):
            raise Stop(
                ExitCode.FAILED, f"{wrong} of {len(results)} combinations that check admits are wrong. See {path}."
            )
        return ExitCode.FINISHED
    words = ["validate"]
    words += ["--cases", *options.cases] if options.cases else []
    words += ["--schemes", *options.schemes] if options.schemes else []
    words += ["--fast"] if options.fast else []
    words += ["--fluid", options.fluid] if options.fluid else []
    again = words + (["--out", options.out] if options.out else [])
    sections = matrix.run(options, shlex.join(again))
    part = ", the fast subset of their points" if options.fast else ""
    print(matrix.write_page(folder, sections, f"deploy/copepod {shlex.join(words)}", build_digest(), part))
    return ExitCode.FINISHED


def _require_checkout(command: str) -> None:
    """Raises Stop(2) in an installed package, in which some things have no place."""
    if PREFIX:
        raise BadCase(f"{command} needs the source (this Copepod is an installed package). Run it in a checkout.")


def setup(options: Namespace) -> int:
    """Prepares the machine and builds, nothing else; for containers and continuous integration."""
    _require_checkout("setup")
    if options.ci:
        packages.ensure(packages.BUILD_AND_RUN + packages.CONTINUOUS_INTEGRATION)
    if options.packages_only:
        packages.ensure()
    else:
        build.ensure_targets()
    return ExitCode.FINISHED


def test(options: Namespace) -> int:
    """Exit code of ctest, which writes the summary itself."""
    _require_checkout("test")
    build.ensure_targets()
    jobs = str(len(os.sched_getaffinity(0)) + 1)  # tests of processes spend most of their time waiting
    return subprocess.run(["ctest", "--preset", "release", "-j", jobs, *options.ctest_arguments], cwd=ROOT).returncode
