"""`copepod bench`: the fluid alone beside the memory, whole runs beside the uncoupled fluid, as a table and as JSON."""

import errno
import itertools
import json
import math
import os
import statistics
import subprocess
import tempfile
from argparse import Namespace
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import jinja2

from copepod_run import build
from copepod_run.checkout import COMMAND, PROGRAMS, program
from copepod_run.components import environment_to_ask, mpirun
from copepod_run.errors import BadCase, ExitCode, Stop, StorageFailed
from copepod_run.messages import Stage, say

Figures = dict[str, Any]

PUBLISHED: Figures = {  # in place of defaults
    "fluid": {"moving_boundary": "bounce_back", "refill": "equilibrium", "collision": "bgk"},
    "lubrication": {"cut_off_cells": "none"},
}
_CELL_M = 1e-6
_RADIUS_CELLS = 4
_SPACING_CELLS = 11  # centre to centre: gaps of three cells
_SPEED_M_PER_S = 1.0  # 7.5e-4 cells per step, a swimmer's
_PAPER = (100, 100, 200)
_DOMAINS = ((48, 48, 48), _PAPER, (160, 160, 160))
_KEYS: dict[str, Figures] = {"defaults": {}, "bgk, bounce_back, equilibrium, no lubrication": PUBLISHED}
_TABLES = Path(__file__).with_name("bench.md")
_BUSY = 0.05  # part of the machine that others take, from which on figures mean little
_LONGEST_STEPS = 4000  # of three beads, two of which would meet after 5300


