#!/usr/bin/python3
"""Two three-sphere swimmers side by side, each an agent: an environment in PettingZoo's parallel convention.

    deploy/copepod python examples/learning/two_swimmers.py     each plays the stroke of Najafi and Golestanian

Case and stroke are those of three_spheres.py, a second swimmer five radii beside the first.
"""

import copepod
import numpy
import three_spheres
from three_spheres import FAR, RADIUS

NAMES = ("left", "right")


class TwoSwimmers(copepod.ParallelEnvironment):
    """Each agent sees its rods and where both swimmers are, in radii; an action changes one of its rods."""

    possible_agents = list(NAMES)

    def __init__(self, actions_per_episode, distance=5.0):
        case, steps = three_spheres.stokes_case(FAR)
        bodies, joints = case["bodies"], case["joints"]
        sides = ((name, side * 0.5 * distance * RADIUS) for name, side in zip(NAMES, (-1, 1)))
        case["bodies"], case["joints"] = [], []
        for name, side_m in sides:
            for body in bodies:
                place = numpy.add(body["position_m"], (side_m, 0, 0)).tolist()
                case["bodies"].append({**body, "name": f"{name} {body['name']}", "position_m": place})
            for joint in joints:
                both = [f"{name} {body}" for body in joint["bodies"]]
                case["joints"].append({**joint, "name": f"{name} {joint['name']}", "bodies": both})
        super().__init__(case, steps_per_action=steps, actions_per_episode=actions_per_episode)

    def begin(self, options):
        self.short = numpy.zeros((2, 2), dtype=int)

    def observe(self):
        middles = self.sim.bodies.position_m.reshape(2, 3, 3).mean(axis=1)[:, [0, 2]] / RADIUS
        return {name: numpy.array([*rods, *middles.ravel()]) for name, rods in zip(NAMES, self.short)}

    def act(self, actions):
        for number, name in enumerate(NAMES):
            rod = int(actions[name])
            self.short[number, rod] ^= 1
            length_m = -FAR.stroke * RADIUS * self.short[number, rod]
            self.sim.actuators.move(2 * number + rod, length_m, self.steps_per_action)

    def rewards(self, before, after):
        return {name: float(after[name][3 + 2 * i] - before[name][3 + 2 * i]) for i, name in enumerate(NAMES)}


def main():
    alone = three_spheres.mobility_cycle(FAR)
    print(f"alone: {alone:.5f} radii per cycle (mobility)")
    for what, lead in (("side by side", 0), ("in opposite directions", 1)):
        swimmers = TwoSwimmers(actions_per_episode=12)
        swimmers.reset(seed=1)
        last = []  # rewards of the third cycle
        for number in range(12):
            _, rewards, *_ = swimmers.step({"left": number % 2, "right": (number + lead) % 2})
            last = [*last, rewards][-4:]
        swimmers.close()
        print(f"{what}: " + ", ".join(f"{name} {sum(each[name] for each in last):+.5f}" for name in NAMES))


if __name__ == "__main__":
    main()
