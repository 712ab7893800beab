"""What every fluid does: nothing to bodies at rest in a fluid at rest, and never anything along a motion."""

import numpy as np

from copepod_conformance.cases import CELL_M, DIRECTION, DOMAIN_CELLS, DRAG_N, DRAG_N_M, SPEED_M_PER_S, SPIN_RAD_PER_S
from copepod_conformance.cases import OTHER_SHAPES, give_shape, rows
from copepod_conformance.verdicts import Check, NotApplicable, Violation, implied

_REST = implied("a fluid at rest exerts no load on bodies at rest")
_AGAINST = implied("in a fluid that was at rest the load on a moving body is against its motion")
_SAMPLED = implied("Loads.flow has what FlowSampling asks for, in the steps in which it does")

_ROUNDING = 1e-9  # of the Stokes drag on a body that moves as in the other checks
_STEPS = 3
_LOADS = {"force": ("force_N", DRAG_N), "torque": ("torque_N_m", DRAG_N_M)}  # field, Stokes drag


def _replies(trial, *motion):
    """(step, Loads) of some steps; `motion`: of the bodies, as motion_request takes it behind the step."""
    for step in range(_STEPS):
        yield step, trial.request(trial.case.motion_request(step, *motion)).envelope.loads


def _at_rest(trial):
    _require_rest(trial)
    trial.configure()
    for step, loads in _replies(trial, np.zeros((2, 3)), np.zeros((2, 3))):
        for name, (field, drag) in _LOADS.items():
            share = np.abs(rows(loads, field)).max() / drag
            if not share <= _ROUNDING:
                raise Violation(
                    f"at step {step} a {name} of {share:.3g} times the Stokes drag at "
                    f"{SPEED_M_PER_S:.3g} m/s on a body at rest"
                )


def _against(trial, kind):
    """Body 0 moves or turns, body 1 rests."""
    _require_loads(trial, kind)
    trial.configure()
    field, drag = _LOADS[kind]
    for step, loads in _replies(trial, *_motion_of(kind, np.array([DIRECTION, np.zeros(3)]))):
        load = rows(loads, field)[0] / drag
        if not np.all(load * DIRECTION < 0):
            raise Violation(
                f"at step {step} a {kind} of {_text(load)} times the Stokes drag on a body that "
                f"{'moves' if kind == 'force' else 'turns'} along {_text(DIRECTION)}"
            )


def _motion_of(kind, directions):
    """Velocities and angular velocities of bodies that move (for a force) or turn (for a torque) along `directions`."""
    none = np.zeros_like(directions)
    return (SPEED_M_PER_S * directions, none) if kind == "force" else (none, SPIN_RAD_PER_S * directions)


def _of_shapes(trial, kind, shapes):
    """A row of bodies of these shapes, and an obstacle behind them if it may have loads."""
    _require_loads(trial, kind)
    has_obstacle = trial.subject.can("obstacle_loads")
    trial.reach("greeted")
    request = trial.case.setup_request()
    content, spacing = request.fluid_setup, 16
    content.domain_cells[0] = spacing * (len(shapes) + has_obstacle)
    del content.bodies[:]
    for name in shapes:
        give_shape(content, content.bodies.add(), name)
    places = [np.array([spacing * (0.5 + i), 12.0, 12.0]) * CELL_M for i in range(len(shapes) + has_obstacle)]
    if has_obstacle:
        place = {"position_m": places.pop(), "orientation_wxyz": (1, 0, 0, 0)}
        give_shape(content, content.obstacles.add(name="still", loads=True, **place).shape, "sphere")
    trial.request(request)
    for step, loads in _replies(trial, *_motion_of(kind, np.array([DIRECTION] * len(shapes))), places):
        found = rows(loads, _LOADS[kind][0], bodies=len(shapes) + has_obstacle)
        for name, load in zip(shapes, found):
            if not load @ DIRECTION < 0:
                raise Violation(f"at step {step} a {kind} of {_text(load)} on a {name} along its motion")
        if has_obstacle and np.abs(found[-1]).max() > 1e-3 * np.abs(found[0]).max():
            raise Violation(f"at step {step} a {kind} of {_text(found[-1])} on an obstacle ten cells from all motion")


def _samples(trial):
    """Every other step, of the flow around a body that moves."""
    trial.reach("greeted")
    probe = {"name": "middle", "position_m": [0.5 * CELL_M * cells for cells in DOMAIN_CELLS]}
    faces = list(range(6)) if trial.subject.can("flow_samples:faces") else []
    trial.request(trial.case.setup_request(flow={"every_steps": 2, "totals": True, "probes": [probe], "faces": faces}))
    for step, loads in _replies(trial, *_motion_of("force", np.array([DIRECTION, np.zeros(3)]))):
        found = loads.flow
        if len(found) != (10 + 4 * len(faces) if step % 2 == 0 else 0):
            raise Violation(f"at step {step} {len(found)} values for totals, a probe, and faces in every second step")
    if not min(found[:3]) > 0:
        raise Violation(f"energy, dissipation and enstrophy of {_text(found[:3])} around a body that moves")
    if faces and np.any(found[10::4]):
        raise Violation(f"a flow of {_text(found[10::4])} m³/s into walls at rest")


def _require_loads(trial, kind):
    if trial.case.solver == "vacuum" or trial.subject.can("neglects:loads"):
        raise NotApplicable("it exerts no loads: its solver is vacuum, or it announces neglects:loads")
    if kind == "torque" and trial.subject.can("neglects:torques"):
        raise NotApplicable("it announces neglects:torques")
    _require_rest(trial)


def _require_rest(trial):
    if trial.subject.can("imposes:flow"):
        raise NotApplicable("its fluid is not at rest: it announces imposes:flow")


def _text(vector):
    return "(" + ", ".join(f"{value:.3g}" for value in vector) + ")"


def checks(subject):
    on_lattice = subject.case.solver in ("lattice_boltzmann", "external")
    shapes = [name for name in OTHER_SHAPES if on_lattice and subject.can(f"shape:{name}")]
    return [
        Check("physics", "no loads on bodies at rest in a fluid at rest", _REST, _at_rest),
        Check("physics", "a force against the motion", _AGAINST, _against, ("force",)),
        Check("physics", "a torque against the rotation", _AGAINST, _against, ("torque",)),
        *([Check("physics", "samples of the flow", _SAMPLED, _samples, needs=("flow_samples",))] * on_lattice),
        *(
            Check("physics", f"a {kind} against the {motion} of other shapes", _AGAINST, _of_shapes, (kind, shapes))
            for kind, motion in (("force", "motion"), ("torque", "rotation"))
            if shapes
        ),
    ]
