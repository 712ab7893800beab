#!/usr/bin/python3
"""A triangle of three spheres swims to a target and stays there: before each cycle it tries every stroke, rewinds, and
plays the one that ends nearest.

    deploy/copepod python examples/learning/steer_triangle.py [--cycles 30] [--picture FILE]
"""

import argparse
from itertools import permutations, product
from pathlib import Path

import copepod
import numpy

CASE = Path(__file__).resolve().parents[2] / "configs/examples/triangular_rotator.yaml"
TARGET = numpy.array([1.0e-6, 0.0, -0.7e-6])  # m, in the plane of the triangle, from where it starts
QUARTER = 2500  # steps in which an arm changes
# Nothing, or which two arms shorten and lengthen in turn, and by how much [m].
STROKES = [((0, 1), 0.0), *product(permutations(range(3), 2), (-6.0e-6, -3.0e-6, -1.5e-6))]


def play(sim, stroke):
    """A cycle: one arm shortens, then the other; the first lengthens, then the other."""
    (first, second), shorter = stroke
    for arm, length in ((first, shorter), (second, shorter), (first, 0.0), (second, 0.0)):
        sim.actuators.move(arm, length, QUARTER)
        sim.step(QUARTER)
    sim.step(2 * QUARTER)  # until the springs are at rest


def place(sim):
    return sim.bodies.position_m.mean(axis=0)


def nearest_stroke(sim, target):
    """The stroke after which the middle of the spheres is nearest to the target."""
    start, distances = sim.snapshot(), []
    for stroke in STROKES:
        play(sim, stroke)
        distances.append(numpy.linalg.norm(place(sim) - target))
        sim.restore(start)
    return STROKES[int(numpy.argmin(distances))]


def swim(cycles):
    """Places after each cycle and strokes, for a simulation that starts at rest."""
    still = {f"swimmers.0.arms.{arm}.drive.signal": {"kind": "constant", "amplitude_m": 0.0} for arm in range(3)}
    with copepod.Simulation(CASE, set=still) as sim:
        path, strokes = [place(sim)], []
        for _ in range(cycles):
            strokes.append(nearest_stroke(sim, path[0] + TARGET))
            play(sim, strokes[-1])
            path.append(place(sim))
    return numpy.array(path), strokes


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", 1)[0])
    parser.add_argument("--cycles", type=int, default=30)
    parser.add_argument("--picture", help="file of the path")
    options = parser.parse_args()
    path, strokes = swim(options.cycles)
    distances = 1e9 * numpy.linalg.norm(path - path[0] - TARGET, axis=1)
    for cycle in range(0, options.cycles + 1, 3):
        print(f"cycle {cycle:4}: {distances[cycle]:7.1f} nm from the target")
    print(
        f"last 10 cycles: at most {distances[-10:].max():.1f} nm; strokes used: {len(set(strokes))} of {len(STROKES)}"
    )
    if options.picture:
        import matplotlib

        matplotlib.use("Agg")
        from matplotlib import pyplot

        figure, axes = pyplot.subplots(figsize=(5.5, 4.5), layout="constrained")
        axes.plot(*(1e6 * (path - path[0])[:, [0, 2]].T), ".-", markersize=3, linewidth=0.8, label="after each cycle")
        axes.plot(*(1e6 * TARGET[[0, 2]]), "+", markersize=14, color="black", label="target")
        axes.set(xlabel="x [µm]", ylabel="z [µm]", aspect="equal", title="A triangle that swims to a target")
        axes.legend(frameon=False)
        axes.spines[["top", "right"]].set_visible(False)
        figure.savefig(options.picture, dpi=150)


if __name__ == "__main__":
    main()
