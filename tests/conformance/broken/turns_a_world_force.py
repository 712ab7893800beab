"""A body component that breaks a rule: a force fixed in the world turns with the spin of its body."""

import sys

import numpy as np
from foundation import BODY, Masses

from copepod_component import Capabilities, run_body_component


class Turns(Masses):
    def __init__(self, setup, context):
        super().__init__(setup, context)
        self.actuators = [(actuator.body_A, np.array(actuator.direction)) for actuator in setup.actuators]

    def drive_N(self, applied):
        force_N = np.zeros_like(self.state.position_m)
        for (body, direction), value_N in zip(self.actuators, applied.actuation[0]):
            turned = applied.step * self.step_s * self.state.angular_velocity_rad_per_s[body]
            force_N[body] += value_N * (direction + np.cross(turned, direction))
        return force_N


if __name__ == "__main__":
    features = [*BODY.features, "actuator:world_force"]
    sys.exit(run_body_component(Turns, Capabilities(BODY.name, BODY.version, features)))
