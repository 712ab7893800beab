"""Measurements of this machine: the fluid alone beside the memory, and whole runs beside the uncoupled fluid."""

import itertools
import json
import math
import os
import statistics
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from copepod_run.checkout import ROOT, program
from copepod_run.components import mpirun
from copepod_run.errors import ExitCode, Stop

Figures = dict[str, Any]

_OPEN_MPI = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_hwloc_base_binding_policy": "none",
}
PUBLISHED: Figures = {  # in place of defaults
    "fluid": {"moving_boundary": "bounce_back", "refill": "equilibrium", "collision": "bgk"},
    "lubrication": {"cut_off_cells": "none"},
}
_CELL_M = 1e-6
_RADIUS_CELLS = 4
_SPACING_CELLS = 11  # centre to centre: gaps of three cells
_SPEED_M_PER_S = 1.0  # 7.5e-4 cells per step, a swimmer's


def measure_fluid(
    domain: Sequence[int],
    ranks: int,
    precision: str = "double",
    collision: str = "bgk",
    samples: int = 5,
    steps: int = 20,
) -> Figures:
    """The fluid alone beside the memory (fluid_benchmark): the samples, with medians and the share of the limit.

    The limit is the rate of 19 streams updated in place; each sample's share compares it with the fluid
    of the same moment.
    """
    command = [mpirun(), "-n", str(ranks), "--oversubscribe", str(program("fluid_benchmark"))]
    command += ["--domain", *map(str, domain), "--samples", str(samples), "--steps", str(steps)]
    command += ["--single"] if precision == "single" else []
    command += ["--trt"] if collision == "trt" else []
    done = subprocess.run(command, capture_output=True, text=True, env={**_OPEN_MPI, **os.environ})
    if done.returncode != 0:
        raise Stop(
            ExitCode.SOLVER_FAILED,
            f"{' '.join(command)} failed ({done.stderr.strip()[-500:]}). Check that mpirun works on this machine.",
        )
    result = json.loads(done.stdout)
    shares = [fluid / limit for fluid, limit in zip(result["fluid_mlups"], result["streams_mcells_per_s"])]
    rates = ("fluid_mlups", "streams_mcells_per_s", "copy_gb_per_s")
    medians = {f"median_{name}": statistics.median(result[name]) for name in rates}
    return {**result, **medians, "median_share_of_limit": statistics.median(shares)}


