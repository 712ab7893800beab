"""Broken: its force is along the motion: a sign is missing."""

import sys

from foundation import FLUID, Drag
from copepod_component import run_fluid_component


class Propulsion(Drag):
    def exchange(self, kinematics):
        force_N, torque_N_m = super().exchange(kinematics)
        return -force_N, torque_N_m


sys.exit(run_fluid_component(Propulsion, FLUID))
