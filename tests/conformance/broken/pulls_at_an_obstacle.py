"""Broken: an obstacle far from all motion feels what a body feels, and boxes are driven along their motion."""

import sys

import numpy as np
from foundation import FLUID, Drag

from copepod_component import Capabilities, run_fluid_component
from copepod_component.messages import setup as schema


class Pulls(Drag):
    def __init__(self, setup, context):
        super().__init__(setup, context)
        signs = [-1 if shape.kind == schema.SHAPE_KIND_BOX else 1 for shape in setup.bodies]
        self.signs, self.obstacles = np.array(signs)[:, None], len(setup.obstacles)

    def exchange(self, kinematics):
        force_N, torque_N_m = super().exchange(kinematics)
        ends = self.signs[: len(force_N)] * force_N, torque_N_m
        return [np.concatenate([loads, loads[-1:].repeat(self.obstacles, axis=0)]) for loads in ends]


if __name__ == "__main__":
    features = [*FLUID.features, "shape:box", "shape:ellipsoid", "obstacles", "obstacle_loads"]
    sys.exit(run_fluid_component(Pulls, Capabilities(FLUID.name, FLUID.version, features)))
