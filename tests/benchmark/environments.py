#!/usr/bin/python3
"""Speed of many environments in one process beside one simulation on all cores, in turn; reset, snapshot, single steps.

    PYTHONPATH=python:deploy tests/benchmark/environments.py [--count 64] [--rounds 5]
"""

import argparse
import statistics
import time

import copepod

CELLS = (48, 24, 24)
STEPS = 50  # per action


def case(cells):
    cell_m = 1e-6
    middle = [0.5 * n * cell_m for n in cells]
    return {
        "case": "environment",
        "fluid": {
            "solver": "lattice_boltzmann",
            "density_kg_per_m3": 1000.0,
            "kinematic_viscosity_m2_per_s": 1e-6,
            "domain_cells": list(cells),
            "cell_size_m": cell_m,
            "boundaries": {axis: "periodic" for axis in "xyz"},
        },
        "step_s": 1.6e-7,
        "bodies": [
            {"name": name, "radius_m": 3e-6, "mass_kg": 1.2e-13, "position_m": [middle[0] + x, *middle[1:]]}
            for name, x in (("left", -8e-6), ("right", 8e-6))
        ],
        "actuators": [
            {"kind": "pair_force", "bodies": ["left", "right"], "signal": {"kind": "constant", "amplitude_N": 0}}
        ],
        "run": {"steps": 1000},
        "output": {"trajectory": {"every_steps": 1000000}},
    }


class Pair(copepod.Environment):
    def observe(self):
        return self.sim.bodies.position_m[:, 0]

    def act(self, action):
        self.sim.actuators[0] = action * 1e-11

    def reward(self, before, after):
        return after.mean() - before.mean()


def timed(action):
    start = time.perf_counter()
    action()
    return time.perf_counter() - start


def spread(name, values, unit):
    print(f"{name}: {statistics.median(values):.3g} ({min(values):.3g} to {max(values):.3g}) {unit}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", 1)[0])
    parser.add_argument("--count", type=int, default=64)
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    count = options.count
    many = copepod.Environments([lambda: Pair(case(CELLS), steps_per_action=STEPS)] * count)
    many.reset(seed=1)
    large = copepod.Simulation(case((192, 96, 96)), ranks=2)  # as many cells
    small = copepod.Simulation(case(CELLS), ranks=2)
    single = many.environments[0]
    cells = CELLS[0] * CELLS[1] * CELLS[2]
    rates = {"environments": [], "one of all cells": [], "one of an environment's": []}
    for _ in range(options.rounds):
        rates["environments"].append(1e-6 * count * cells * STEPS / timed(lambda: many.step([1] * count)))
        rates["one of all cells"].append(1e-6 * 64 * cells * STEPS / timed(lambda: large.step(STEPS)))
        rates["one of an environment's"].append(1e-6 * cells * 20 * STEPS / timed(lambda: small.step(20 * STEPS)))
    for name, values in rates.items():
        spread(name, values, "million cells/s")
    for name in list(rates)[1:]:
        ratios = [a / b for a, b in zip(rates["environments"], rates[name], strict=True)]
        spread(f"environments over {name}", ratios, "")
    spread("reset", [1e3 * timed(single.reset) for _ in range(20)], "ms")
    single.sim.step(10)
    snapshots = []
    spread("snapshot", [1e3 * timed(lambda: snapshots.append(single.sim.snapshot())) for _ in range(20)], "ms")
    spread("restore", [1e3 * timed(lambda: single.sim.restore(snapshots[0])) for _ in range(20)], "ms")
    cube = copepod.Simulation(case((48, 48, 48)), ranks=2)
    cube.step(10)
    start = cube.snapshot()
    spread("restore of 48³ cells", [1e3 * timed(lambda: cube.restore(start)) for _ in range(20)], "ms")

    def one_by_one():
        for _ in range(1000):
            vacuum.step()

    vacuum_case = case(CELLS)
    vacuum_case["fluid"] = {"solver": "stokes", "density_kg_per_m3": 1000.0, "kinematic_viscosity_m2_per_s": 1e-6}
    vacuum = copepod.Simulation({**vacuum_case, "fluid": {**vacuum_case["fluid"], "cell_size_m": 1e-6}})
    beside = [1e6 * (timed(one_by_one) - timed(lambda: vacuum.step(1000))) / 1000 for _ in range(9)]
    spread("step(1) beside the step", beside, "µs")
    many.close()


if __name__ == "__main__":
    main()
