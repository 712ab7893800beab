#!/usr/bin/python3
"""Measures the peak memory of every process of short runs and sets it beside what `copepod check` predicts.

    tests/integration/memory_peaks.py        prints the table of docs/results/memory.md
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "deploy"))

CASE = """
case: memory
fluid:
  solver: lattice_boltzmann
  density_kg_per_m3: 1360
  kinematic_viscosity_m2_per_s: 7.36e-5
  cell_size_m: 1.0e-6
  relaxation_time: 0.6666666666666667
  domain_cells: [{cells}]
  precision: {precision}
bodies:
  - {{name: ball, shape: sphere, radius_m: 4.0e-6, mass_kg: 5.44e-13, position_m: [24.0e-6, 24.0e-6, 24.0e-6]}}
run: {{steps: {steps}}}
output: {output}
services: {{fluid: {{ranks: {ranks}}}}}
"""
DOMAINS = ((48, 48, 48), (50, 50, 200), (100, 100, 200))
CHECKPOINTS = "{checkpoint: {every_steps: 20}}"
MEAN = "{fields: {mean_over_steps: [0, 10], mean_every_steps: 1}}"
_CELL_UPDATES = 6e7  # about a second
_WRITE_PEAK = r"""
#define _GNU_SOURCE
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>

__attribute__((destructor)) static void write_peak(void) {
    char line[256];
    long peak = 0;
    FILE* status = fopen("/proc/self/status", "r");
    while (status && fgets(line, sizeof line, status))
        if (sscanf(line, "VmHWM: %ld", &peak) == 1) break;
    FILE* peaks = fopen(getenv("PEAKS"), "a");
    if (peaks) fprintf(peaks, "%s %ld\n", program_invocation_short_name, peak);
    if (peaks) fclose(peaks);
}
"""
_PROGRAMS = {
    "fluid_service": "fluid",
    "bullet_body_service": "body",
    "mujoco_body_service": "body",
    "body_service": "body",
    "coupler": "coupler",
    "in_process_run": "coupler",
}


def measure(programs, folder, cells, precision, ranks, output="{}", overrides=()):
    """{component: (predicted, measured) peak of its largest process [bytes]} of one run."""
    steps = max(20, int(_CELL_UPDATES / (cells[0] * cells[1] * cells[2])))
    case = Path(folder) / "case.yaml"
    case.write_text(
        CASE.format(cells=", ".join(map(str, cells)), precision=precision, ranks=ranks, steps=steps, output=output)
    )
    settings = [word for override in overrides for word in ("--set", override)]
    plan = json.loads(_output_of(programs / "coupler", "--plan", case, *settings))
    predicted = {"coupler": plan["estimate"]["memory_of"]["coupler_bytes"]}
    solver = plan["services"]["body"].get("solver", "own")
    bodies = "body_service" if solver == "own" else f"{solver}_body_service"
    for role, program in (("fluid", "fluid_service"), ("body", bodies)):
        setup = bytes.fromhex(plan["setups"][role])
        answer = _output_of(programs / program, "--estimate", "--ranks", str(ranks), given=setup)
        predicted[role] = json.loads(answer)["memory_bytes"]
    if plan["services"]["transport"] == "in_process":
        setup = bytes.fromhex(plan["setups"]["fluid"])
        answer = _output_of(programs / "in_process_run", "--estimate", "--ranks", str(ranks), given=setup)
        predicted["coupler"] += ranks * json.loads(answer)["memory_bytes"]
        predicted["fluid"] = predicted["body"] = 0
    measured = _peaks_of_run(programs, folder, [case, *settings])
    return {role: (predicted[role], measured.get(role, 0)) for role in ("fluid", "body", "coupler")}


def _output_of(*command, given=b""):
    return subprocess.run(command, check=True, input=given, stdout=subprocess.PIPE).stdout


def _peaks_of_run(programs, folder, arguments):
    """{component: largest VmHWM of its processes [bytes]}, as each writes it down when it ends."""
    library, peaks_file = Path(folder) / "peak.so", Path(folder) / "peaks"
    compiler = ["cc", "-x", "c", "-shared", "-fPIC", "-o", library, "-"]
    subprocess.run(compiler, check=True, input=_WRITE_PEAK, text=True)
    peaks_file.unlink(missing_ok=True)
    variables = {"COPEPOD_BIN_DIR": str(programs), "LD_PRELOAD": str(library), "PEAKS": str(peaks_file)}
    run = [ROOT / "deploy/copepod", "run", *arguments]
    done = subprocess.run(run, cwd=folder, env={**os.environ, **variables}, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(done.stderr)
    peaks = {}
    for program, peak in (line.split() for line in peaks_file.read_text().splitlines()):
        if component := _PROGRAMS.get(program):
            peaks[component] = max(peaks.get(component, 0), 1024 * int(peak))
    return peaks


def main():
    programs = Path(os.environ.get("COPEPOD_BUILT_PROGRAMS", ROOT / "build/bin"))
    print("| domain | precision | ranks | files | fluid rank: predicted | measured [MiB] | bodies | coupler |")
    print("|---|---|---|---|---|---|---|---|")
    rows = [
        (cells, precision, ranks, "{}") for cells in DOMAINS for precision in ("double", "single") for ranks in (1, 2)
    ]
    rows += [
        (DOMAINS[1], "double", 2, MEAN),
        (DOMAINS[2], "single", 1, MEAN),
        (DOMAINS[0], "double", 1, CHECKPOINTS),
        (DOMAINS[2], "double", 1, CHECKPOINTS),
        (DOMAINS[2], "single", 2, CHECKPOINTS),
    ]
    files = {"{}": "none", MEAN: "mean", CHECKPOINTS: "checkpoints"}
    for cells, precision, ranks, output in rows:
        with tempfile.TemporaryDirectory() as folder:
            peaks = measure(programs, folder, cells, precision, ranks, output)
        mebibytes = {name: [f"{value / 2**20:.1f}" for value in pair] for name, pair in peaks.items()}
        print(
            f"| {'×'.join(map(str, cells))} | {precision} | {ranks} | {files[output]} | "
            f"{mebibytes['fluid'][0]} | {mebibytes['fluid'][1]} | {' / '.join(mebibytes['body'])} | "
            f"{' / '.join(mebibytes['coupler'])} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
