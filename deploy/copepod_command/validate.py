"""`copepod validate`: the accuracy of every scheme at the surfaces of bodies."""

import shlex
from argparse import Namespace
from pathlib import Path

from copepod_run import destinations
from copepod_run.build import ensure_programs
from copepod_run.checkout import ROOT, build_digest
from copepod_run.errors import ExitCode, Stop


def validate(options: Namespace) -> int:
    """Runs the matrix, writes the page and prints where it is."""
    folder = Path(options.out or ROOT / "docs/results")
    destinations.make_folder(folder)
    ensure_programs()
    # These need numpy and matplotlib: slow to load, and perhaps installed just now.
    from copepod_validation import all_schemes, matrix, page
    from copepod_validation.experiment import SCHEMES

    if options.all:
        for name in ("cases", "schemes", "fluid"):
            if getattr(options, name):
                raise Stop(
                    ExitCode.BAD_CASE, f"--all has no --{name} (it runs every combination). Leave one of them out."
                )
        command = "deploy/copepod validate --all" + (" --fast" if options.fast else "")
        build, kept = build_digest(), matrix.FOLDER / "all_schemes.jsonl"
        results = all_schemes.judged(list(all_schemes.combinations(options.fast)), options.jobs, build, kept)
        path = all_schemes.write(folder, results, command, build)
        print(path)
        if not options.fast:
            print(all_schemes.write_errors(folder if options.out else ROOT / "coupler/config/checks", results))
        if wrong := sum(row["verdict"] == "wrong" for row in results):
            raise Stop(
                ExitCode.FAILED, f"{wrong} of {len(results)} combinations that check admits are wrong. See {path}."
            )
        return ExitCode.FINISHED
    cases, schemes = options.cases or list(matrix.CASES), options.schemes or list(SCHEMES)
    words = ["validate"]
    words += ["--cases", *cases] if options.cases else []
    words += ["--schemes", *schemes] if options.schemes else []
    words += ["--fast"] if options.fast else []
    words += ["--fluid", options.fluid] if options.fluid else []
    again = words + (["--out", options.out] if options.out else [])
    sections = matrix.run(cases, schemes, options.fast, options.fluid, options.jobs, shlex.join(again))
    part = ", the fast subset of their points" if options.fast else ""
    print(page.write(folder, sections, f"deploy/copepod {shlex.join(words)}", build_digest(), part))
    return ExitCode.FINISHED
