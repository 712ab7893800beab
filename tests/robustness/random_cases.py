#!/usr/bin/python3
"""Runs of cases drawn at random must not depend on ranks, transport, threads, or on stopping and resuming.

    tests/robustness/random_cases.py                             300 cases, each in nine ways
    tests/robustness/random_cases.py --ways local                in six of them, all in one process: three times as fast
    tests/robustness/random_cases.py --seed 36 --count 20 --ways some   as the test suite does
    tests/robustness/random_cases.py --shapes                    with bodies of all shapes and obstacles
    tests/robustness/random_cases.py --controllers               with controllers: services, in five ways
    tests/robustness/random_cases.py --write FILE                one run per case; its seed and digest, to compare with
    tests/robustness/random_cases.py --against FILE              one run per case of the file, by another build

The seed decides the case (drawn_case.py) and its ways. A run in one process on one rank is compared with runs on other
ranks, of services over ipc and tcp, with one that continues from a checkpoint of the first with other ranks and another
transport, as after a loss, and with simulations, with services and without, that are stepped and return to a snapshot
after they were steered: digest, drifts, speeds of swimmers and groups, and byte by byte trajectory, loads on obstacles,
samples of the flow and cycles. A run that fails must fail in the same way, after the same trajectory. One line per
case; cases that differ are kept in the folder of --keep.
"""

import argparse
import json
import os
import random
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path

from drawn_case import draw, stop_step, with_controllers

ROOT = Path(__file__).resolve().parent.parent.parent
PROGRAMS = Path(os.environ.get("COPEPOD_BUILT_PROGRAMS", ROOT / "build/bin"))
ENVIRONMENT = {**os.environ, "COPEPOD_BIN_DIR": str(PROGRAMS)}
STEPPED = ROOT / "tests/robustness/stepped_run.py"
MOST_ATTEMPTS = 30
CONTROLLER = ["/usr/bin/python3", str(ROOT / "tests/robustness/drawn_controller.py")]
LONGEST_S = 600  # a run of a second or two that takes longer is stuck, however busy the machine


@dataclass
class Outcome:
    """What came of a run, apart from times, ranks and hosts."""

    code: int
    digest: str = ""
    reason: str = ""
    step: str = ""  # at which it failed
    rest: dict = field(default_factory=dict)  # file or part of the summary: content

    @property
    def words(self):
        return self.digest if self.code == 0 else f"failed {self.code}"


@dataclass(frozen=True)
class Way:
    """How a case is run."""

    transport: str
    ranks: int
    threads: int = 1
    resumes: bool = False

    def __str__(self):
        resumed = ", resumed" if self.resumes else ""
        return f"{self.transport} on {self.ranks}{resumed}"


BASES = {False: Way("in_process", 1), True: Way("ipc", 1)}  # by whether there are controllers


def ways(seed, which):
    """Ways to compare with the base: all, the local ones, two that the seed decides, or of services alone."""
    choose = random.Random(seed)

    def any_ranks():
        return choose.randint(1, 4)

    def any_threads():
        return choose.randint(1, 3)

    resumed_by = choose.choice(["in_process", "in_process", "ipc", "tcp"])
    local = [Way("in_process", ranks, any_threads()) for ranks in (2, 3, 4)]
    local.append(Way("stepped", any_ranks(), any_threads()))
    remote = [Way(transport, any_ranks(), any_threads()) for transport in ("ipc", "tcp")]
    remote.append(Way("stepped services", any_ranks(), any_threads()))
    resumed = Way("in_process" if which == "local" else resumed_by, choose.randint(2, 4), any_threads(), resumes=True)
    if which == "services":
        return [*remote, replace(resumed, transport="ipc")]
    if which == "some":  # services in every second case: they take long to start
        return [choose.choice(choose.choice([local, remote])), resumed]
    return [*local, *(remote if which == "all" else []), resumed]


def drawn(seed, number, shapes, controllers):
    case = draw(seed, number, shapes)
    return with_controllers(case, seed, CONTROLLER) if controllers else case


def accepted_case(seed, shapes, folder, attempt=None, controllers=False):
    """(attempt, its file) of the first attempt that `check` accepts, or of a given one if it accepts that."""
    for number in range(MOST_ATTEMPTS) if attempt is None else (attempt,):
        file = folder / "case.yaml"
        case = drawn(seed, number, shapes, controllers)
        file.write_text(json.dumps(case, indent=1))
        if case and _call([PROGRAMS / "in_process_run", "--plan", file], folder).returncode == 0:
            return number, file
    return None, None


