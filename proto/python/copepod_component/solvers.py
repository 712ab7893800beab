"""Solvers behind the messages of their role; arrays are numpy, shape (bodies, …), SI units, world frame."""

import dataclasses
import json
import os
import time
from typing import Any

import numpy as np

from .errors import ComponentError, Refused, SolverError, StorageError
from .messages import checksum, control
from .validation import check_setup, check_text


class SolverContext:
    """Given to `make_solver`. A solver uses the three methods; the attributes are for the kit and its control lane."""

    def __init__(self):
        self.step = -1
        self.phase = control.PHASE_HANDSHAKE
        self.progress = 0
        self.awaited_rank = 0
        self.received_sequence = 0
        self.replied_sequence = 0
        self.stop_code = 0  # set by the control lane

    def report_progress(self):
        """Shows that a long computation advances; call it in one that may exceed `services.progress_deadline_s`.

        The coupler reports a component as hanging once its step, phase and progress have all stood still for so long.
        """
        self.progress += 1

    def stop_requested(self):
        """The exit code to end with once the coupler is gone or has aborted the run; 0 before.

        A solver in a long loop may check it and raise; a process that has not ended 2 s later is ended.
        """
        return self.stop_code

    def await_rank(self, rank):
        """Names the process of a parallel solver that the others wait for, in case it hangs; 0: none."""
        self.awaited_rank = rank


@dataclasses.dataclass
class Kinematics:
    """State of motion of all bodies at the start of a step."""

    step: int  #: at the start of this one
    position_m: np.ndarray  #: (bodies, 3), centre of mass
    orientation_wxyz: np.ndarray  #: (bodies, 4), unit quaternions
    velocity_m_per_s: np.ndarray  #: (bodies, 3)
    angular_velocity_rad_per_s: np.ndarray  #: (bodies, 3)


WIDTHS = {"position_m": 3, "orientation_wxyz": 4, "velocity_m_per_s": 3, "angular_velocity_rad_per_s": 3}


@dataclasses.dataclass
class Observation(Kinematics):
    """What a controller sees of its bodies: their motion, and the loads on them during the step before."""

    force_N: np.ndarray  #: (bodies, 3), hydrodynamic; zeros at the first step
    torque_N_m: np.ndarray  #: (bodies, 3), about the centre of mass
    flow: np.ndarray  #: newest sample of the flow, named by the setup's flow; zeros before it


@dataclasses.dataclass
class AppliedLoads:
    """What the coupler applies to the bodies during a step."""

    step: int  #: during this one
    force_N: np.ndarray  #: (bodies, 3), hydrodynamic, constant over the step
    torque_N_m: np.ndarray  #: (bodies, 3), about the centre of mass
    actuation: np.ndarray  #: (nodes, actuators), values in N or N m, actuators in the order of the setup


@dataclasses.dataclass
class Estimate:
    """What a solver will need, before a run."""

    memory_bytes: int  #: per process
    problem: str = ""  #: a warning for the user


@dataclasses.dataclass
class Summary:
    """Results of a solver at the end of a run."""

    digest: int = 0  #: of the complete state; equal digests mean equal bits
    cell_updates: int = 0  #: fluids: cells of the computed domain × steps
    ranks: int = 1  #: processes of the solver
    seconds: dict = dataclasses.field(default_factory=dict)  #: by phase; empty: the kit reports what it measured
    body_phases: tuple = ()  #: those phases that a fluid without bodies would not need
    waiting_phases: tuple = ()  #: those phases in which the solver only waited
    mass_drift: float | None = None  #: fluids on a grid: mass gained since the fluid was at rest, by its mass
    momentum_drift: float | None = None  #: likewise: |momentum from no body, wall or force| by the bodies' impulses


def _read(field, shape, name):
    array = np.array(field, dtype=float)
    if array.size != np.prod(shape) or not np.isfinite(array).all():
        raise Refused(
            f"A message was refused ({name} is not an array of {np.prod(shape)} finite numbers). "
            "Use the same protocol version on both sides."
        )
    return array.reshape(shape)


def _write(field, array, shape, name):
    array = np.ascontiguousarray(array, dtype=float)
    if array.shape != shape:
        raise SolverError(f"The solver returned {name} of shape {array.shape} (not {shape}). Fix it.")
    if not np.isfinite(array).all():
        raise SolverError(f"The solver returned {name} that is not finite (it has diverged). Use a smaller step.")
    field.extend(array.ravel())


