"""A run whose coupler is in this process, advanced step by step and steered; on top of in_process/copepod.h."""

import ctypes
import functools
import json
import os
import select
import signal
import subprocess
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass, fields
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy

from copepod.errors import CaseError, CaseWarning, Error, RunError
from copepod.running import AnyCase, Settings, assignments, case_file
from copepod_run import build
from copepod_run.checkout import COMMAND, program
from copepod_run.errors import ExitCode

_SLICE_S = 0.05  # of a long step: Python takes signals between two calls
_MISUSE = 64


@dataclass(frozen=True)
class Bodies:
    """Motion at the start of the step that comes next, and the fluid's loads during the one before, as copies."""

    names: list[str]  #: of the bodies, in the order of all arrays
    position_m: Any  #: of the centre of mass, (bodies, 3)
    orientation_wxyz: Any  #: unit quaternion, (bodies, 4)
    velocity_m_per_s: Any  #: (bodies, 3)
    angular_velocity_rad_per_s: Any  #: (bodies, 3), in the world's frame
    force_N: Any  #: hydrodynamic, (bodies, 3)
    torque_N_m: Any  #: about the centre of mass, (bodies, 3)


_ARRAYS = [field.name for field in fields(Bodies)][1:]


class _State(ctypes.Structure):
    """copepod_state."""

    _fields_ = [
        *((name, ctypes.c_int64) for name in ("step", "bodies")),
        *((name, ctypes.POINTER(ctypes.c_double)) for name in _ARRAYS),
        ("flow_values", ctypes.c_int64),
        ("flow", ctypes.POINTER(ctypes.c_double)),
    ]


@functools.cache
def _library() -> ctypes.CDLL:
    build.ensure_targets(("copepod",))
    library = ctypes.CDLL(str(program("libcopepod.so")))
    library.copepod_error.restype = ctypes.c_char_p
    return library


def _call(name: str, *arguments: Any) -> None:
    """One of the C functions. Raises CaseError, RunError or, for a mistake of the caller, Error."""
    if code := getattr(_library(), name)(*arguments):
        kind = {ExitCode.BAD_CASE: CaseError, _MISUSE: Error}.get(code, RunError)
        raise kind(_library().copepod_error().decode(errors="replace"), code)


def _words(settings: Settings, ranks: int | None) -> list[str]:
    return assignments(settings) + ([f"services.fluid.ranks={ranks}"] if ranks else [])


class Actuators:
    """The case's actuators, in the order of `paths`: `actuators["joints.0"] = 1e-6`, or a number for the path, replaces
    the signal of the case by a constant from the next step on. In N, N m, m or rad, see docs/steering.md."""

    def __init__(self, handle: int, paths: list[str]) -> None:
        self._handle = ctypes.c_int64(handle)
        self.paths = paths

    def __len__(self) -> int:
        return len(self.paths)

    def __setitem__(self, actuator: str | int, value: float) -> None:
        self.move(actuator, value, 0)

    def move(self, actuator: str | int, value: float, steps: int) -> None:
        """Changes a value linearly within so many steps from what it is; it then stays.

        @throws Error for an actuator that is not there, or a value that is not finite
        """
        if isinstance(actuator, str):
            if self.paths.count(actuator) != 1:
                raise Error(f"{actuator} is not one actuator of {self.paths}. Use one of them, or its number.", _MISUSE)
            actuator = self.paths.index(actuator)
        _call("copepod_act", self._handle, ctypes.c_int64(actuator), ctypes.c_double(value), ctypes.c_int64(steps))


class Snapshot:
    """A state of a simulation in memory; freed with this object."""

    def __init__(self, handle: int) -> None:
        self._handle = ctypes.c_int64(handle)
        self._number = ctypes.c_int64()
        _call("copepod_snapshot", self._handle, ctypes.byref(self._number))

    def __del__(self) -> None:
        _library().copepod_drop(self._handle, self._number)


