"""`copepod bench`: what to expect on this machine, as a table and as JSON."""

import itertools
import json
import math
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
from copepod_run.figures import markdown_table
from copepod_run.messages import Stage, say

_PAPER = (100, 100, 200)
_DOMAINS = ((48, 48, 48), _PAPER, (160, 160, 160))
_KEYS: dict[str, Figures] = {
    "defaults": {},
    "bgk, bounce_back, equilibrium, no lubrication": measurements.PUBLISHED,
}
_BUSY = 0.05  # part of the machine that others take, from which on figures mean little
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
    domains, cores = (_DOMAINS[0],) if options.quick else _DOMAINS, len(os.sched_getaffinity(0))
    results = []
    for domain, ranks, precision in itertools.product(domains, sorted({1, cores}), ("double", "single")):
        for collision in ("bgk", "trt") if domain == _PAPER else ("bgk",):
            with Stage(f"fluid alone, {domain}, {precision}, {collision}, {ranks} rank(s)"):
                chosen = (domain, ranks, precision, collision, options.samples, _steps(domain, 4e7))
                results.append(measurements.measure_fluid(*chosen))
    return results


def _coupled(options: Namespace) -> list[Figures]:
    ranks = len(os.sched_getaffinity(0))
    rows: list[tuple[tuple[int, int, int], int, tuple[str, ...]]] = [(_DOMAINS[0], 3, ())]
    if not options.quick:
        rows += [(_PAPER, 3, ("x", "y")), *((_PAPER, beads, ()) for beads in (3, 100, 1000))]
    results = []
    for keys, (domain, beads, planes), transport in itertools.product(_KEYS.values(), rows, ("ipc", "in_process")):
        with Stage(f"coupled, {domain}, {beads} beads, {ranks} rank(s), {transport}{', as published' if keys else ''}"):
            steps = min(_LONGEST_STEPS, _steps(measurements.computed_cells(domain, planes), 1e9))
            chosen = (domain, beads, ranks, steps, options.samples, planes, transport, keys)
            results.append(measurements.measure_coupled(*chosen))
    return results


def _steps(domain: Sequence[int], cell_updates: float) -> int:
    return max(10, int(cell_updates / math.prod(domain)))


def _table(results: Mapping[str, Sequence[Figures]]) -> str:
    """The measurements as tables in Markdown."""
    heads = "domain | precision | collision | ranks | memory copy GB/s | 19 streams M cells/s | fluid MLUPS | share"
    form = "{domain} | {precision} | {collision} | {ranks} | {median_copy_gb_per_s:.1f} | "
    form += "{median_streams_mcells_per_s:.1f} | {median_fluid_mlups:.1f} | {median_share_of_limit:.2f}"
    parts = [
        "## Fluid alone",
        markdown_table(heads, (form.format(**row, domain=_cells(row)) for row in results["pure"])),
    ]
    heads = "domain | symmetry planes | beads | ranks | transport | coupled MLUPS | alone MLUPS | ratio | overhead"
    form = "{domain} | {planes} | {beads} | {ranks} | {transport} | {median_coupled_mlups:.1f} | "
    form += "{median_fluid_mlups:.1f} | {median_ratio:.2f} ({least:.2f}–{most:.2f}) | {median_coupling_overhead:.3f}"
    for title, keys in _KEYS.items():
        rows = []
        for row in [row for row in results["coupled"] if row["keys"] == keys]:
            ratios = [sample["ratio"] for sample in row["samples"]]
            more = {"domain": _cells(row), "planes": ", ".join(row["symmetry_planes"]) or "none"}
            rows.append(form.format(**row, **more, least=min(ratios), most=max(ratios)))
        parts += [f"## Coupled, double precision, over ipc or in one process: {title}", markdown_table(heads, rows)]
    busy = max(row["others"] for row in results["coupled"])
    if busy > _BUSY:
        parts.append(f"The machine was busy: other work had up to {100 * busy:.0f} % of it. Measure again without it.")
    parts += ["## Phases of a coupled step, rank 0, percent of the fluid's time", _phase_table(results["coupled"])]
    return "\n\n".join(parts)


def _phase_table(results: Sequence[Figures]) -> str:
    phases, rows = list(results[0]["samples"][0]["phases_s"]["fluid"]), []
    for row in results:
        seconds = row["samples"][-1]["phases_s"]["fluid"]
        total = sum(seconds.values()) or 1.0
        boundary = row["keys"].get("fluid", {}).get("moving_boundary", "default")
        shares = (f"{100 * seconds[phase] / total:.1f}" for phase in phases)
        rows.append(" | ".join([_cells(row), str(row["beads"]), boundary, row["transport"], *shares]))
    return markdown_table(" | ".join(["domain | beads | boundary | transport", *phases]), rows)


def _cells(row: Figures) -> str:
    return "×".join(map(str, row["domain_cells"]))