@dataclass(frozen=True)
class Setup:
    """Beads that move like a swimmer's, in a fluid."""

    domain_cells: tuple[int, ...]  # of the whole domain
    beads: int
    symmetry_planes: tuple[str, ...] = ()
    transport: str = "ipc"
    keys: Figures = field(default_factory=dict)  # in place of defaults, by section
    shape: str = "sphere"  # a mesh has 10,000 triangles

    @property
    def computed_cells(self) -> list[int]:
        """Extents of the part of the domain that its symmetry planes leave."""
        return [cells // 2 if axis in self.symmetry_planes else cells for axis, cells in zip("xyz", self.domain_cells)]


def bench(options: Namespace) -> int:
    """Measures for a few minutes; prints the table, writes the JSON to --out."""
    if options.out:
        _require_file(Path(options.out))
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


def _require_file(path: Path) -> None:
    """Raises Stop(73) unless it can be written, before the work that fills it."""
    problem = None
    try:
        if path.is_dir():
            problem = "that is a folder"
        elif not path.absolute().parent.is_dir():
            problem = "its folder is missing"
        elif not os.access(path if path.exists() else path.absolute().parent, os.W_OK):
            problem = os.strerror(errno.EACCES)
    except OSError as refusal:  # a name that is too long
        problem = refusal.strerror
    if problem:
        raise StorageFailed(f"{path} cannot be written ({problem}). Choose another --out.")


def _pure(options: Namespace) -> list[Figures]:
    domains, cores = (_DOMAINS[0],) if options.quick else _DOMAINS, len(os.sched_getaffinity(0))
    results = []
    for domain, ranks, precision in itertools.product(domains, sorted({1, cores}), ("double", "single")):
        for collision in ("bgk", "trt", "central_moments") if domain == _PAPER else ("bgk",):
            with Stage(f"fluid alone, {domain}, {precision}, {collision}, {ranks} rank(s)"):
                chosen = (domain, ranks, precision, collision, options.samples, _steps(domain, 4e7))
                results.append(measure_fluid(*chosen))
    return results


def _coupled(options: Namespace) -> list[Figures]:
    ranks = len(os.sched_getaffinity(0))
    kinds = [Setup(_DOMAINS[0], 3)]
    if not options.quick:
        kinds += [Setup(_PAPER, 3, ("x", "y")), *(Setup(_PAPER, beads) for beads in (3, 100, 1000))]
    ways = itertools.product(_KEYS.values(), kinds, ("ipc", "in_process"))
    setups = [replace(kind, transport=transport, keys=keys) for keys, kind, transport in ways]
    if not options.quick:
        shapes = (("ellipsoid", 3), ("ellipsoid", 1000), ("sphere", 1), ("mesh", 1))
        setups += [Setup(_PAPER, beads, transport="in_process", shape=shape) for shape, beads in shapes]
    results = []
    for one in setups:
        how = f"{ranks} rank(s), {one.transport}{', as published' if one.keys else ''}"
        with Stage(f"coupled, {one.domain_cells}, {one.beads} × {one.shape}, {how}"):
            steps = min(_LONGEST_STEPS, _steps(one.computed_cells, 1e9))
            results.append(measure_coupled(one, ranks, steps, options.samples))
    return results


def _steps(domain: Sequence[int], cell_updates: float) -> int:
    return max(10, int(cell_updates / math.prod(domain)))


def _table(results: Mapping[str, Sequence[Figures]]) -> str:
    """The measurements as tables in Markdown."""
    tables = jinja2.Template(_TABLES.read_text(), trim_blocks=True, lstrip_blocks=True)
    busy = max(row["others"] for row in results["coupled"])
    return tables.render(**results, keys=_KEYS, busy=f"{100 * busy:.0f}" if busy > _BUSY else "").rstrip()


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
    command += ["--collision", collision, *(["--single"] if precision == "single" else [])]
    environment = {"OMPI_MCA_hwloc_base_binding_policy": "none", **environment_to_ask()}
    done = subprocess.run(command, capture_output=True, text=True, env=environment)
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


def measure_coupled(setup: Setup, ranks: int, steps: int, samples: int = 3) -> Figures:
    """Speed of the setup, the uncoupled fluid's beside it, and their ratio. `others`: largest part of the machine that
    others, or its host, took during a sample.

    Rates count the cells that are computed, and leave out the fluid's last look at all cells (the phase summary), which
    belongs to no step.
    """
    domain, keys, computed = setup.domain_cells, setup.keys, setup.computed_cells
    collision = keys.get("fluid", {}).get("collision", "trt")
    flow = {
        "solver": "lattice_boltzmann",
        "density_kg_per_m3": 1360,
        "kinematic_viscosity_m2_per_s": 7.36e-5,
        "cell_size_m": _CELL_M,
        "relaxation_time": 2.0 / 3.0,
        "domain_cells": list(domain),
        "symmetry_planes": list(setup.symmetry_planes),
    }
    case = {
        "case": f"bench_{setup.beads}_beads",
        "fluid": flow | keys.get("fluid", {}),
        "lubrication": keys.get("lubrication", {}),
        "bodies": [_bead(*numbered, setup.shape) for numbered in enumerate(bead_positions(domain, setup.beads))],
        "run": {"steps": steps},
        "output": {"trajectory": {"every_steps": steps}},
        "services": {"fluid": {"ranks": ranks}, "transport": setup.transport},
    }
    rows = []
    for _ in range(samples):
        before = _processor_times()
        alone = measure_fluid(computed, ranks, collision=collision, samples=1, steps=max(10, steps // 4))
        summary = _run(case)
        steps_s = summary["wall_s"] - summary["phases_s"]["fluid"]["summary"]
        coupled = 1e-6 * math.prod(computed) * steps / steps_s
        others, total = (after - start for after, start in zip(_processor_times(), before))
        row = {
            "coupled_mlups": coupled,
            "fluid_mlups": alone["median_fluid_mlups"],
            "ratio": coupled / alone["median_fluid_mlups"],
            "others": others / total,
            "coupling_overhead": summary["timing"]["coupling_overhead"],
            "phases_s": summary["phases_s"],
        }
        rows.append(row)
    names = ("coupled_mlups", "fluid_mlups", "ratio", "coupling_overhead")
    return {
        **asdict(setup),
        "ranks": ranks,
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


def _shape(name: str) -> Figures:
    """Of a sphere's volume; as a mesh, the sphere."""
    radius_m = _RADIUS_CELLS * _CELL_M
    if name == "ellipsoid":
        return {"shape": name, "semi_axes_m": [0.8 * radius_m, radius_m, 1.25 * radius_m]}
    if name == "mesh":
        return {"shape": name, "text": _round_mesh(71), "unit_m": radius_m}
    return {"shape": name, "radius_m": radius_m}


def _round_mesh(around: int) -> str:
    """The unit sphere as an OBJ file, of 2 around² triangles."""
    polar, azimuths = (math.pi * (i + 1) / (around + 1) for i in range(around)), range(around)
    rings = [(math.sin(t), math.cos(t), 2 * math.pi * k / around) for t in polar for k in azimuths]
    points = [(0, 0, 1), (0, 0, -1), *((s * math.cos(p), s * math.sin(p), c) for s, c, p in rings)]
    at = [[3 + around * ring + k % around for k in range(around + 1)] for ring in range(around)]
    faces = [f for k in azimuths for f in ((1, at[0][k], at[0][k + 1]), (2, at[-1][k + 1], at[-1][k]))]
    for one, next_ in itertools.pairwise(at):
        faces += [f for k in azimuths for f in ((one[k], next_[k], next_[k + 1]), (one[k], next_[k + 1], one[k + 1]))]
    return "".join([*("v {} {} {}\n".format(*p) for p in points), *("f {} {} {}\n".format(*f) for f in faces)])


def _bead(number: int, position: Sequence[float], shape: str) -> Figures:
    """Every other one moves up, the others down."""
    return {
        "name": f"bead_{number}",
        **_shape(shape),
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
        raise BadCase(f"{beads} beads do not fit into {domain} cells (there is room for {len(grid)}). Use fewer.")
    return [grid[int(i * (len(grid) / beads))] for i in range(beads)]


def _run(case: Figures) -> Figures:
    """summary.json of a run of the case in a folder of its own."""
    with tempfile.TemporaryDirectory(prefix="copepod-bench-") as folder:
        file, out = Path(folder, "case.yaml"), Path(folder, "run")
        file.write_text(json.dumps(case))
        done = subprocess.run([str(COMMAND), "run", str(file), "--out", str(out)], capture_output=True, text=True)
        if done.returncode != 0:
            raise Stop(done.returncode, f"a benchmark run failed ({done.stderr.strip()[-500:]}).")
        return dict(json.loads((out / "summary.json").read_text()))
