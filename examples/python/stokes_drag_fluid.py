#!/usr/bin/env python3
"""A fluid component in Python: Stokes drag on every body, each an isolated sphere.

    F = −6π η r v,   T = −8π η r³ ω

Neglects the other bodies, the walls and the inertia of the fluid. Run a case with it:
    deploy/copepod run CASE.yaml --fluid "python3 examples/python/stokes_drag_fluid.py"
"""

import pathlib
import sys

import numpy as np

from copepod_component import Capabilities, Estimate, Summary, run_fluid_component


class StokesDrag:
    def __init__(self, setup, context):
        self._radius_m = np.array([body.radius_m for body in setup.bodies])[:, None]
        self._viscosity_Pa_s = setup.density_kg_per_m3 * setup.kinematic_viscosity_m2_per_s
        self._steps = 0

    def exchange(self, kinematics):
        force_N = -6 * np.pi * self._viscosity_Pa_s * self._radius_m * kinematics.velocity_m_per_s
        torque_N_m = -8 * np.pi * self._viscosity_Pa_s * self._radius_m**3 * kinematics.angular_velocity_rad_per_s
        return force_N, torque_N_m

    def advance(self):
        self._steps += 1

    def save(self, path):
        pathlib.Path(path).write_text(f"{self._steps} steps\n")

    def restore(self, path):
        steps, unit = pathlib.Path(path).read_text().split(" ")  # what is raised here is a damaged file to the kit
        if unit != "steps\n":
            raise ValueError("it does not end as it should")
        self._steps = int(steps)

    def summarise(self):
        return Summary(digest=self._steps)


def estimate(setup, ranks):
    """Python with numpy takes about 60 MB; a body, less than 500 bytes."""
    return Estimate(memory_bytes=60_000_000 + 500 * len(setup.bodies))


FEATURES = [
    "solver:external",
    "shape:sphere",
    "checkpoint",
    "snapshots",
    "neglects:boundary",
    "neglects:symmetry_planes",
    "neglects:fields",
]

if __name__ == "__main__":
    sys.exit(run_fluid_component(StokesDrag, Capabilities("Stokes drag in Python", "1.0", FEATURES), estimate))
