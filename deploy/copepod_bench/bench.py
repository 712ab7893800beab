"""`copepod bench`: what to expect on this machine, as a table and as JSON."""

import itertools
import json
import os
import subprocess
from argparse import Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path

from copepod_bench import measurements
from copepod_bench.measurements import Figures
from copepod_run import build, destinations
from copepod_run.checkout import PROGRAMS, program
from copepod_run.errors import ExitCode
from copepod_run.messages import Stage, say

_PAPER = (100, 100, 200)
_DOMAINS = ((48, 48, 48), _PAPER, (160, 160, 160))
_LONGEST_STEPS = 4000  # of three beads, two of which would meet after 5300


def bench(options: Namespace) -> int:
    """Measures for a few minutes; prints the table, writes the JSON to --out."""
    destinations.require_file(options.out, "--out")
    if options.exchange:
        build.ensure_targets((*PROGRAMS, "exchange_overhead", "fake_body"))
        return subprocess.run([program("exchange_overhead")]).returncode
    build.ensure_targets((*PROGRAMS, "fluid_benchmark"))
    results = {"pure": _pure(options), "coupled": _coupled(options)}
    print(_table(results))
    if options.out:
        Path(options.out).write_text(json.dumps(results, indent=1) + "\n")
        say(f"all samples are in {options.out}")
    return ExitCode.FINISHED


def _pure(options: Namespace) -> list[Figures]:
    cores = len(os.sched_getaffinity(0))
    domains = (_DOMAINS[0],) if options.quick else _DOMAINS
    results = []
    for domain in domains:
        for ranks in sorted({1, cores}):
            for precision in ("double", "single"):
                for collision in ("bgk", "trt") if domain == _PAPER else ("bgk",):
                    with Stage(f"fluid alone, {domain}, {precision}, {collision}, {ranks} rank(s)"):
                        results.append(
                            measurements.measure_fluid(
                                domain, ranks, precision, collision, options.samples, _steps(domain, 4e7)
                            )
                        )
    return results


def _coupled(options: Namespace) -> list[Figures]:
    ranks = len(os.sched_getaffinity(0))
    rows: list[tuple[tuple[int, int, int], int, tuple[str, ...]]] = [(_DOMAINS[0], 3, ())]
    if not options.quick:
        rows += [(_PAPER, 3, ("x", "y")), *((_PAPER, beads, ()) for beads in (3, 100, 1000))]
    results = []
    for (domain, beads, planes), transport in itertools.product(rows, ("ipc", "in_process")):
        with Stage(f"coupled, {domain}, {beads} beads, {ranks} rank(s), {transport}"):
            steps = min(_LONGEST_STEPS, _steps(measurements.computed_cells(domain, planes), 1e9))
            results.append(
                measurements.measure_coupled(domain, beads, ranks, steps, options.samples, planes, transport)
            )
    return results


def _steps(domain: Sequence[int], cell_updates: float) -> int:
    return max(10, int(cell_updates / (domain[0] * domain[1] * domain[2])))


def _table(results: Mapping[str, Sequence[Figures]]) -> str:
    """The measurements as a table in Markdown."""
    lines = [
        "## Fluid alone",
        "",
        "| domain | precision | collision | ranks | memory copy GB/s | 19 streams M cells/s | fluid MLUPS | share |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for row in results["pure"]:
        lines.append(
            f"| {_cells(row['domain_cells'])} | {row['precision']} | {row['collision']} | {row['ranks']} "
            f"| {row['median_copy_gb_per_s']:.1f} | {row['median_streams_mcells_per_s']:.1f} "
            f"| {row['median_fluid_mlups']:.1f} | {row['median_share_of_limit']:.2f} |"
        )
    lines += [
        "",
        "## Coupled, double precision, over ipc or in one process",
        "",
        "| domain | symmetry planes | beads | ranks | transport | coupled MLUPS | alone MLUPS | ratio | overhead |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for row in results["coupled"]:
        planes = ", ".join(row["symmetry_planes"]) or "none"
        lines.append(
            f"| {_cells(row['domain_cells'])} | {planes} | {row['beads']} | {row['ranks']} | {row['transport']} "
            f"| {row['median_coupled_mlups']:.1f} | {row['median_fluid_mlups']:.1f} "
            f"| {row['median_ratio']:.3f} | {row['median_coupling_overhead']:.3f} |"
        )
    lines += ["", "## Phases of a coupled step, rank 0, percent of the fluid's time", ""]
    lines += _phase_table(results["coupled"])
    return "\n".join(lines)


def _phase_table(rows: Sequence[Figures]) -> list[str]:
    phases = list(rows[0]["samples"][0]["phases_s"]["fluid"]) if rows else []
    lines = ["| domain | beads | transport | " + " | ".join(phases) + " |", "|---|---|---|" + "---|" * len(phases)]
    for row in rows:
        seconds = row["samples"][-1]["phases_s"]["fluid"]
        total = sum(seconds.values()) or 1.0
        shares = " | ".join(f"{100 * seconds[phase] / total:.1f}" for phase in phases)
        lines.append(f"| {_cells(row['domain_cells'])} | {row['beads']} | {row['transport']} | {shares} |")
    return lines


def _cells(domain: Sequence[int]) -> str:
    return "×".join(map(str, domain))
