"""A body component that breaks a rule: a bend pushes the ends of its arms, but not the body between them."""

import sys

import numpy as np
from foundation import BODY, Masses

from copepod_component import Capabilities, run_body_component


class Bends(Masses):
    def __init__(self, setup, context):
        super().__init__(setup, context)
        self.bends = setup.bends

    def drive_N(self, applied):
        force_N = np.zeros_like(self.state.position_m)
        for bend in self.bends:
            A, B, C = (self.state.position_m[body] for body in (bend.body_A, bend.body_B, bend.body_C))
            a_m, c_m = np.linalg.norm(A - B), np.linalg.norm(C - B)
            a, c = (A - B) / a_m, (C - B) / c_m
            angle = np.arccos(a @ c)
            moment_N_m = bend.stiffness_N_m_per_rad * (angle - bend.rest_angle_rad) / np.sin(angle)
            force_N[bend.body_A] += moment_N_m / a_m * (c - a @ c * a)
            force_N[bend.body_C] += moment_N_m / c_m * (a - a @ c * c)
        return force_N


if __name__ == "__main__":
    features = [*BODY.features, "bends"]
    sys.exit(run_body_component(Bends, Capabilities(BODY.name, BODY.version, features)))
