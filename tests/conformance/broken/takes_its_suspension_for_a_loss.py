"""Broken: counts the time in which it was suspended itself as silence of its coupler."""

import math
import sys

from foundation import FLUID, Drag
from copepod_component import control_lane, run_fluid_component

control_lane.PAUSE_S = math.inf
sys.exit(run_fluid_component(Drag, FLUID))
