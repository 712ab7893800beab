#!/usr/bin/python3
"""Instructions of the fluid's kernel, the links of bodies, lubrication, the bodies, and the exchange of messages.

    instructions_test.py BUILD            compares them with instructions.json, and writes BUILD/performance.jsonl
    instructions_test.py --write BUILD    makes them those of instructions.json
    instructions_test.py --loops BUILD    prints what the kernel's vector loops consist of (objdump's listing)

Callgrind counts; its processor has AVX2, but not AVX-512, on every machine that has AVX2. A count that is 5 % larger is
a loss, one that is 5 % smaller a gain that should not be lost again: both fail, and --write renews the list once the
reason is known. The list holds for one version of the compiler. performance.jsonl has a line per commit, with rates of
the machine beside the counts.
"""

import argparse
import collections
import json
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from copepod_bench.bench import PUBLISHED

HERE = Path(__file__).resolve().parent
LISTED = HERE / "instructions.json"
TOLERANCE = 0.05
SKIPPED = 77  # for ctest

DOMAIN = (32, 32, 32)
CELLS = DOMAIN[0] * DOMAIN[1] * DOMAIN[2]
SPHERES_ALONG = 3
SPHERES = SPHERES_ALONG**3
STEPS = (2, 10)  # what comes before, between and after the steps cancels
EXCHANGES = (100, 300)
EVERYTHING = ""


def fluid_alone(steps, folder, *options):
    domain = map(str, DOMAIN)
    return ["fluid_benchmark", "--domain", *domain, "--samples", "1", "--steps", str(steps), *options]