class _Served:
    """What both roles share. `perform` fills the reply to a request and returns nothing."""

    def __init__(self, make_solver, context):
        self._make_solver, self._context = make_solver, context
        self.solver: Any = None  # made by the setup
        self._bodies = self._actuators = 0
        self._seconds: dict[str, float] = {}

    def perform(self, request, reply):
        body = getattr(request, request.WhichOneof("body"))
        name = body.DESCRIPTOR.name
        if name in ("Save", "Restore"):
            check_text(body.path, "path")
        if name == "Save":
            reply.saved.SetInParent()
            try:
                self.solver.save(body.path)
            except (OSError, StorageError) as problem:  # a full disk does not end the run
                reply.saved.problem = str(problem)
        elif name == "Restore":
            try:
                self.solver.restore(body.path)
            except ComponentError:
                raise
            except Exception as problem:  # whatever a damaged file makes of the solver
                raise StorageError(
                    f"The solver cannot read the state in {body.path} ({type(problem).__name__}: {problem}). Resume "
                    "from another checkpoint."
                ) from problem
            reply.restored.SetInParent()
        elif name == "Summarise":
            summary = self.solver.summarise()
            fields = dataclasses.asdict(summary) | {"seconds": summary.seconds or self._seconds}
            reply.MergeFrom(type(reply)(summary=fields))
        elif name in ("FluidSetup", "BodySetup", "ControllerSetup"):
            check_setup(body)
            self._bodies = len(body.bodies)
            self.solver = None  # one at a time fits into the memory
            self.solver = self._make_solver(body, self._context)
            reply.configured.SetInParent()
            self._configured(body, reply.configured)
        else:
            self._step(name, body, request, reply)

    def _configured(self, setup, reply):
        """What a role has to add to its answer."""

    def _step(self, name, body, request, reply):
        """Requests about a step, of one role."""

    def follow_up(self, name):
        """Work after the reply."""

    def _timed(self, phase, work, *arguments):
        start = time.monotonic()
        result = work(*arguments)
        self._seconds[phase] = self._seconds.get(phase, 0.0) + time.monotonic() - start
        return result


class ServedFluid(_Served):
    role = "fluid"

    def _configured(self, setup, reply):
        self._loads = len(setup.bodies) + sum(obstacle.loads for obstacle in setup.obstacles)

    def _step(self, name, body, request, reply):
        if name == "Kinematics":
            arrays = (_read(getattr(body, key), (self._bodies, width), key) for key, width in WIDTHS.items())
            kinematics = Kinematics(request.step, *arrays)
            force, torque = self._timed("exchange", self.solver.exchange, kinematics)
            _write(reply.loads.force_N, force, (self._loads, 3), "force_N")
            _write(reply.loads.torque_N_m, torque, (self._loads, 3), "torque_N_m")

    def follow_up(self, name):
        if name == "Kinematics":
            self._timed("advance", self.solver.advance)


class ServedBody(_Served):
    role = "body"

    def _configured(self, setup, reply):
        self._actuators = len(setup.actuators)
        reply.driving_nodes.extend(self.solver.driving_nodes())

    def _step(self, name, body, request, reply):
        if name == "KinematicsRequest":
            write_kinematics(self.solver.kinematics(), self._bodies, reply)
        elif name == "AppliedLoads":
            shapes = {"force_N": (self._bodies, 3), "torque_N_m": (self._bodies, 3)}
            shapes["actuation"] = (len(self.solver.driving_nodes()), self._actuators)
            arrays = (_read(getattr(body, key), shape, key) for key, shape in shapes.items())
            applied = AppliedLoads(request.step, *arrays)
            write_kinematics(self._timed("step", self.solver.step, applied), self._bodies, reply)


class ServedController(_Served):
    role = "controller"

    def _configured(self, setup, reply):
        self._actuators, self._flow = len(setup.actuators), len(setup.flow)
        if not hasattr(self.solver, "save"):
            self.solver = _KeepsState(self.solver)

    def _step(self, name, body, request, reply):
        widths = WIDTHS | {"force_N": 3, "torque_N_m": 3}
        shapes = {key: (self._bodies, width) for key, width in widths.items()} | {"flow": (self._flow,)}
        arrays = (_read(getattr(body, key), shape, key) for key, shape in shapes.items())
        action = self._timed("act", self.solver.act, Observation(request.step, *arrays))
        reply.action.SetInParent()
        _write(reply.action.value, action, (self._actuators,), "an action")


class _KeepsState:
    """A controller whose `state`, if it has one, is of JSON values; on disk it has its checksum behind it."""

    def __init__(self, controller):
        self._controller, self.act = controller, controller.act

    def save(self, path):
        content = json.dumps(getattr(self._controller, "state", None)).encode()
        with open(path, "xb") as file:
            file.write(content + checksum(content))
            file.flush()
            os.fsync(file.fileno())

    def restore(self, path):
        with open(path, "rb") as file:
            content = file.read()
        state, end = content[:-9], content[-9:]
        if end != checksum(state):
            raise ValueError("its checksum is wrong")
        self._controller.state = json.loads(state)

    def summarise(self):
        return Summary()


def write_kinematics(kinematics, bodies, reply):
    reply.step = kinematics.step
    reply.kinematics.SetInParent()
    for name, width in WIDTHS.items():
        _write(getattr(reply.kinematics, name), getattr(kinematics, name), (bodies, width), name)
