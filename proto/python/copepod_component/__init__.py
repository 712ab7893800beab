"""Turns a Python solver into a component of Copepod.

    from copepod_component import Capabilities, run_fluid_component

    class Fluid:
        def __init__(self, setup, context): ...  # copepod.v1.FluidSetup message, SI units; SolverContext
        def exchange(self, kinematics): ...      # -> (force_N, torque_N_m), arrays (bodies, 3)
        def advance(self): ...                   # bulk update, after the reply was sent
        def save(self, path): ...                # complete state to a new file
        def restore(self, path): ...             # legal once, before the first exchange
        def summarise(self): ...                 # -> Summary(digest=…, cell_updates=…)

    sys.exit(run_fluid_component(Fluid, Capabilities("My fluid", "1.0", ["solver:external", "shape:sphere"])))

A body solver has driving_nodes(), kinematics() and step(applied) instead of exchange and advance; a controller has
act(observation) alone, and perhaps a `state`; see the examples.
An exception of the solver becomes a Failure message; CaseError, SolverError and StorageError carry their exit codes.
Any other one is considered a mistake in the solver: the message names its file and line, the log has the traceback.
A setup, step or checkpoint that may take longer than a minute calls context.report_progress() now and then, and may
check context.stop_requested().
"""

from .errors import CaseError, ExitCode, SolverError, StorageError
from .run import Capabilities, run_body_component, run_controller_component, run_fluid_component
from .solvers import AppliedLoads, Estimate, Kinematics, Observation, SolverContext, Summary

__all__ = [
    "AppliedLoads",
    "Capabilities",
    "CaseError",
    "Estimate",
    "ExitCode",
    "Kinematics",
    "Observation",
    "SolverContext",
    "SolverError",
    "StorageError",
    "Summary",
    "run_body_component",
    "run_controller_component",
    "run_fluid_component",
]
