#!/usr/bin/env python3
"""Drag, lift and Strouhal number of a body or obstacle in a stream, from a run:

    deploy/copepod run configs/examples/vortex_street.yaml
    deploy/copepod python examples/python/wake.py runs/vortex_street cylinder --speed 1 --area 0.001 --length 0.1

    C = 2 F/(ρ U² A),   St = f L/U

with the speed U, the area A, the length L in m, and f the frequency of the lift. Means, halves of the distances from
least to most, and periods are of the whole periods within the last part of the run.
"""

import argparse

import copepod
import numpy as np


def periods(time_s, signal):
    """Times at which a signal rises through its mean."""
    above = signal - signal.mean()
    before = np.flatnonzero((above[:-1] < 0) & (above[1:] >= 0))
    share = above[before] / (above[before] - above[before + 1])
    return time_s[before] + share * (time_s[before + 1] - time_s[before])


def figures(time_s, drag, lift, speed, length):
    """{name: (mean, half of the span)} of coefficients over time; a Strouhal number only where the lift oscillates."""
    rises = periods(time_s, lift) if np.ptp(lift) > 1e-3 * np.abs(drag).max() else np.empty(0)
    if len(rises) < 3:
        return {"drag": (drag.mean(), np.ptp(drag) / 2), "lift": (lift.mean(), np.ptp(lift) / 2)}
    whole = (time_s >= rises[0]) & (time_s < rises[-1])
    found = {name: (c[whole].mean(), np.ptp(c[whole]) / 2) for name, c in (("drag", drag), ("lift", lift))}
    numbers = length / speed / np.diff(rises)
    return {**found, "Strouhal number": (length / speed / np.diff(rises).mean(), np.ptp(numbers) / 2)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("directory")
    parser.add_argument("name", help="of a body, or of an obstacle with loads: true")
    for option, text in (("speed", "U [m/s]"), ("area", "A [m²]"), ("length", "L [m]")):
        parser.add_argument(f"--{option}", type=float, required=True, help=text)
    parser.add_argument("--last", type=float, default=0.4, help="part of the run that is evaluated (default: 0.4)")
    parser.add_argument("--axes", default="xy", help="of drag and lift (default: xy)")
    options = parser.parse_args()

    run = copepod.load(options.directory)
    known = run.trajectory if options.name in run.trajectory.index.unique("body") else run.obstacles
    loads = known.loc[options.name]
    loads = loads[loads["time_s"] > (1 - options.last) * loads["time_s"].iloc[-1]]
    unit = 0.5 * run.case["fluid"]["density_kg_per_m3"] * options.speed**2 * options.area
    drag, lift = (loads[f"f{axis}_N"].to_numpy() / unit for axis in options.axes)
    found = figures(loads["time_s"].to_numpy(), drag, lift, options.speed, options.length)
    for name, (value, spread) in found.items():
        print(f"{name:<16} {value:9.5f} ± {spread:.5f}")


if __name__ == "__main__":
    main()
