#!/usr/bin/python3
"""Starts many runs at once on one machine: all must finish, with the same digest.

    start_storm.py [--runs 50] [--steps 100]

Prints a row for docs/results/wire.md; the exit code is 0 if all went well.
"""

import argparse
import os
import statistics
import sys
import tempfile
import time
from pathlib import Path

from fake_runs import FakeRun

TIMEOUT_S = 400


def main():
    parser = argparse.ArgumentParser(description="Starts many runs at once.")
    parser.add_argument("--runs", type=int, default=50)
    parser.add_argument("--steps", type=int, default=100)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="copepod-storm-") as folder:
        start = time.monotonic()
        runs = [FakeRun(Path(folder) / str(number), options.steps) for number in range(options.runs)]
        endings = [run.end(TIMEOUT_S) for run in runs]
        wall_s = time.monotonic() - start
        left = [pid for run in runs for pid in run.session.processes()]
    failed = [(code, words) for code, _, words in endings if code != 0]
    digests = {words for code, _, words in endings if code == 0}
    for code, words in failed:
        print(f"failed with {code}: {words}")
    print(
        "| runs at once | cores | finished | different digests | processes left "
        "| all over after | slowest run | median run |"
    )
    print("|---|---|---|---|---|---|---|---|")
    print(
        f"| {options.runs} | {len(os.sched_getaffinity(0))} | {options.runs - len(failed)} | {len(digests)} "
        f"| {len(left)} | {wall_s:.0f} s | {max(wall for _, wall, _ in endings):.0f} s "
        f"| {statistics.median(wall for _, wall, _ in endings):.0f} s |"
    )
    return 1 if failed or left or len(digests) != 1 else 0


if __name__ == "__main__":
    sys.exit(main())