def run(case, folder, way):
    """Outcome of a run in `folder`, which does not exist yet, or holds what a resumed run continues."""
    settings = ["--set", f"services.fluid.ranks={way.ranks}", "--set", f"services.body.threads={way.threads}"]
    resume = ["--resume"] if way.resumes else []
    if way.transport.startswith("stepped"):
        words = [*settings[1::2], *way.transport.split()[1:]]
        return _outcome(folder, _call([STEPPED, case, folder, way.ranks, *words], folder.parent))
    if way.transport == "in_process":
        command = [PROGRAMS / "in_process_run", "--run", case, "--endpoint", "none", "--session", "none"]
        settings += ["--set", "services.transport=in_process"]
    else:
        command = [ROOT / "deploy/copepod", "run", case, "-q"]
        if way.transport == "tcp":
            settings += ["--set", f"services.transport=tcp://127.0.0.1:{_free_port()}"]
    ended = _call([*command, "--out", folder, *settings, *resume], folder.parent)
    return _outcome(folder, ended)


def _call(command, folder):
    return subprocess.run(
        [str(word) for word in command],
        cwd=folder,
        env=ENVIRONMENT,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=LONGEST_S,
    )


def _free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


def _outcome(folder, ended):
    if ended.returncode not in (0, 70):
        return Outcome(ended.returncode, reason=(ended.stderr or ended.stdout).strip()[-400:])
    rest = {}
    for table in ("trajectory", "obstacles", "flow", "coefficients"):
        for path in (folder / f"{table}.csv", folder / f"{table}.npy"):
            rest |= {table: path.read_bytes()} if path.exists() else {}
    if ended.returncode == 70:
        step = re.search(r'"step":(\d+),"reason"|at step (\d+): ', ended.stdout + ended.stderr)
        reason = json.loads((folder / "provenance.json").read_text())["exit_reason"]
        reason = re.sub(r"^.*, rank \d+, (at|after) step \d+: ", "", reason)
        return Outcome(70, reason=reason, step=step[1] or step[2] if step else "", rest=rest)
    summary = json.loads((folder / "summary.json").read_text())
    for key in ("steps", "mass_drift", "momentum_drift", "swimmers", "groups", "coefficients", "flow"):
        rest[key] = summary.get(key)
    cycles = folder / "cycles.csv"
    rest["cycles"] = cycles.read_bytes() if cycles.exists() else b""
    return Outcome(0, summary["digest"], rest=rest)


def _interrupted(base, folder, step):
    """The folder of a run as it is when all its processes were killed some time after a step."""
    shutil.copytree(base, folder)
    (folder / "summary.json").unlink(missing_ok=True)
    for checkpoint in (folder / "checkpoints").iterdir():
        if checkpoint.name != f"step_{step:09}":
            shutil.rmtree(checkpoint)
    return folder


def differences(base, other, way):
    """Names of what differs. Runs that fail must do so at the same step for the same reason, but for the cell that a
    rank found and the rows that a table got before. A stepped run may find at another step that its flow diverged: it
    has snapshots in place of checkpoints, before both of which all cells are looked at."""
    if base.code != other.code:
        return [f"exit code {base.code} and {other.code} ({other.reason or base.reason})"]
    if base.code not in (0, 70):
        return [f"exit code {base.code} ({base.reason})"]
    found = ["digest"] if base.digest != other.digest else []
    diverged = all(run.code == 70 and run.reason.startswith("the flow diverged") for run in (base, other))
    if diverged and way.transport.startswith("stepped"):
        return []
    if base.step != other.step or _without_numbers(base.reason) != _without_numbers(other.reason):
        found.append(f"failure (step {base.step}: {base.reason}; step {other.step}: {other.reason})")
    if base.code == 0:
        return found + [key for key, value in base.rest.items() if other.rest.get(key) != value]
    one, two = base.rest.get("trajectory", b""), other.rest.get("trajectory", b"")
    if one.startswith(b"\x93NUMPY"):  # behind the head, which has the number of samples
        rows = slice(1024, min(len(one), len(two)))
    else:
        rows = slice(min(one.rfind(b"\n"), two.rfind(b"\n")))
    return found + (["trajectory before the failure"] if one[rows] != two[rows] else [])


