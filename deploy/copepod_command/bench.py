"""`copepod bench`: what to expect on this machine, as a table and as JSON."""

import json
import os
import subprocess
from pathlib import Path

from copepod_run.errors import ExitCode
from copepod_run import build, destinations
from copepod_run.checkout import PROGRAMS, program
from copepod_run.messages import Stage, say

_PAPER = (100, 100, 200)
_DOMAINS = ((48, 48, 48), _PAPER, (160, 160, 160))


def bench(options):
    """Measures for a few minutes; prints the table, writes the JSON to --out."""
    destinations.require_file(options.out, "--out")
    if options.exchange:
        build.ensure_targets((*PROGRAMS, "exchange_overhead", "fake_body"))
        return subprocess.run([program("exchange_overhead")]).returncode
    build.ensure_targets((*PROGRAMS, "fluid_benchmark"))
    from copepod_bench import report

    results = {"pure": _pure(options), "coupled": _coupled(options)}
    print(report.table(results))
    if options.out:
        Path(options.out).write_text(json.dumps(results, indent=1) + "\n")
        say(f"all samples are in {options.out}")
    return ExitCode.FINISHED


def _pure(options):
    from copepod_bench import pure

    cores = len(os.sched_getaffinity(0))
    domains = (_DOMAINS[0],) if options.quick else _DOMAINS
    results = []
    for domain in domains:
        for ranks in sorted({1, cores}):
            for precision in ("double", "single"):
                for collision in ("bgk", "trt") if domain == _PAPER else ("bgk",):
                    with Stage(f"fluid alone, {domain}, {precision}, {collision}, {ranks} rank(s)"):
                        results.append(
                            pure.measure(domain, ranks, precision, collision, options.samples, _steps(domain, 4e7))
                        )
    return results


def _coupled(options):
    from copepod_bench import coupled

    ranks = len(os.sched_getaffinity(0))
    configurations = [((48, 48, 48), 3, ())]
    if not options.quick:
        configurations += [(_PAPER, 3, ("x", "y")), *((_PAPER, beads, ()) for beads in (0, 3, 100, 1000))]
    results = []
    for domain, beads, planes in configurations:
        with Stage(f"coupled, {domain}, {beads} beads, {ranks} rank(s)"):
            steps = _steps(coupled.computed_cells(domain, planes), 5e8)
            results.append(coupled.measure(domain, beads, ranks, steps, options.samples, planes))
    return results


def _steps(domain, cell_updates):
    return max(10, int(cell_updates / (domain[0] * domain[1] * domain[2])))
