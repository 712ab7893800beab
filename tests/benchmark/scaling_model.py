#!/usr/bin/python3
"""Measures strong and weak scaling, fits the model of docs/results/scaling.md and applies it to many ranks.

    tests/benchmark/scaling_model.py [--samples N]

Model of one step of a rank with n cells, f face cells towards other ranks, m messages and B bodies on P ranks:

    T = n / r + c f + m a + (ceil(log2 P) + 2 L) a + 2 k o + max(88 B s, 72 B t) / b + B s w + B t v

r: cell updates per second of a rank whose neighbours compute as well; c: seconds per face cell (five values packed,
moved, unpacked); a: latency of a message. What follows is the bodies' work of rank 0, for which the others wait: the
order to all, a tree; records and loads, over L levels of relays each way; k messages sent and as many received on
the way to the last rank, each of which occupies its relay for o; and their contents. A record has 88 bytes and a
load 72 (fluid_service/.../nearby_bodies.hpp), and a body goes to s ranks and comes from t. w and v are what rank 0
computes for a record and for loads (build/bin/nearby_bodies_benchmark). Groups of ranks are served one after the
other, so that the loads of one arrive while the records of another leave; `without overlap` adds both instead. r is
measured with two halves of a domain, computed at the same time by ranks that do not communicate; c f + m a is fitted
to the additional time of two communicating ranks. b, the bandwidth of a network, a and o cannot be measured on one
machine; they are assumed.
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

from copepod_bench.measurements import measure_fluid  # noqa: E402

DOUBLE_VALUES = 5 * 8  # bytes of a face cell
NETWORK_B_PER_S = 10e9  # of one rank; an assumption
NETWORK_LATENCY_S = 2e-6  # an assumption
MESSAGE_OVERHEAD_S = 0.5e-6  # of a message that is sent or received, an assumption
RELAY_BASE = 32  # fluid_service/ranks/relays.hpp
RADIUS_CELLS = 2
RECORD_S = 86e-9  # processor time by nearby_bodies_benchmark, bodies in random order
LOAD_S = 73e-9  # likewise
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


def step_s(cells, ranks, bodies, cell_s, face_s):
    """Seconds of the model for cubic blocks with neighbours on all sides: cells, halo, messages of bodies, the same if
    records and loads do not overlap, and the work of rank 0 for bodies. D3Q19 exchanges with 18 neighbours."""
    if ranks == 1:
        return cells * cell_s, 0.0, 0.0, 0.0, 0.0
    face_cells = 6 * round(cells ** (2 / 3))
    halo = face_cells * max(face_s, DOUBLE_VALUES / NETWORK_B_PER_S) + 18 * NETWORK_LATENCY_S

    def ranks_of_a_body(margin_cells):
        return (1 + 2 * (RADIUS_CELLS + margin_cells) / cells ** (1 / 3)) ** 3

    levels = math.ceil(math.log(ranks, RELAY_BASE))
    messages = (RELAY_BASE - 1) * levels
    fixed = (math.ceil(math.log2(ranks)) + 2 * levels) * NETWORK_LATENCY_S + 2 * messages * MESSAGE_OVERHEAD_S
    sent, received = bodies * ranks_of_a_body(2), bodies * ranks_of_a_body(1)
    records = 88 * sent / NETWORK_B_PER_S
    loads = 72 * received / NETWORK_B_PER_S
    work = sent * RECORD_S + received * LOAD_S
    return cells * cell_s, halo, fixed + max(records, loads), fixed + records + loads, work


def print_model(cell_s, face_s):
    print(
        f"\nAssumed network: {1e6 * NETWORK_LATENCY_S:.0f} µs, {NETWORK_B_PER_S / 1e9:.0f} GB/s per rank, "
        f"{1e6 * MESSAGE_OVERHEAD_S} µs per message; bodies with a radius of {RADIUS_CELLS} cells.\n"
    )
    print(
        "| ranks | cells per rank | bodies | cells, ms | halo, ms | messages, ms | cells' share | without overlap "
        "| work of rank 0, ms | share with it |\n"
        "|---|---|---|---|---|---|---|---|---|---|"
    )
    for cells, bodies in ((100**3, 3), (32**3, 3), (100**3, 1000), (100**3, 100000)):
        for ranks in (1000, 10000, 100000):
            of_cells, halo, overlapped, apart, work = step_s(cells, ranks, bodies, cell_s, face_s)
            print(
                f"| {ranks} | {cells} | {bodies} | {1e3 * of_cells:.3f} | {1e3 * halo:.3f} | {1e3 * overlapped:.3f} "
                f"| {of_cells / (of_cells + halo + overlapped):.2f} | {of_cells / (of_cells + halo + apart):.2f} "
                f"| {1e3 * work:.3f} | {of_cells / (of_cells + halo + overlapped + work):.2f} |"
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
