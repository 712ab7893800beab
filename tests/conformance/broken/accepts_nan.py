"""Broken: computes with numbers that are not finite."""

import sys

import numpy as np

from foundation import FLUID, Drag
from copepod_component import run_fluid_component, solvers


def read_anything(field, shape, name):
    return np.reshape(np.nan_to_num(np.array(field)), shape)


solvers._read = read_anything
sys.exit(run_fluid_component(Drag, FLUID))
