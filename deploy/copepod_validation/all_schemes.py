"""Every combination of scheme, relaxation time, motion and frame, beside the same case of the most accurate scheme.
docs/results/all_schemes.md has what is compared, and how closely."""

import datetime
import itertools
import json
import os
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from copepod_report.trajectory import Trajectory
from copepod_run.checkout import ROOT, program
from copepod_run.errors import ExitCode
from copepod_run.figures import markdown_table
from copepod_run.messages import Stage
from copepod_run.run_directory import make_folder
from copepod_validation.experiment import CaseDict, lattice_case, sphere, viscosity
from copepod_validation.matrix import processor

_COLLISIONS = ("bgk", "trt", "central_moments")
_BOUNDARIES = ("bounce_back", "interpolated", "central_linear", "parabolic")
_REFILLS, _PRECISIONS = ("nonequilibrium", "equilibrium", "grad"), ("double", "single")
_TAUS = (0.51, 0.55, 0.6, 0.667, 0.8, 1.0, 1.5, 2.0, 3.0)
# Density over the fluid's, if free.
_MOTIONS = {"fixed": None, "driven": None, "heavy": 2.0, "light": 0.1, "lightest": 0.01}
_LIMIT = {2.0: 10.0, 4.0: 5.0, 8.0: 3.0}  # of deviations [%], by radius
_WAY, _AXIS, _FRAME = np.array((0.36, 0.48, 0.8)), np.array((0.48, 0.64, -0.6)), np.array((0.8, -0.6, 0.1))
_SMOOTH_STEPS = 15
_VERDICTS = ("right", "warned", "refused", "wrong")
Row = dict[str, Any]


class Combination(NamedTuple):
    collision: str = "trt"
    moving_boundary: str = "parabolic"
    refill: str = "nonequilibrium"
    precision: str = "double"
    tau: float = 1.0
    motion: str = "fixed"
    radius: float = 4.0
    carried: bool = False

    @property
    def reference(self) -> "Combination":
        return Combination(tau=self.tau, motion=self.motion, radius=self.radius)

    @property
    def steps(self) -> int:
        """In which momentum spreads over more than a cell, and an instability grows."""
        return {0.51: 2400, 0.55: 600}.get(self.tau, 300)

    @property
    def limit(self) -> float:
        """More for a staircase, and where hardly anything damps the noise of crossing cells."""
        return _LIMIT[self.radius] * (2.4 if self.moving_boundary == "bounce_back" else 1) * (1 + (self.tau < 0.55))


def combinations(fast: bool) -> Iterator[Combination]:
    """All, or the fast subset; refills only where cells change."""
    choices = (_REFILLS[:1], _PRECISIONS[:1], (0.55, 1.0, 2.0)) if fast else (_REFILLS, _PRECISIONS, _TAUS)
    radii = (2.0, 4.0) if fast else _LIMIT
    for words in itertools.product(_COLLISIONS, _BOUNDARIES, *choices, _MOTIONS, radii, (False, True)):
        one = Combination(*words)
        if one.motion != "fixed" or one.carried or one.refill == one.reference.refill:
            yield one


