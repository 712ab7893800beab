"""A body component that breaks a rule: the forces of a pair are opposite, but not along the line between the bodies."""

import sys

import numpy as np
from foundation import BODY, Masses

from copepod_component import Capabilities, run_body_component


class Twists(Masses):
    def __init__(self, setup, context):
        super().__init__(setup, context)
        self.pairs = [(actuator.body_A, actuator.body_B - 1) for actuator in setup.actuators]

    def drive_N(self, applied):
        force_N = np.zeros_like(self.state.position_m)
        for (A, B), value_N in zip(self.pairs, applied.actuation[0]):
            between_m = self.state.position_m[B] - self.state.position_m[A]
            askew = between_m / np.linalg.norm(between_m) + [0.0, 0.0, 1e-9]
            force_N[A] -= value_N * askew
            force_N[B] += value_N * askew
        return force_N


if __name__ == "__main__":
    features = [*BODY.features, "actuator:pair_force"]
    sys.exit(run_body_component(Twists, Capabilities(BODY.name, BODY.version, features)))