def _without_numbers(text):
    return re.sub(r"[-+.\d]+(e[-+]?\d+)?", "0", text)


@dataclass
class Result:
    """What came of a case."""

    seed: int
    attempt: int
    words: str
    problems: list
    seconds: float = 0.0


def compare(seed, shapes, which, keep, controllers=False):
    """Result of a case in the base way and others."""
    start = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="copepod_random_") as name:
        folder = Path(name).resolve()
        attempt, case = accepted_case(seed, shapes, folder, None, controllers)
        if case is None:
            return Result(seed, -1, "no case", [f"none of {MOST_ATTEMPTS} attempts is accepted"])
        base = run(case, folder / "base", BASES[controllers])
        problems = [] if base.code in (0, 70) else [f"exit code {base.code}: {base.reason}"]
        step = stop_step(draw(seed, attempt, shapes))
        for way in ways(seed, "services" if controllers else which):
            out = folder / str(way).replace(" ", "_")
            if way.resumes:
                if not (folder / f"base/checkpoints/step_{step:09}").exists():  # failed before
                    continue
                _interrupted(folder / "base", out, step)
            found = differences(base, run(case, out, way), way)
            problems += [f"{way}: {', '.join(found)}"] if found else []
        if problems and keep:
            shutil.copytree(folder, keep / f"seed_{seed}", dirs_exist_ok=True)
        words = base.words + (f" (step {base.step}: {base.reason.split(' (')[0]})" if base.code else "")
        return Result(seed, attempt, words, problems, time.monotonic() - start)


def run_once(seed, shapes, attempt, expected):
    """Result of the base run alone, and of its digest against that of a file, if there is one."""
    with tempfile.TemporaryDirectory(prefix="copepod_random_") as name:
        folder = Path(name).resolve()
        found, case = accepted_case(seed, shapes, folder, attempt)
        if case is None:
            return Result(seed, attempt or -1, "refused", ["refused"] if expected != "refused" else [])
        base = run(case, folder / "base", BASES[False])
        problems = [f"expected {expected}"] if expected not in (None, base.words) else []
        return Result(seed, found, base.words, problems)


def _print(result):
    problems = "".join(f"\n    {problem}" for problem in result.problems)
    seconds = f"  {result.seconds:.1f} s" if result.seconds else ""
    attempt = f".{result.attempt}" if result.attempt else ""
    print(f"{result.seed}{attempt}: {result.words}{seconds}{problems}", flush=True)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__.split("\n\n", 1)[0],
        epilog=__doc__.split("\n\n", 1)[1],
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--count", type=int, default=300, metavar="N", help="cases (300)")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the first case (1); the next ones follow")
    parser.add_argument("--ways", choices=("all", "local", "some"), default="all", help="of running each case (all)")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="cases at a time (1)")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="copy cases and runs that differ to this folder")
    parser.add_argument("--write", type=Path, metavar="FILE", help="run each case once; write seed, attempt and digest")
    parser.add_argument("--against", type=Path, metavar="FILE", help="run the cases of such a file once, and compare")
    parser.add_argument("--shapes", action="store_true", help="bodies of all shapes, and obstacles")
    parser.add_argument("--controllers", action="store_true", help="controllers set what drives the bodies")
    options = parser.parse_args()
    seeds = range(options.seed, options.seed + options.count)
    with ThreadPoolExecutor(options.jobs) as pool:
        if options.against:
            lines = [line.split(" ", 2) for line in options.against.read_text().splitlines()]
            results = pool.map(lambda line: run_once(int(line[0]), options.shapes, int(line[1]), line[2]), lines)
        elif options.write:
            results = pool.map(lambda seed: run_once(seed, options.shapes, None, None), seeds)
        else:
            how = (options.shapes, options.ways, options.keep, options.controllers)
            results = pool.map(lambda seed: compare(seed, *how), seeds)
        done = []
        for result in results:
            done.append(result)
            _print(result)
    if options.write:
        options.write.write_text("".join(f"{r.seed} {r.attempt} {r.words}\n" for r in done))
    wrong = [result.seed for result in done if result.problems]
    failed = sum(result.words.startswith("failed") for result in done)
    print(f"\n{len(done)} cases, {failed} of which fail, {len(wrong)} that differ" + (f": {wrong}" if wrong else ""))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