def case_of(one: Combination) -> CaseDict:
    """A sphere in a periodic cube that starts with the velocity of the fluid. A body force then drives the fluid past a
    sphere that it does not move; one period of a force and a torque moves a free one."""
    nu, displaced, per_step = viscosity(one.tau), 4.18879 * one.radius**3, 2 * np.pi / one.steps
    speed = min(0.02, 0.3 * nu)  # relative to the fluid, in cells per step; twice that of a surface that turns
    spin, drag = 0.5 * speed / one.radius, 6 * np.pi * nu * one.radius * speed
    cells, density = int(6 * one.radius), _MOTIONS[one.motion]
    moves = one.motion == "driven" and one != one.reference  # which turns where it is
    start = (2 * speed * one.carried * _FRAME + speed * moves * _WAY).tolist()
    motion = "free" if density else "prescribed" if one.carried or one.motion == "driven" else "fixed"
    body = sphere(one.radius, [0.5 * cells + shift for shift in (0.13, -0.21, 0.37)], motion, density or 1.0)
    if motion != "fixed":
        body["velocity_m_per_s"] = start
    if one.motion == "driven":
        body["angular_velocity_rad_per_s"] = (spin * _AXIS).tolist()
    fluid: CaseDict = {key: getattr(one, key) for key in ("collision", "moving_boundary", "refill", "precision")}
    fluid["initial_flow"] = {"kind": "uniform", "velocity_m_per_s": start}
    if not density:
        fluid["body_force_N_per_m3"] = (-(speed / one.steps + 2 * drag / cells**3) * _WAY).tolist()
    case = lattice_case([cells] * 3, one.tau, "periodic", [body], one.steps, **fluid)
    case["output"]["bodies"] = {"every_steps": 0}
    if density:
        force = drag + (density + 0.5) * displaced * per_step * speed
        torque = (8 * np.pi * nu * one.radius + 0.4 * (density + 0.2) * displaced * per_step) * one.radius**2 * spin
        drives = (("world_force", _WAY, "amplitude_N", force), ("world_torque", _AXIS, "amplitude_N_m", torque))
        case["actuators"] = [
            {"kind": kind, "body": "sphere", "direction": way.tolist()}
            | {"signal": {"kind": "sinusoid", "period_steps": one.steps, unit: float(amplitude)}}
            for kind, way, unit, amplitude in drives
        ]
    return {"case": "combination", **case}


def run(one: Combination) -> tuple[str, np.ndarray | None, str]:
    """Verdict, or "" if the motion decides; motion, if the run finished; warnings, and what refused or ended it. The
    process checks the case as `copepod check` does."""
    with tempfile.TemporaryDirectory(prefix="copepod-") as name:
        folder = Path(name)
        (folder / "case.json").write_text(json.dumps(case_of(one)))
        words: list[str | Path] = [program("in_process_run"), "--run", folder / "case.json", "--out", folder / "run"]
        words += ["--endpoint", "ipc:///none", "--session", "none", "--log-file", folder / "log"]
        ended = subprocess.run(words, stdin=subprocess.DEVNULL, capture_output=True, text=True)
        if ended.returncode == ExitCode.BAD_CASE:
            return "refused", None, ended.stderr.strip()
        log = (folder / "log").read_text().splitlines()
        messages = [line.partition(" coupler ")[2] for line in log if " warning coupler " in line]
        verdict = "warned" if messages else ""
        if ended.returncode == 0:
            return verdict, _motion(one, Trajectory(folder / "run")), "; ".join(messages)
        return verdict, None, "; ".join([*messages, json.loads(ended.stdout.splitlines()[-1])["reason"]])


