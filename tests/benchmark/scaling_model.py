#!/usr/bin/python3
"""Measures strong and weak scaling, fits the model of docs/results/scaling.md and applies it to many ranks.

    tests/benchmark/scaling_model.py [--samples N]

Model of one step with n cells per rank, f face cells towards other ranks, m messages and B bodies on P ranks:

    T = c f + m a + (ceil(log2 P) + 2 L) a + 2 k o + max(n' / r + 84 B s / 32 b, n0 / r + W)
    W = max(B s w, 84 B s / b) + 68 B s / b + B s v + B u

r: cell updates per second of a rank whose neighbours compute as well; c: seconds per face cell (five values packed,
moved, unpacked); a: latency of a message. What follows is due to the bodies: the order to all, a tree; records and
loads, over L levels of relays each way; k messages sent and as many received on the way to the last rank, each of which
occupies its relay for o. Rank 0 has n0 cells and the work W: it writes a record of 84 bytes for each of the s ranks
near a body, in w, while those before it leave; it receives 68 bytes of loads from each, adds them up in v, and reports
them in SI units in u (build/bin/nearby_bodies_benchmark). Nothing of W overlaps with its cells. The other ranks have
n' cells; n0 is that of fluid_service/ranks/block_partition.cpp. Relays are in the layer of rank 0 and have n0 cells, so
that only their own sending, 1/32 of all records, is waited for by those with n'. r is measured with two halves of a
domain, computed at the same time by ranks that do not communicate; c f + m a is fitted to the additional time of two
communicating ranks. b, the bandwidth of a network, a and o cannot be measured on one machine; they are assumed.
"""

import argparse
import math
import statistics
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "deploy"))

from copepod_bench.bench import measure_fluid  # noqa: E402

DOUBLE_VALUES = 5 * 8  # bytes of a face cell
NETWORK_B_PER_S = 10e9  # of one rank; an assumption
NETWORK_LATENCY_S = 2e-6  # an assumption
MESSAGE_OVERHEAD_S = 0.5e-6  # of a message that is sent or received, an assumption
RELAY_BASE = 32  # nearby_bodies.hpp
RADIUS_CELLS = 2
MARGIN_CELLS = 0.6  # fluid_service/.../nearby_bodies.cpp, as what follows: the larger formats, of conserving formulas
RECORD_BYTES = 84
LOAD_BYTES = 68
CELLS_PER_BODY = 10  # fluid_service/ranks/block_partition.cpp
RECORD_S = 17e-9  # processor time by nearby_bodies_benchmark, bodies in random order
LOAD_S = 13e-9  # likewise
REPORT_S = 32e-9  # likewise: what a whole exchange takes for a body beyond both
SHAPES = ((4, 4, 4), (8, 32, 32), (16, 64, 64), (8, 128, 128), (32, 64, 64), (64, 64, 64), (100, 100, 200))


def measured(shape, ranks, samples):
    """Median seconds of a step of the uncoupled fluid, double precision."""
    cells = math.prod(shape)
    steps = max(20, int(4e7 / cells))
    return cells / (1e6 * measure_fluid(shape, ranks, samples=samples, steps=steps)["median_fluid_mlups"])


