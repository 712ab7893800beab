"""Broken: waits for ever for a coupler that is gone."""

import sys

from foundation import FLUID, Drag
from copepod_component import run_fluid_component
from copepod_component.control_lane import ControlLane

ControlLane._look_for_coupler = lambda lane: None
sys.exit(run_fluid_component(Drag, FLUID))
