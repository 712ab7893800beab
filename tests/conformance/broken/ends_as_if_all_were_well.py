"""Broken: its exit code is 0 whatever happened."""

import sys

from foundation import FLUID, Drag
from copepod_component import run_fluid_component

run_fluid_component(Drag, FLUID)
sys.exit(0)
