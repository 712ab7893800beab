#!/usr/bin/python3
"""Three spheres on two rods learn to swim: tabular Q-learning finds the stroke of Najafi and Golestanian.

    deploy/copepod python examples/learning/three_spheres.py                              in Stokes flow, seconds
    deploy/copepod python examples/learning/three_spheres.py --reynolds 5 --actions 1500  in the lattice fluid
    … --reynolds 5 --wait                                                                 it may also pause
    … --seeds 5 --picture learning.png --table learning.json

Each rod is long or short, an action changes one of them [Najafi and Golestanian, Phys. Rev. E 69, 062901, 2004; as an
environment: Tsang, Tong, Nallan and Pak, Phys. Rev. Fluids 5, 074101, 2020]. The reward is how far the middle of the
spheres has moved along the axis, in radii. Re = U R/ν, with U the speed at which a rod changes.
"""

import argparse
import json
import sys
from dataclasses import dataclass

import copepod
import numpy

RADIUS = 1.0e-6  # m


@dataclass(frozen=True)
class Form:
    """Lengths in radii: rods from centre to centre, and how much shorter they become."""

    rod: float
    stroke: float


FAR, NEAR = Form(10.0, 4.0), Form(6.0, 2.0)  # Tsang et al.; one that a small lattice holds


def stokes_case(form):
    """Spheres in unbounded Stokes flow (Rotne-Prager mobility); a hundred steps per action."""
    return _case(form, {"solver": "stokes", "cell_size_m": RADIUS}, 5.0e-5), 100


def lattice_case(form, reynolds, cells_per_radius=3.0):
    """Spheres in a box of lattice fluid, of which a quarter is computed; its images are beside it on all sides."""
    viscosity_lu = 0.5 if reynolds < 0.5 else 1.0 / 30.0
    speed_lu = reynolds * viscosity_lu / cells_per_radius
    cell_m = RADIUS / cells_per_radius
    length = int(2 * (2 * form.rod + 8) * cells_per_radius / 2)
    width = int(2 * round(5.5 * cells_per_radius))
    fluid = {
        "solver": "lattice_boltzmann",
        "domain_cells": [width, width, length],
        "cell_size_m": cell_m,
        "symmetry_planes": ["x", "y"],
        "boundaries": {"x": "free_slip", "y": "free_slip", "z": "periodic"},
    }
    case = _case(
        form, fluid, viscosity_lu * cell_m**2 / 1e-6, [width * cell_m / 2, width * cell_m / 2, length * cell_m / 2]
    )
    return case, round(form.stroke * cells_per_radius / speed_lu)


def _case(form, fluid, step_s, middle_m=(0.0, 0.0, 0.0)):
    places = {"rear": -form.rod, "middle": 0.0, "front": form.rod}
    mass_kg = 1000.0 * 4.0 / 3.0 * numpy.pi * RADIUS**3
    return {
        "case": "three_spheres",
        "fluid": {"density_kg_per_m3": 1000.0, "kinematic_viscosity_m2_per_s": 1.0e-6, **fluid},
        "step_s": step_s,
        "bodies": [
            {
                "name": name,
                "radius_m": RADIUS,
                "mass_kg": mass_kg,
                "position_m": [middle_m[0], middle_m[1], middle_m[2] + place * RADIUS],
            }
            for name, place in places.items()
        ],
        "joints": [
            {"name": name, "kind": "distance", "bodies": bodies, "signal": {"kind": "constant", "amplitude_m": 0.0}}
            for name, bodies in (("rear rod", ["rear", "middle"]), ("front rod", ["middle", "front"]))
        ],
        "run": {"steps": 1000},
        "output": {"trajectory": {"every_steps": 1000000}},
    }


class ThreeSpheres(copepod.Environment):
    """Observation: whether the rear and the front rod are short, and the middle of the spheres in radii; where it can
    wait, in between how many actions it has waited, 2 for more. Actions 0 and 1 change a rod, 2 waits."""

    def __init__(self, case, form, steps_per_action, actions_per_episode, can_wait=False):
        super().__init__(case, steps_per_action=steps_per_action, actions_per_episode=actions_per_episode)
        self.form = form
        self.actions = 3 if can_wait else 2

    def begin(self, options):
        self.short = numpy.zeros(2, dtype=int)
        self.waited = 0

    def observe(self):
        waited = [self.waited] if self.actions == 3 else []
        return numpy.array([*self.short, *waited, self.sim.bodies.position_m[:, 2].mean() / RADIUS])

    def act(self, action):
        self.waited = min(self.waited + 1, 2) if action == 2 else 0
        if action == 2:
            return
        self.short[action] ^= 1
        length_m = -self.form.stroke * RADIUS * self.short[action]
        self.sim.actuators.move(int(action), length_m, self.steps_per_action)

    def reward(self, before, after):
        return after[-1] - before[-1]


def state_of(observation):
    """Number of what an observation has before the position."""
    return int(numpy.dot(observation[:-1], [1, 2, 4][: len(observation) - 1]))


