"""Broken: talks to couplers of any protocol version."""

import sys

from foundation import FLUID, Drag
from copepod_component import run_fluid_component, server

server.check_version = server.check_welcome = lambda message: None
sys.exit(run_fluid_component(Drag, FLUID))
