#!/usr/bin/python3
"""What the fluid kernel is made of: instructions of its vector loop by class, and instructions per cell update.

    tests/benchmark/kernel_instructions.py [build/bin/fluid_benchmark]

The listing is objdump's; the loop is the longest backward jump of each instantiation. The count is callgrind's: two
runs that differ in their number of steps only, so that everything but the steps cancels. Both repeat exactly for the
same binary.
"""

import collections
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
DOMAIN = (32, 32, 32)
STEPS = (4, 24)

LINE = re.compile(r"^\s+([0-9a-f]+):\t(\S+)\s*(.*)$")
FUNCTION = re.compile(
    r"^[0-9a-f]+ <(.*StreamCollideLoop<.*(Avx2|Avx512), (float|double)>::rows<(true|false), (true|false)>.*)>:$"
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
        if header and header[5] == "false":
            widest = {"Avx2": "%ymm", "Avx512": "%zmm"}[header[2]]
            way = "streamed to home" if header[4] == "true" else "home to streamed"
            function = f"{header[2]}, {header[3]}, {way}"
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


def instructions_per_cell(binary, *options):
    """Callgrind's count between two numbers of steps, per cell update of the whole program."""
    counts = []
    with tempfile.TemporaryDirectory() as folder:
        for steps in STEPS:
            command = [
                "valgrind",
                "--tool=callgrind",
                f"--callgrind-out-file={folder}/out",
                str(binary),
                "--domain",
                *map(str, DOMAIN),
                "--samples",
                "1",
                "--steps",
                str(steps),
                *options,
            ]
            subprocess.run(command, capture_output=True, check=True)
            listing = Path(folder, "out").read_text()
            counts.append(functions_total(listing))
    cells = DOMAIN[0] * DOMAIN[1] * DOMAIN[2]
    return (counts[1] - counts[0]) / (STEPS[1] - STEPS[0]) / cells


def functions_total(listing):
    """Instructions spent in LatticeBoltzmann::advance and all that it calls, from a callgrind file."""
    total, inside = 0, False
    names = {}
    for line in listing.splitlines():
        if match := re.match(r"(c?fn)=\((\d+)\)(?: (.*))?", line):
            if match[3]:
                names[match[2]] = match[3]
            name = names[match[2]]
            if match[1] == "fn":
                inside = False
            else:
                inside = "LatticeBoltzmann" in name and "::advance" in name
        elif line.startswith("calls=") and inside:
            inside = "count"
        elif inside == "count":
            total += int(line.split()[-1])
            inside = False
    return total


def main():
    binary = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "build/bin/fluid_benchmark"
    print("| vector loop | cells | instructions | " + " | ".join(name for name, _ in CLASSES) + " |")
    print("|---|" + "---|" * (len(CLASSES) + 2))
    for name, loop in loops(binary):
        counted = collections.Counter(kind(*instruction) for instruction in loop)
        shares = [sum(n for k, n in counted.items() if pattern.fullmatch(k)) for _, pattern in CLASSES]
        width = (32 if "Avx2" in name else 64) // (8 if "double" in name else 4)
        print(f"| {name} | {width} | {len(loop)} | " + " | ".join(map(str, shares)) + " |")
    print()
    print("| instructions per cell update, the whole step | |\n|---|---|")
    for options in ((), ("--single",)):
        print(f"| {'single' if options else 'double'} | {instructions_per_cell(binary, *options):.1f} |")


if __name__ == "__main__":
    main()