class _Services:
    """Those of a simulation: started, watched and ended by a process beside this one, which ends with this one."""

    def __init__(self, **order: Any) -> None:
        """`order`: see `_services` of the command."""
        command = [str(COMMAND), "python", "-P", "-m", "copepod_command.run", json.dumps(order)]
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(command, stdin=pipe, stdout=pipe, start_new_session=True, bufsize=0)

    @contextmanager
    def settings(self) -> Iterator[list[str]]:
        """Context for opening a simulation; services that fail (CaseError, RunError), and a signal, end that."""
        answers: Any = self._process.stdout
        settings = self._read(answers.readline())["settings"]
        signals = os.open(f"/proc/self/fd/{answers.fileno()}", os.O_WRONLY | os.O_NONBLOCK)  # of the same pipe
        is_main = threading.current_thread() is threading.main_thread()  # which alone receives them
        former = signal.set_wakeup_fd(signals, warn_on_full_buffer=False) if is_main else -1
        try:
            yield [*settings, f"--stop={answers.fileno()}"]
        except RunError:
            if select.select([answers], [], [], 0)[0]:
                _, brace, problem = answers.read(1 << 16).partition(b"{")  # behind the numbers of signals
                self._read(brace + problem or b"{}")
            raise
        finally:
            if is_main:
                signal.set_wakeup_fd(former)
            os.close(signals)

    def _read(self, answer: bytes) -> dict[str, Any]:
        words = json.loads(answer or b'{"problem": "the services cannot be started (see above).", "code": 1}')
        if "problem" in words:
            raise (CaseError if words["code"] == ExitCode.BAD_CASE else RunError)(words["problem"], words["code"])
        return dict(words)

    def close(self, are_finished: bool) -> None:
        """Ends them; those that the simulation has finished end by themselves."""
        with suppress(BrokenPipeError):
            self._process.communicate(b"." if are_finished else b"")


