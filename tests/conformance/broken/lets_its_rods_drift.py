"""A body component that breaks a rule: it prevents accelerations along a rod, but does not correct what is left."""

import sys

import numpy as np
from foundation import BODY, Masses

from copepod_component import Capabilities, run_body_component


class Rods(Masses):
    def __init__(self, setup, context):
        super().__init__(setup, context)
        self.pairs = [(joint.body_A, joint.body_B - 1) for joint in setup.joints]

    def drive_N(self, applied):
        force_N = np.zeros_like(self.state.position_m)
        for A, B in self.pairs:
            apart_m, apart_m_per_s, acceleration = (
                one[A] - one[B]
                for one in (self.state.position_m, self.state.velocity_m_per_s, applied.force_N / self.mass_kg)
            )
            length_m = np.linalg.norm(apart_m)
            along = apart_m / length_m
            across_m_per_s = apart_m_per_s - along * (along @ apart_m_per_s)
            lacking = -(along @ acceleration) - across_m_per_s @ across_m_per_s / length_m
            force_N[A] += 0.5 * self.mass_kg[A] * lacking * along
            force_N[B] -= 0.5 * self.mass_kg[B] * lacking * along
        return force_N


if __name__ == "__main__":
    features = [*BODY.features, "joint:distance"]
    sys.exit(run_body_component(Rods, Capabilities(BODY.name, BODY.version, features)))
