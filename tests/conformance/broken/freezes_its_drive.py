"""A body component that breaks a rule: its actuators keep the directions that they had at the start."""

import sys

import numpy as np
from foundation import BODY, Masses

from copepod_component import Capabilities, run_body_component
from copepod_component.messages import setup as schema


class Freezes(Masses):
    def __init__(self, setup, context):
        super().__init__(setup, context)
        self.unit_N = np.zeros((len(setup.actuators), *self.state.position_m.shape))
        for unit_N, actuator in zip(self.unit_N, setup.actuators):
            A, B = actuator.body_A, actuator.body_B - 1
            if actuator.kind != schema.ACTUATOR_KIND_PAIR_FORCE:
                unit_N[A] = actuator.direction
                continue
            between_m = self.state.position_m[B] - self.state.position_m[A]
            unit_N[B] = between_m / np.linalg.norm(between_m)
            unit_N[A] = -unit_N[B]

    def drive_N(self, applied):
        return np.tensordot(applied.actuation[0], self.unit_N, axes=1)


FEATURES = [*BODY.features, "actuator:pair_force", "actuator:body_force", "actuator:world_force"]

if __name__ == "__main__":
    sys.exit(run_body_component(Freezes, Capabilities(BODY.name, BODY.version, FEATURES)))