class Simulation:
    """A case that this process advances, with all ranks of the fluid as threads, or with services.

        with copepod.Simulation("swimmer.yaml") as sim:
            start = sim.snapshot()
            sim.actuators.move("joints.0", -4e-6, steps=500)
            sim.step(500)
            print(sim.time_s, sim.bodies.position_m)
            sim.restore(start)

    Same case, same calls: the same bits, for any number of ranks. Any number of simulations may be open, each used by
    one thread at a time.
    """

    _handle = ctypes.c_int64()  # 0: not open
    _services: _Services | None = None

    def __init__(
        self,
        case: AnyCase,
        directory: str | Path | None = None,
        *,
        set: Settings = (),
        ranks: int | None = None,
        services: bool = False,
    ) -> None:
        """
        @param case       a Case, a dictionary or the path of a case file
        @param directory  new run directory, which `close` completes; None: no results are kept
        @param set        other values of some keys: {"run.steps": 1000} or ["run.steps=1000"]
        @param ranks      threads of the fluid; with services, its MPI ranks
        @param services   whether fluid, bodies and controllers are processes, as in `run`
        @throws CaseError for a bad case, RunError if a service cannot take part
        """
        with case_file(case) as file:
            order = {"case": str(file.path), "directory": directory and str(directory), "resumes": False}
            self._begin(file.shown, services, ranks=ranks, set=_words(set, ranks), **order)

    @classmethod
    def resume(
        cls, directory: str | Path, *, set: Settings = (), ranks: int | None = None, services: bool = False
    ) -> "Simulation":
        """Continues what is in a run directory, left by a simulation or by `run`, from its newest checkpoint, with or
        without services whatever it had. What was steered stays so.

        @throws RunError if the directory has no complete checkpoint
        """
        simulation = cls.__new__(cls)
        order = {"case": f"{directory}/case.yaml", "directory": str(directory), "resumes": True}
        simulation._begin(str, services, ranks=ranks, set=_words(set, ranks), **order)
        return simulation

    def _begin(self, shown: Callable[[str], str], services: bool, **order: Any) -> None:
        """`order`: case, set, ranks, directory, resumes."""
        self._handle = ctypes.c_int64()
        case, directory = order["case"].encode(), order["directory"] and order["directory"].encode()
        try:
            self._services = _Services(**order) if services else None
            with self._services.settings() if self._services else nullcontext(list[str]()) as connection:
                words = [word.encode() for word in (*order["set"], *connection)]
                settings = (ctypes.c_char_p * (len(words) + 1))(*words, None)
                if order["resumes"]:
                    _call("copepod_resume", directory, settings, ctypes.byref(self._handle))
                else:
                    _call("copepod_open", case, settings, directory, ctypes.byref(self._handle))
        except BaseException as error:
            self.close()
            if isinstance(error, CaseError):
                raise CaseError(shown(str(error)), error.code) from None
            raise
        text = ctypes.c_char_p()
        _call("copepod_describe", self._handle, ctypes.byref(text))
        description = json.loads(text.value or b"")
        for warning in description["warnings"]:
            warnings.warn(shown(warning), CaseWarning, stacklevel=3)
        self.step_s: float = description["step_s"]
        self.actuators = Actuators(self._handle.value, description["actuators"])
        self._names, self._flow = description["bodies"], description["flow"]

    def step(self, steps: int = 1) -> None:
        """Advances. An interrupt ends it within 0.1 s between two steps, and the state is whole.

        @throws RunError if the simulation diverges; a snapshot can be restored then
        """
        done = ctypes.c_int64()
        while True:
            limits = (ctypes.c_int64(steps), ctypes.c_double(_SLICE_S))
            _call("copepod_step", self._handle, *limits, ctypes.byref(done))
            steps -= done.value
            if steps <= 0:
                return

    def _state(self) -> _State:
        state = _State()
        _call("copepod_observe", self._handle, ctypes.byref(state))
        return state

    @property
    def steps(self) -> int:
        """Steps since the start of the case."""
        return int(self._state().step)

    @property
    def time_s(self) -> float:
        """Time since the start of the case."""
        return self.steps * self.step_s

    @property
    def bodies(self) -> Bodies:
        """The bodies at this moment."""
        state = self._state()
        arrays = []
        for name in _ARRAYS:
            shape = (len(self._names), 4 if name == "orientation_wxyz" else 3)
            values = numpy.ctypeslib.as_array(getattr(state, name), shape) if self._names else numpy.empty(shape)
            arrays.append(values.copy())
        return Bodies(self._names, *arrays)

    @property
    def flow(self) -> dict[str, float]:
        """Newest sample of the case's output.flow, by the names of flow.csv; empty before the first step."""
        state = self._state()
        return dict(zip(self._flow, state.flow[: state.flow_values]))

    @property
    def cycles(self) -> dict[str, dict[str, Any]]:
        """Figures of the last whole cycle of each swimmer and group by its name: `kinematics` of summary.json."""
        text = ctypes.c_char_p()
        _call("copepod_cycles", self._handle, ctypes.byref(text))
        found = json.loads(text.value or b"")
        return {each["name"]: each["kinematics"] for each in found["swimmers"] + found.get("groups", [])}

    def snapshot(self) -> Snapshot:
        """Keeps fluid, bodies, coupler and actuators in memory."""
        return Snapshot(self._handle.value)

    def restore(self, snapshot: Snapshot) -> None:
        """Returns to a state: what comes next has the bits of a run without interruption. Files in the run directory
        end where the state does.

        @throws Error for the snapshot of another simulation
        """
        _call("copepod_restore", self._handle, snapshot._number)

    def write_checkpoint(self) -> None:
        """Writes one into the run directory, for `resume`; the newest two are kept.

        @throws Error without a run directory, or before the first step
        """
        _call("copepod_write_checkpoint", self._handle)

    def close(self) -> None:
        """Completes the run directory, ends the services, and frees everything; a second time nothing."""
        handle, self._handle = self._handle, ctypes.c_int64()
        services, self._services = self._services, None
        try:
            if handle.value:
                _call("copepod_close", handle)
        finally:
            if services:
                services.close(are_finished=bool(handle.value))

    def __enter__(self) -> "Simulation":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def __del__(self) -> None:
        self.close()
