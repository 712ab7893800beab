"""Copepod from Python: build or edit a case, check and run it, look at its results.

    import copepod

    case = copepod.Case.load("configs/examples/four_bead_chain.yaml")
    case["run.steps"] = 8000
    run = copepod.run(case, out="runs/chain")
    run.cycles                     # pandas: velocity, rotation and power by swimmer and cycle
    run.trajectory                 # pandas: positions, velocities, forces by body and step
    run.fields                     # xarray: density and velocity of the fluid

Runs are started by the command `deploy/copepod`; their results are files that `load` reads, also while a run continues.
Lengths are in m, times in s: every key and column carries its unit. docs/python.md is the introduction.
"""

import pkgutil

# The message classes that the build generates, copepod.v1, may be in another folder of the same name.
__path__ = pkgutil.extend_path(__path__, __name__)

from copepod.case import Case
from copepod.environment import Environment, Environments, ParallelEnvironment
from copepod.errors import CaseError, CaseWarning, Error, RunError
from copepod.results import Campaign, Run, Sample, follow, load
from copepod.running import Check, Progress, check, run
from copepod.simulation import Actuators, Bodies, Simulation, Snapshot

__all__ = ["Actuators", "Bodies", "Campaign", "Case", "CaseError", "CaseWarning", "Check"]
__all__ += ["Environment", "Environments", "Error", "ParallelEnvironment", "Progress", "Run", "RunError", "Sample"]
__all__ += ["Simulation", "Snapshot", "check", "follow", "load", "run"]