def measure_coupled(
    domain: Sequence[int],
    beads: int,
    ranks: int,
    steps: int,
    samples: int = 3,
    symmetry_planes: Sequence[str] = (),
    transport: str = "ipc",
    keys: Mapping[str, Any] = {},
) -> Figures:
    """Speed with beads that move like a swimmer's, the uncoupled fluid's beside it, and their ratio. `keys` replace
    defaults, by section. `others`: largest part of the machine that others, or its host, took during a sample.

    `domain` is the whole one; rates count the cells that are computed, and leave out the fluid's last look at all
    cells (the phase summary), which belongs to no step.
    """
    computed = computed_cells(domain, symmetry_planes)
    collision = keys.get("fluid", {}).get("collision", "trt")
    flow = {
        "solver": "lattice_boltzmann",
        "density_kg_per_m3": 1360,
        "kinematic_viscosity_m2_per_s": 7.36e-5,
        "cell_size_m": _CELL_M,
        "relaxation_time": 2.0 / 3.0,
        "domain_cells": list(domain),
        "symmetry_planes": list(symmetry_planes),
    }
    case = {
        "case": f"bench_{beads}_beads",
        "fluid": flow | keys.get("fluid", {}),
        "lubrication": keys.get("lubrication", {}),
        "bodies": [_bead(*numbered) for numbered in enumerate(bead_positions(domain, beads))],
        "run": {"steps": steps},
        "output": {"trajectory": {"every_steps": steps}},
        "services": {"fluid": {"ranks": ranks}, "transport": transport},
    }
    rows = []
    for _ in range(samples):
        before = _processor_times()
        alone = measure_fluid(computed, ranks, collision=collision, samples=1, steps=max(10, steps // 4))
        summary = _run(case)
        steps_s = summary["wall_s"] - summary["phases_s"]["fluid"]["summary"]
        coupled = 1e-6 * math.prod(computed) * steps / steps_s
        others, total = (after - start for after, start in zip(_processor_times(), before))
        rows.append(
            {
                "coupled_mlups": coupled,
                "fluid_mlups": alone["median_fluid_mlups"],
                "ratio": coupled / alone["median_fluid_mlups"],
                "others": others / total,
                "coupling_overhead": summary["timing"]["coupling_overhead"],
                "phases_s": summary["phases_s"],
            }
        )
    names = ("coupled_mlups", "fluid_mlups", "ratio", "coupling_overhead")
    return {
        "domain_cells": list(domain),
        "symmetry_planes": list(symmetry_planes),
        "beads": beads,
        "ranks": ranks,
        "transport": transport,
        "keys": dict(keys),
        "others": max(row["others"] for row in rows),
        "steps": steps,
        "samples": rows,
        **{f"median_{name}": statistics.median(row[name] for row in rows) for name in names},
    }


def _processor_times() -> tuple[float, float]:
    """Seconds that all processors have worked for others than this process and its children, or not been given to this
    machine, and seconds that they have had in all."""
    user, nice, system, idle, wait, irq, soft, steal = map(int, Path("/proc/stat").read_text().split()[1:9])
    ours = sum(os.times()[:4])
    ticks = os.sysconf("SC_CLK_TCK")
    busy = user + nice + system + irq + soft + steal
    return busy / ticks - ours, (busy + idle + wait) / ticks


def computed_cells(domain: Sequence[int], symmetry_planes: Sequence[str]) -> list[int]:
    """Extents of the part of the domain that its symmetry planes leave."""
    return [cells // 2 if axis in symmetry_planes else cells for axis, cells in zip("xyz", domain)]


def _bead(number: int, position: Sequence[float]) -> Figures:
    """Every other one moves up, the others down."""
    return {
        "name": f"bead_{number}",
        "shape": "sphere",
        "radius_m": _RADIUS_CELLS * _CELL_M,
        "mass_kg": 5.44e-13,
        "position_m": [x * _CELL_M for x in position],
        "velocity_m_per_s": [0.0, 0.0, _SPEED_M_PER_S if number % 2 else -_SPEED_M_PER_S],
        "motion": "prescribed",
    }


def bead_positions(domain: Sequence[int], beads: int) -> list[tuple[float, ...]]:
    """Centres in cells: up to three beads in a row on the axis, more on a grid over the whole domain."""
    if beads <= 3:
        x, y, z = (cells / 2 for cells in domain)
        return [(x, y, z + 16 * (i - 1)) for i in range(beads)]
    places = ([(i + 0.5) * _SPACING_CELLS for i in range(cells // _SPACING_CELLS)] for cells in domain)
    grid = list(itertools.product(*places))
    if len(grid) < beads:
        raise Stop(
            ExitCode.BAD_CASE,
            f"{beads} beads do not fit into {domain} cells (there is room for {len(grid)}). Use fewer.",
        )
    return [grid[int(i * (len(grid) / beads))] for i in range(beads)]


def _run(case: Figures) -> Figures:
    """summary.json of a run of the case in a folder of its own."""
    with tempfile.TemporaryDirectory(prefix="copepod-bench-") as folder:
        file, out = Path(folder, "case.yaml"), Path(folder, "run")
        file.write_text(json.dumps(case))
        command = [str(ROOT / "deploy/copepod"), "run", str(file), "--out", str(out)]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            raise Stop(done.returncode, f"a benchmark run failed ({done.stderr.strip()[-500:]}).")
        return dict(json.loads((out / "summary.json").read_text()))