def spheres_in_fluid(steps, folder, keys):
    """A run in one process: spheres on a lattice of 12 cells, none at the same place within its cell."""
    places = [(i % 3, i // 3 % 3, i // 9) for i in range(SPHERES)]
    case = {
        "case": "instructions",
        "fluid": {
            "solver": "lattice_boltzmann",
            "density_kg_per_m3": 1360,
            "kinematic_viscosity_m2_per_s": 7.36e-5,
            "cell_size_m": 1e-6,
            "relaxation_time": 2 / 3,
            "domain_cells": [12 * SPHERES_ALONG] * 3,
            **keys.get("fluid", {}),
        },
        "bodies": [
            {
                "name": f"sphere {i}",
                "radius_m": 4e-6,
                "mass_kg": 5.44e-13,
                "position_m": [1e-6 * (12 * n + 6.1 + 0.013 * i) for n in place],
                "velocity_m_per_s": [0.1, 0.2, 0.3],
            }
            for i, place in enumerate(places)
        ],
        "run": {"steps": steps},
        "output": {"trajectory": {"every_steps": steps}},
        **{name: section for name, section in keys.items() if name != "fluid"},
    }
    path = Path(folder, "case.json")
    path.write_text(json.dumps(case))
    words = ["--endpoint", "ipc:///none", "--session", "none", "--log-file", f"{folder}/log"]
    return ["in_process_run", "--run", str(path), "--out", f"{folder}/run_{steps}", *words]


def exchanges_alone(number, folder, bodies):
    return ["exchange_overhead", "alone", str(bodies), str(number)]


_ADVANCE = r"^copepod::fluid::LatticeBoltzmann<.*>::advance\("
_LINKS = r"^copepod::fluid::LatticeBoltzmann<.*>::exchange\("
_BODIES = r"^copepod::body::RigidBodySolver::step\("
_FILMS = r"^copepod::coupler::Lubrication::loads\("
# Command; what is given to it; fewer and more repetitions; {what: (function, how many of it in a repetition)}.
PROGRAMS = (
    (fluid_alone, (), STEPS, {"kernel, double, per cell": (_ADVANCE, CELLS)}),
    (fluid_alone, ("--single",), STEPS, {"kernel, single, per cell": (_ADVANCE, CELLS)}),
    (
        spheres_in_fluid,
        ({},),
        STEPS,
        {
            "links, parabolic, per sphere": (_LINKS, SPHERES),
            "bodies, per sphere": (_BODIES, SPHERES),
            "lubrication, per sphere": (_FILMS, SPHERES),
        },
    ),
    (spheres_in_fluid, (PUBLISHED,), STEPS, {"links, bounce-back, per sphere": (_LINKS, SPHERES)}),
    (exchanges_alone, (3,), EXCHANGES, {"messages, 3 bodies, per exchange": (EVERYTHING, 1)}),
    (exchanges_alone, (1000,), EXCHANGES, {"messages, 1000 bodies, per exchange": (EVERYTHING, 1)}),
)


def callgrind(build, command, folder):
    """Callgrind's file on a run of this program."""
    listing = Path(folder, "callgrind")
    program = [str(build / "bin" / command[0]), *command[1:]]
    tool = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={listing}"]
    done = subprocess.run([*tool, *program], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(program)} ended with {done.returncode} under valgrind:\n{done.stdout}{done.stderr}")
    return listing.read_text()


def spent(listing, function):
    """Instructions of a function and of all that it calls, summed over its calls; EVERYTHING: of the program."""
    if function == EVERYTHING:
        return int(re.search(r"^summary: (\d+)$", listing, re.MULTILINE)[1])
    total, names, callee = 0, {}, ""
    lines = iter(listing.splitlines())
    for line in lines:
        if match := re.match(r"c?fn=\((\d+)\)(?: (.*))?", line):
            names.setdefault(match[1], match[2])
            callee = names[match[1]]
        elif line.startswith("calls=") and re.search(function, callee):
            total += int(next(lines).split()[-1])
    return total


def counts(build):
    """{what: instructions}"""
    found = {}
    for make, arguments, repetitions, wanted in PROGRAMS:
        with tempfile.TemporaryDirectory() as folder:
            fewer, more = (callgrind(build, make(n, folder, *arguments), folder) for n in repetitions)
        for what, (function, per) in wanted.items():
            difference = spent(more, function) - spent(fewer, function)
            if difference <= 0:
                sys.exit(f"{what}: callgrind saw no call of {function} (is it inlined?). Name its caller instead.")
            found[what] = round(difference / (repetitions[1] - repetitions[0]) / per, 1)
    return found


def differences(counted, listed):
    """Sentences on counts that are not within the tolerance."""
    found = []
    for what in counted.keys() | listed.keys():
        if what not in counted or what not in listed:
            found.append(f"{what}: not {'counted' if what in listed else 'listed'}. Renew the list with --write.")
            continue
        change = counted[what] / listed[what] - 1
        if abs(change) > TOLERANCE:
            advice = "Find out why." if change > 0 else "Renew the list with --write."
            found.append(f"{what}: {100 * change:+.1f} % ({counted[what]}, listed {listed[what]}). {advice}")
    return sorted(found)


def git(*words):
    """Empty outside a clone."""
    return subprocess.run(["git", *words], cwd=HERE, capture_output=True, text=True).stdout.strip()


def compiler(build):
    """As the compiler wrote it into a program."""
    section = subprocess.run(
        ["readelf", "-p", ".comment", str(build / "bin/fluid_benchmark")], capture_output=True, text=True, check=True
    )
    return re.search(r"\]\s+(.+)", section.stdout)[1].strip()


def machine(build):
    """Rates of the fluid and of the memory in the same moments, on one core beside whatever else runs; medians."""
    command = [str(build / "bin/fluid_benchmark"), "--domain", "60", "60", "120", "--samples", "3"]
    measured = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    shares = [a / b for a, b in zip(measured["fluid_mlups"], measured["streams_mcells_per_s"])]
    rates = {
        name: round(statistics.median(measured[name]), 1)
        for name in ("fluid_mlups", "streams_mcells_per_s", "copy_gb_per_s")
    }
    return {"kernel": measured["kernel"], **rates, "fluid_over_streams": round(statistics.median(shares), 2)}


def keep(line, file):
    """A line per commit; one of the same commit is replaced."""
    lines = [json.loads(text) for text in file.read_text().splitlines()] if file.exists() else []
    lines = [one for one in lines if one["commit"] != line["commit"]] + [line]
    file.write_text("".join(json.dumps(one) + "\n" for one in lines))


def check(build, writes):
    """Exit code."""
    if not shutil.which("valgrind"):
        print("skipped: valgrind is missing (deploy/copepod setup --ci installs it).")
        return SKIPPED
    used, rates, counted = compiler(build), machine(build), counts(build)
    line = {"commit": git("describe", "--always", "--dirty", "--abbrev=12", "--exclude=*")}
    line |= {"date": git("log", "-1", "--format=%cI"), "compiler": used, "instructions": counted, "rates": rates}
    keep(line, build / "performance.jsonl")
    if writes:
        LISTED.write_text(json.dumps({"compiler": used, "instructions": counted}, indent=2) + "\n")
        return 0
    print(json.dumps(line, indent=2))
    listed = json.loads(LISTED.read_text())
    if used != listed["compiler"] or rates["kernel"] not in ("avx2", "avx512"):
        print(f"skipped: the listed counts are those of {listed['compiler']} with AVX2.")
        return SKIPPED
    found = differences(counted, listed["instructions"])
    print("\n".join(found))
    return 1 if found else 0


LINE = re.compile(r"^\s+([0-9a-f]+):\t(\S+)\s*(.*)$")
FUNCTION = re.compile(
    r"^[0-9a-f]+ <.*StreamCollideLoop<.*VectorsOf<(32|64)>, (float|double)>::rows<(true|false), .*CollisionForm{}>"
)
CLASSES = (
    ("arithmetic", re.compile(r"v(add|sub|mul)p[sd]")),
    ("division", re.compile(r"vdivp[sd]")),
    ("fused multiply-add", re.compile(r"vfn?m(add|sub)\d+p[sd]")),
    ("vector load", re.compile(r"vmov\w+:load")),
    ("vector store", re.compile(r"vmov\w+:store")),
    ("stack", re.compile(r"vmov\w+:stack")),
    ("prefetch", re.compile(r"prefetch\w*")),
)


def loops(binary):
    """(name, instructions) of the vector loop of each AVX2 and AVX-512 instantiation without a body force."""
    text = subprocess.run(
        ["objdump", "-dC", "--no-show-raw-insn", str(binary)], capture_output=True, text=True, check=True
    )
    function, widest, body = None, "", []
    for line in text.stdout.splitlines() + [""]:
        if instruction := LINE.match(line):
            if function:
                body.append((int(instruction[1], 16), instruction[2], instruction[3]))
            continue
        if function and body:
            yield function, vector_loop(body, widest)
        header = FUNCTION.match(line)
        function = None
        if header:
            widest, name = {"32": ("%ymm", "AVX2"), "64": ("%zmm", "AVX-512")}[header[1]]
            precision = "double" if header[2] == "double" else "single"
            function = f"{name}, {precision}, {'streamed to home' if header[3] == 'true' else 'home to streamed'}"
        body = []


def vector_loop(body, widest):
    """The innermost loop with a division of the widest vectors: the shortest backward jump around one."""
    divisions = [a for a, name, operands in body if re.fullmatch(r"vdivp[sd]", name) and widest in operands]
    best = None
    for address, name, operands in body:
        target = re.match(r"([0-9a-f]+)\b", operands)
        if not name.startswith("j") or not target:
            continue
        start = int(target[1], 16)
        if start < address and any(start <= division <= address for division in divisions):
            inside = [(n, o) for a, n, o in body if start <= a <= address]
            if best is None or len(inside) < len(best):
                best = inside
    return best or []


def kind(name, operands):
    """Name of an instruction, with where it moves a whole vector from or to."""
    if not name.startswith("vmov") or not re.search("%[yz]mm", operands) or "(" not in operands:
        return name
    if "(%rsp" in operands:
        return name + ":stack"
    return name + (":store" if operands.startswith(("%ymm", "%zmm")) else ":load")


def print_loops(binary):
    print("| vector loop | cells | instructions | " + " | ".join(name for name, _ in CLASSES) + " |")
    print("|---|" + "---|" * (len(CLASSES) + 2))
    for name, loop in loops(binary):
        counted = collections.Counter(kind(*instruction) for instruction in loop)
        shares = [sum(n for k, n in counted.items() if pattern.fullmatch(k)) for _, pattern in CLASSES]
        width = (32 if "AVX2" in name else 64) // (8 if "double" in name else 4)
        print(f"| {name} | {width} | {len(loop)} | " + " | ".join(map(str, shares)) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=Path)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--loops", action="store_true")
    options = parser.parse_args()
    if options.loops:
        return print_loops(options.build / "bin/fluid_benchmark")
    return check(options.build.resolve(), options.write)


if __name__ == "__main__":
    sys.exit(main())