def measured_apart(shape, samples):
    """The same for the two halves of a domain on one rank each, at the same time and without any message."""
    half = (shape[0] // 2, *shape[1:])
    with ThreadPoolExecutor(2) as pool:
        return statistics.mean(pool.map(lambda _: measured(half, 1, samples), range(2)))


def fit(rows):
    """(s per face cell, s per step for messages): extra time of communicating ranks, by least squares."""
    seconds = numpy.array([two for _, _, two in rows])
    extra = seconds - numpy.array([apart for _, apart, _ in rows])
    design = numpy.array([[shape[1] * shape[2], 1.0] for shape, _, _ in rows])
    solution, *_ = numpy.linalg.lstsq(design / seconds[:, None], extra / seconds, rcond=None)
    return solution


def relay_levels(ranks):
    levels, reached = 0, 1
    while reached < ranks:
        levels += 1
        reached += RELAY_BASE**levels
    return levels


def step_s(cells, ranks, bodies, cell_s, face_s):
    """Seconds of the model for cubic blocks with neighbours on all sides: halo; latencies and messages of bodies; work
    of rank 0; the step; the step if all ranks had as many cells. D3Q19 exchanges with 18 neighbours."""
    side = cells ** (1 / 3)
    halo = 6 * round(side**2) * max(face_s, DOUBLE_VALUES / NETWORK_B_PER_S) + 18 * NETWORK_LATENCY_S
    levels = relay_levels(ranks)
    messages = 2 * RELAY_BASE * levels * MESSAGE_OVERHEAD_S
    messages += (math.ceil(math.log2(ranks)) + 2 * levels) * NETWORK_LATENCY_S
    near = bodies * (1 + 2 * (RADIUS_CELLS + MARGIN_CELLS) / side) ** 3
    records_s = RECORD_BYTES * near / NETWORK_B_PER_S
    work = max(near * RECORD_S, records_s) + LOAD_BYTES * near / NETWORK_B_PER_S + near * LOAD_S + bodies * REPORT_S
    blocks = round(ranks ** (1 / 3))
    fewer = min(CELLS_PER_BODY * bodies // round(side**2), blocks * (side - 1) // (blocks - 1))
    first = cells * (1 + (1 - blocks) * fewer / (blocks * side))
    others = cells * (1 + fewer / (blocks * side))
    step = halo + messages + max(others * cell_s + records_s / RELAY_BASE, first * cell_s + work)
    return halo, messages, work, step, halo + messages + cells * cell_s + work


def print_model(cell_s, face_s):
    print(
        f"\nAssumed network: {1e6 * NETWORK_LATENCY_S:.0f} µs, {NETWORK_B_PER_S / 1e9:.0f} GB/s per rank, "
        f"{1e6 * MESSAGE_OVERHEAD_S} µs per message; bodies with a radius of {RADIUS_CELLS} cells.\n"
    )
    print(
        "| ranks | cells per rank | bodies | cells, ms | halo, ms | messages, ms | work of rank 0, ms | cells' share "
        "| with equal blocks |\n"
        "|---|---|---|---|---|---|---|---|---|"
    )
    cases = [
        (side**3, ranks, bodies)
        for side, bodies in ((100, 3), (32, 3), (100, 1000), (100, 100000))
        for ranks in (1000, 10000, 100000)
    ]
    cases += [(side**3, 1000, 100000) for side in (80, 90, 95, 120, 150)]
    for cells, ranks, bodies in cases:
        halo, messages, work, step, with_equal_blocks = step_s(cells, ranks, bodies, cell_s, face_s)
        print(
            f"| {ranks} | {cells} | {bodies} | {1e3 * cells * cell_s:.3f} | {1e3 * halo:.3f} | {1e3 * messages:.3f} "
            f"| {1e3 * work:.3f} | {cells * cell_s / step:.2f} | {cells * cell_s / with_equal_blocks:.2f} |"
        )


def main():
    parser = argparse.ArgumentParser(description="Scaling by measurement and by model.")
    parser.add_argument("--samples", type=int, default=5)
    options = parser.parse_args()

    print(
        "| domain | 1 rank, ms | 2 halves apart, ms | 2 ranks, ms | strong efficiency | lost to communication |\n"
        "|---|---|---|---|---|---|"
    )
    rows = []
    for shape in SHAPES:
        one, apart, two = (
            measured(shape, 1, options.samples),
            measured_apart(shape, options.samples),
            measured(shape, 2, options.samples),
        )
        rows.append((shape, apart, two))
        print(
            f"| {'×'.join(map(str, shape))} | {1e3 * one:.4f} | {1e3 * apart:.4f} | {1e3 * two:.4f} "
            f"| {one / two / 2:.2f} | {100 * (1 - apart / two):.0f} % |",
            flush=True,
        )
    weak = [measured((100 * ranks, 100, 100), ranks, options.samples) for ranks in (1, 2)]
    print(
        f"\nWeak scaling, 100×100×100 cells per rank: {1e3 * weak[0]:.2f} and {1e3 * weak[1]:.2f} ms, "
        f"efficiency {weak[0] / weak[1]:.2f}"
    )

    face_s, message_s = fit(rows)
    cell_s = rows[-1][1] / (math.prod(SHAPES[-1]) / 2)
    errors = [abs(apart + s[1] * s[2] * face_s + message_s - two) / two for s, apart, two in rows]
    print(
        f"\nFitted: {1e9 * cell_s:.2f} ns per cell, {1e9 * face_s:.1f} ns per face cell, "
        f"{1e6 * message_s:.1f} µs of messages per step; "
        f"relative error median {statistics.median(errors):.2f}, worst {max(errors):.2f}"
    )

    print_model(cell_s, face_s)


if __name__ == "__main__":
    main()
