#!/usr/bin/python3
"""A long run of the fakes: memory, descriptors and time per step must not grow.

    soak.py [--steps 1000000] [--samples 10]

Samples coupler, fluid and body at equal distances after the first tenth of the run, prints the table of
docs/results/wire.md, and ends with 1 if anything grew: memory by more than 256 KiB, descriptors by one, the time
per step from the first half to the second by more than a third (others use this machine too; a queue that grows
does worse).
"""

import argparse
import os
import statistics
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from fake_runs import FakeRun

COMPONENTS = ("coupler", "fluid", "body")
MOST_GROWTH_KIB = 256
MOST_SLOWER = 4 / 3


@dataclass
class Sample:
    step: int
    time_s: float
    memory_kib: list  # anonymous, of coupler, fluid, body
    descriptors: list


def main():
    parser = argparse.ArgumentParser(description="A long run of the fakes.")
    parser.add_argument("--steps", type=int, default=1_000_000)
    parser.add_argument("--samples", type=int, default=10)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="copepod-soak-") as folder:
        run = FakeRun(folder, options.steps)
        samples = watch(run, options.steps, options.samples)
        code, wall_s, words = run.end(60)
    if code != 0:
        print(f"failed with {code}: {words}")
        return code
    print_table(samples)
    problems = growth(samples)
    print(f"\n{options.steps} steps in {wall_s:.0f} s, digest {words}; " + ("; ".join(problems) or "nothing grew"))
    return 1 if problems else 0


def watch(run, steps, count):
    """Samples at equal distances; the first tenth is left to buffers that grow to their size."""
    samples = []
    while run.session.process.poll() is None:
        step = run.step()
        if step >= steps * (0.1 + 0.9 * len(samples) / count):
            try:
                samples.append(sample(run, step))
            except (OSError, AssertionError):  # the run ends just now
                break
        time.sleep(0.1)
    return samples


def sample(run, step):
    processes = [run.session.pid_of(component) for component in COMPONENTS]
    return Sample(
        step,
        time.monotonic(),
        [anonymous_kib(pid) for pid in processes],
        [len(os.listdir(f"/proc/{pid}/fd")) for pid in processes],
    )


def anonymous_kib(pid):
    """Anonymous memory, counted page by page, where VmRSS of /proc/PID/status is an estimate."""
    for line in Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines():
        if line.startswith("Anonymous:"):
            return int(line.split()[1])
    raise OSError(f"process {pid} has no memory any more")


def step_times_us(samples):
    return [1e6 * (b.time_s - a.time_s) / (b.step - a.step) for a, b in zip(samples, samples[1:]) if b.step > a.step]


def print_table(samples):
    print("| step | µs per step | anonymous memory in KiB: coupler, fluid, body | descriptors |")
    print("|---|---|---|---|")
    for before, now in zip([None, *samples], samples):
        time_us = f"{step_times_us([before, now])[0]:.0f}" if before and now.step > before.step else ""
        print(
            f"| {now.step} | {time_us} | {', '.join(map(str, now.memory_kib))} "
            f"| {', '.join(map(str, now.descriptors))} |"
        )


def growth(samples):
    """What grew from the first sample to the last."""
    if len(samples) < 4:
        return [f"only {len(samples)} samples: make the run longer"]
    first, last = samples[0], samples[-1]
    problems = []
    for component, before, after in zip(COMPONENTS, first.memory_kib, last.memory_kib):
        if after - before > MOST_GROWTH_KIB:
            problems.append(f"memory of {component} grew by {after - before} KiB")
    for component, before, after in zip(COMPONENTS, first.descriptors, last.descriptors):
        if after > before:
            problems.append(f"descriptors of {component} grew from {before} to {after}")
    times = step_times_us(samples)
    early, late = (statistics.median(half) for half in (times[: len(times) // 2], times[len(times) // 2 :]))
    if late > MOST_SLOWER * early:
        problems.append(f"the step became slower, {early:.0f} to {late:.0f} µs")
    return problems


if __name__ == "__main__":
    sys.exit(main())