def learn(environment, actions, seed, rate=0.5, discount=0.9, explore=0.2):
    """Q-learning [Watkins 1989]: Q(s, a) ← Q + α (r + γ max Q(s', ·) − Q), ε-greedy with an ε that falls to 0.

    @return Q, shape (states, actions), and the positions after each action relative to the start of its episode, summed
    """
    choose = numpy.random.default_rng(seed)
    Q = numpy.zeros((12, environment.actions))
    path = [0.0]
    seen, _ = environment.reset(seed=seed)
    for number in range(actions):
        state = state_of(seen)
        is_random = choose.random() < explore * (1.0 - number / actions)
        best = numpy.flatnonzero(Q[state] == Q[state].max())
        best = best[choose.integers(len(best))] if len(best) > 1 else best[0]
        action = int(choose.integers(environment.actions)) if is_random else int(best)
        seen, reward, _, truncated, info = environment.step(action)
        if "reason" in info:
            sys.exit(info["reason"])
        Q[state, action] += rate * (reward + discount * Q[state_of(seen)].max() - Q[state, action])
        path.append(path[-1] + reward)
        if truncated:
            seen, _ = environment.reset()
    return Q, numpy.array(path)


def played(environment, choose):
    """Displacement per four actions in radii, the mean of 200 actions after 40, and the last eight actions.

    @param environment  whose episodes do not end
    @param choose       the action, by the number of those before it and the observation
    """
    seen, _ = environment.reset()
    moved, taken = 0.0, []
    for number in range(240):
        taken.append(choose(number, seen))
        seen, reward, *_ = environment.step(taken[-1])
        moved += reward if number >= 40 else 0.0
    return moved / 50, taken[-8:]


def play_greedily(environment, Q):
    """The policy Q."""
    return played(environment, lambda _, seen: int(Q[state_of(seen)].argmax()))


def play_open_loop(environment, cycle):
    """A list of actions that is repeated without looking."""
    return played(environment, lambda number, _: cycle[number % len(cycle)])[0]


def mobility_cycle(form, steps=400):
    """Displacement per cycle of spheres on a line by their Rotne-Prager mobility, in radii; Runge-Kutta, fourth order.

    v = M F,  M_ii = 1/(6π),  M_ij = (1 − 2/(3 r²))/(4π r),  with the rods' rates given and no force on the whole.
    """

    def velocities(places, rates):
        distance = numpy.abs(places[:, None] - places[None, :]) + numpy.eye(3)
        M = (1.0 - 2.0 / (3.0 * distance**2)) / (4.0 * numpy.pi * distance)
        numpy.fill_diagonal(M, 1.0 / (6.0 * numpy.pi))
        resistance = numpy.linalg.inv(M)
        relative = numpy.array([0.0, rates[0], rates[0] + rates[1]])
        return relative - (resistance @ relative).sum() / resistance.sum()

    places = form.rod * numpy.array([-1.0, 0.0, 1.0])
    h = 1.0 / steps
    for rates in form.stroke * numpy.array([[-1, 0], [0, -1], [1, 0], [0, 1]]):
        for _ in range(steps):
            k1 = velocities(places, rates)
            k2 = velocities(places + 0.5 * h * k1, rates)
            k3 = velocities(places + 0.5 * h * k2, rates)
            k4 = velocities(places + h * k3, rates)
            places = places + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return abs(places.mean())


def draw(paths, title, file):
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(7.0, 4.2), layout="constrained")
    for seed, path in enumerate(paths, 1):
        axes.plot(path, linewidth=1.2, label=f"seed {seed}")
    axes.set(xlabel="actions", ylabel="displacement [radii]", title=title)
    axes.legend(frameon=False)
    axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(file, dpi=150)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", 1)[0])
    parser.add_argument("--reynolds", type=float, help="in the lattice fluid; without: Stokes flow")
    parser.add_argument("--actions", type=int, default=1000, help="to learn from (1000)")
    parser.add_argument("--episode", type=int, default=40, help="actions of an episode (40)")
    parser.add_argument("--seeds", type=int, default=1, help="how many learners (1)")
    parser.add_argument("--wait", action="store_true", help="a third action changes nothing")
    parser.add_argument("--near", action="store_true", help="in Stokes flow the shorter rods of the lattice")
    parser.add_argument("--picture", help="file of the learning curves")
    parser.add_argument("--table", help="file of all results, JSON")
    options = parser.parse_args()

    form = NEAR if options.near or options.reynolds else FAR
    case, steps = lattice_case(form, options.reynolds) if options.reynolds else stokes_case(form)
    environment, judge = (ThreeSpheres(case, form, steps, n, options.wait) for n in (options.episode, 0))
    where = f"lattice fluid, Re {options.reynolds:g}" if options.reynolds else "Stokes flow"
    forward, backward = (play_open_loop(judge, cycle) for cycle in ([0, 1, 0, 1], [1, 0, 1, 0]))
    theory = mobility_cycle(form)
    print(f"{where}; rods of {form.rod:g} radii, strokes of {form.stroke:g}, {steps} steps per action")
    print(f"mobility without inertia:      {theory:.5f} radii per cycle")
    print(f"open loop, rear rod first:     {forward:+.5f}\nopen loop, front rod first:    {backward:+.5f}")
    results = {"where": where, "mobility": theory, "open_loop": [forward, backward], "learned": []}
    paths = []
    for seed in range(1, options.seeds + 1):
        Q, path = learn(environment, options.actions, seed)
        moved, taken = play_greedily(judge, Q)
        paths.append(path)
        results["learned"].append({"seed": seed, "cycle": moved, "actions": taken, "Q": Q.tolist()})
        print(f"seed {seed}: learned {taken}, {moved:+.5f} radii per four actions, after {options.actions}", flush=True)
    environment.close()
    judge.close()
    if options.picture:
        draw(paths, f"Learning to swim: {where}", options.picture)
    if options.table:
        with open(options.table, "w") as file:
            json.dump({**results, "paths": [path.tolist() for path in paths]}, file)
    return 0


if __name__ == "__main__":
    sys.exit(main())
