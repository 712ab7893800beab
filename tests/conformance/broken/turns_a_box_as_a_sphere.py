"""Broken: the inertia tensor of the setup is left aside."""

import sys

import numpy as np
from foundation import BODY, Masses

from copepod_component import Capabilities, run_body_component


class Spheres(Masses):
    def __init__(self, setup, context):
        super().__init__(setup, context)
        radius_m = np.array([body.shape.radius_m for body in setup.bodies])[:, None]
        self.inertia_kg_m2 = 0.4 * self.mass_kg * radius_m**2

    def step(self, applied):
        state = super().step(applied)
        gained = self.step_s * applied.torque_N_m / self.inertia_kg_m2
        state.angular_velocity_rad_per_s = state.angular_velocity_rad_per_s + gained
        return state


if __name__ == "__main__":
    features = [name for name in BODY.features if name != "neglects:torques"] + ["shape:box", "inertia"]
    sys.exit(run_body_component(Spheres, Capabilities(BODY.name, BODY.version, features)))