def _motion(one: Combination, trajectory: Trajectory) -> np.ndarray:
    """Of a free body velocities in the frame of the fluid, else loads as it receives them; translation and rotation in
    the last two thirds of the steps, shape (steps, 6)."""
    found = trajectory.of("sphere")
    if _MOTIONS[one.motion]:
        moved = found["velocity_m_per_s"] - found["velocity_m_per_s"][0]
        return np.hstack([moved, found["angular_velocity_rad_per_s"] * one.radius])[one.steps // 3 :]
    loads = np.hstack([found["force_N"], found["torque_N_m"] / one.radius])
    return (0.5 * (loads[1:] + loads[:-1]))[one.steps // 3 :]


def judged(chosen: Sequence[Combination], jobs: int | None, build: str, kept: Path) -> list[Row]:
    """Runs them and before them their references, several at once, and adds a line to `kept` for each. What it has
    from programs of this build is not run again."""
    rows = {row: verdict for row, verdict in _read(kept, build)}
    left, cores = [one for one in chosen if one not in rows], len(os.sched_getaffinity(0))
    make_folder(kept.parent)
    references = list(dict.fromkeys(one.reference for one in left))
    with Stage("combinations") as stage, kept.open("a") as file, ThreadPoolExecutor(jobs or cores) as pool:
        expected = {one: motion for one, (_, motion, _) in zip(references, pool.map(run, references))}
        for one, (verdict, motion, message) in zip(left, pool.map(run, left)):
            deviation = _deviation_percent(motion, expected[one.reference])
            verdict = verdict or ("right" if deviation <= one.limit else "wrong")
            rows[one] = {"verdict": verdict, "deviation": deviation, "limit": one.limit, "message": message}
            file.write(json.dumps(one._asdict() | rows[one] | {"build": build}) + "\n")
            file.flush()
            stage.count(len(rows), len(chosen))
    return [one._asdict() | rows[one] for one in chosen]


def _read(kept: Path, build: str) -> Iterator[tuple[Combination, Row]]:
    """What this build has found; the file keeps nothing else, such as a line that was cut off."""
    lines = kept.read_text().splitlines(keepends=True) if kept.exists() else []
    own = [line for line in lines if line.endswith(f'"build": "{build}"}}\n')]
    if own != lines:
        kept.write_text("".join(own))
    for row in map(json.loads, own):
        yield Combination(*map(row.pop, Combination._fields)), row


def _deviation_percent(motion: np.ndarray | None, expected: np.ndarray | None) -> float:
    """From what is expected, or from its own mean; infinite without either."""
    if motion is None or expected is None:
        return np.inf
    edge, window = _SMOOTH_STEPS // 2, np.ones(_SMOOTH_STEPS) / _SMOOTH_STEPS
    mean = np.transpose([np.convolve(component, window, "valid") for component in motion.T])
    differences = (motion - expected, motion[edge:-edge] - mean)
    return round(100 * np.sqrt(max(np.mean(each**2) for each in differences) / np.mean(expected**2)), 1)


def write(folder: Path, rows: Sequence[Row], command: str, build: str) -> Path:
    """The tables of the page, below its text."""
    grouped: dict[str, list[Row]] = {}
    for row in rows:
        grouped.setdefault("{collision} | {moving_boundary} | {tau:g}".format(**row), []).append(row)
    lines = []
    for group, found in grouped.items():
        counts = [sum(row["verdict"] == one for row in found) for one in _VERDICTS]
        useless = sum(row["verdict"] == "warned" and row["deviation"] <= row["limit"] for row in found)
        largest = max((row["deviation"] for row in found if row["verdict"] in ("right", "wrong")), default="–")
        lines.append(" | ".join(map(str, [group, *counts, useless, largest])))
    heads = " | ".join(["collision | boundary | τ", *_VERDICTS, "useless warnings", "largest deviation [%]"])
    wrong = [f"* {', '.join(map(str, row.values()))}" for row in rows if row["verdict"] == "wrong"]
    parts = [
        (ROOT / "docs/results/all_schemes.md").read_text().partition("\n## By scheme")[0].strip(),
        f"## By scheme\n\n`{command}`, {datetime.date.today()} ({processor()}; programs {build}):",
        markdown_table(heads, lines),
        "## Wrong\n\n" + ("\n".join(wrong) or "None."),
    ]
    path = folder / "all_schemes.md"
    path.write_text("\n\n".join(parts) + "\n")
    return path


def write_errors(folder: Path, rows: Sequence[Row]) -> Path:
    """What `check` warns of: the largest deviations, by collision, boundary, motion, radius and relaxation time."""
    largest: dict[tuple[Any, ...], float] = {}
    for row in rows:
        key = tuple(row[name] for name in ("collision", "moving_boundary", "motion", "radius", "tau"))
        deviation = row["deviation"] if row["deviation"] < 99.0 else 99.0  # NaN where it diverged
        largest[key] = max(largest.get(key, 0.0), deviation)
    lines = [f"// Written by `copepod validate --all`, {datetime.date.today()}.\n"]
    for words in itertools.product(_COLLISIONS, _BOUNDARIES, _MOTIONS):
        by_radius = ("{" + ", ".join(str(largest[*words, radius, tau]) for tau in _TAUS) + "}" for radius in _LIMIT)
        names = "CollisionKind::{}, MovingBoundary::{}, Sphere::{}".format(*words)
        lines.append(f"SchemeErrors{{{names}, {{{{{', '.join(by_radius)}}}}}}},\n")
    path = folder / "scheme_errors.inc"
    path.write_text("".join(lines))
    return path
