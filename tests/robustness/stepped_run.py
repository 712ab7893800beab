#!/usr/bin/python3
"""A run through `import copepod` that goes a few steps, keeps a snapshot, goes astray, and returns to it.

    stepped_run.py CASE DIRECTORY SEED KEY=VALUE… [services]

A solver that fails ends its service, and no snapshot leads back: with services it is not steered into that.
"""

import random
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "python"), str(ROOT / "deploy")]

import copepod  # noqa: E402


def main():
    case, directory, seed, *settings = sys.argv[1:]
    services = settings[-1] == "services"
    settings = settings[:-1] if services else settings
    choose = random.Random(int(seed))
    steps = copepod.Case.load(case)["run.steps"]
    try:
        with copepod.Simulation(case, directory, set=settings, services=services) as sim:
            sim.step(choose.choice([0, choose.randrange(steps), choose.randrange(steps)]))
            middle = sim.snapshot()
            try:
                sim.step(choose.randint(1, 20))
                for actuator in range(0 if services else len(sim.actuators)):
                    sim.actuators.move(actuator, 0.0, choose.randint(0, 3))
                sim.step(choose.randint(1, 20))
            except copepod.RunError:
                pass  # it fails there without us, too, or was steered into it
            sim.restore(middle)
            while sim.steps < steps:
                sim.step(min(choose.randint(1, 30), steps - sim.steps))
    except copepod.RunError as error:
        print(error, file=sys.stderr)
        return error.code
    return 0


if __name__ == "__main__":
    sys.exit(main())
