#!/usr/bin/python3
"""Components that each break one rule, by the component kit of Python. `copepod conformance` finds each.

    broken_components.py NAME [OPTIONS]      NAME: a function below; OPTIONS: those of a component
"""

import dataclasses
import hashlib
import math
import pathlib
import subprocess
import sys
import time
import zipfile

import numpy as np
import zmq

from copepod_component import (
    Capabilities,
    Kinematics,
    StorageError,
    Summary,
    control_lane,
    run_body_component,
    run_fluid_component,
    server,
    session,
    solvers,
)
from copepod_component.messages import Envelope
from copepod_component.messages import setup as schema

FLUID = Capabilities("Broken fluid", "1.0", ["solver:external", "shape:sphere", "checkpoint"])
BODY = Capabilities("Broken bodies", "1.0", ["motion:free", "shape:sphere", "checkpoint", "neglects:torques"])


class Drag:
    """F = −v, T = −ω in units of 1 N s/m and 1 N m s."""

    def __init__(self, setup, context):
        self.steps = 0

    def exchange(self, kinematics):
        return -kinematics.velocity_m_per_s, -kinematics.angular_velocity_rad_per_s

    def advance(self):
        self.steps += 1

    def save(self, path):
        try:
            pathlib.Path(path).write_text(f"{self.steps} steps\n")
        except OSError as error:
            raise StorageError(f"The file {path} cannot be written ({error}). Choose another one.") from error

    def restore(self, path):
        try:
            self.steps = int(pathlib.Path(path).read_text().split()[0])
        except (OSError, ValueError, IndexError) as error:
            raise StorageError(f"The file {path} cannot be read ({error}). Choose another one.") from error

    def summarise(self):
        return Summary(digest=self.steps)


class Masses:
    """Point masses, v(n+1) = v(n) + h F/m."""

    def __init__(self, setup, context):
        self.step_s = setup.step_s
        self.mass_kg = np.array([body.mass_kg for body in setup.bodies])[:, None]
        self.state = Kinematics(
            0,
            *(
                np.array([list(getattr(body, name)) for body in setup.bodies])
                for name in ("position_m", "orientation_wxyz", "velocity_m_per_s", "angular_velocity_rad_per_s")
            ),
        )

    def driving_nodes(self):
        return [0.0]

    def kinematics(self):
        return self.state

    def step(self, applied):
        state = self.state
        force_N = applied.force_N + self.drive_N(applied)
        state.velocity_m_per_s = state.velocity_m_per_s + self.step_s * force_N / self.mass_kg
        state.position_m = state.position_m + self.step_s * state.velocity_m_per_s
        state.step = applied.step + 1
        return state

    def drive_N(self, applied):
        """Forces of actuators and bends, which only some of the broken components have."""
        return 0.0

    def save(self, path):
        try:
            with open(path, "wb") as file:
                np.savez(file, step=self.state.step, x=self.state.position_m, v=self.state.velocity_m_per_s)
        except OSError as error:
            raise StorageError(f"The file {path} cannot be written ({error}). Choose another one.") from error

    def restore(self, path):
        try:
            with np.load(path) as saved:
                self.state.step, self.state.position_m, self.state.velocity_m_per_s = (
                    int(saved["step"]),
                    saved["x"],
                    saved["v"],
                )
        except (OSError, EOFError, ValueError, zipfile.BadZipFile) as error:
            raise StorageError(f"The file {path} cannot be read ({error}). Choose another one.") from error

    def summarise(self):
        bits = self.state.position_m.tobytes() + self.state.velocity_m_per_s.tobytes()
        return Summary(digest=int.from_bytes(hashlib.sha256(bits).digest()[:8], "little"))


def with_features(capabilities, *features, without=""):
    kept = [feature for feature in capabilities.features if feature != without]
    return dataclasses.replace(capabilities, features=[*kept, *features])


# -- the protocol


def announces_an_unknown_feature():
    """Because of a typing error."""
    return run_body_component(Masses, with_features(BODY, "springz"))


def is_no_component():
    """Prints nothing."""


def ends_as_if_all_were_well():
    """Its exit code is 0 whatever happened."""
    run_fluid_component(Drag, FLUID)
    return 0


def ignores_the_version():
    """Talks to couplers of any protocol version."""
    server.check_version = server.check_welcome = lambda message: None
    return run_fluid_component(Drag, FLUID)


def steps_twice_on_a_repeat():
    """Takes a request that comes again for a new one, and advances the bodies once more."""
    on_request = session.Session._on_request

    def forgets_the_last_number(session, name, envelope):
        if envelope.sequence == session.last_sequence and name == "AppliedLoads":
            session.last_sequence -= 1
            session.next_step = envelope.step
        return on_request(session, name, envelope)

    session.Session._on_request = forgets_the_last_number
    return run_body_component(Masses, BODY)


def accepts_nan():
    """Computes with numbers that are not finite."""
    solvers._read = lambda field, shape, name: np.reshape(np.nan_to_num(np.array(field)), shape)
    return run_fluid_component(Drag, FLUID)


def restores_another_state():
    """A restored run continues with the positions of the checkpoint and the velocities of the setup."""

    class ForgetfulMasses(Masses):
        def restore(self, path):
            velocity_m_per_s = self.state.velocity_m_per_s
            super().restore(path)
            self.state.velocity_m_per_s = velocity_m_per_s

    return run_body_component(ForgetfulMasses, BODY)


def starts_where_it_was():
    """It announces snapshots, and another setup finds the bodies where they were."""

    class RootedMasses(Masses):
        known = None

        def __init__(self, setup, context):
            super().__init__(setup, context)
            self.state = RootedMasses.known or self.state
            RootedMasses.known = self.state

    return run_body_component(RootedMasses, with_features(BODY, "snapshots"))


def saves_nothing():
    """Not broken: it has no checkpoints, and does not announce any."""

    class MassesWithoutMemory(Masses):
        save = restore = None

    return run_body_component(MassesWithoutMemory, with_features(BODY, without="checkpoint"))


# -- processes


def survives_its_coupler():
    """Waits for ever for a coupler that is gone."""
    control_lane.ControlLane._look_for_coupler = lambda lane: None
    return run_fluid_component(Drag, FLUID)


def takes_its_suspension_for_a_loss():
    """Counts the time in which it was suspended itself as silence of its coupler."""
    control_lane.PAUSE_S = math.inf
    return run_fluid_component(Drag, FLUID)


def ignores_an_abort():
    """Keeps waiting when the coupler has ended the run."""
    handle = control_lane.ControlLane._handle

    def is_deaf_to_abort(lane, socket, message):
        if Envelope.FromString(message).WhichOneof("body") != "abort":
            handle(lane, socket, message)

    control_lane.ControlLane._handle = is_deaf_to_abort
    return run_body_component(Masses, BODY)


def leaves_a_child():
    """Starts a process and forgets it."""

    class MassesWithAChild(Masses):
        def __init__(self, setup, context):
            super().__init__(setup, context)
            subprocess.Popen(["sleep", "600"], start_new_session=True)

    return run_body_component(MassesWithAChild, BODY)


def busy_while_it_waits():
    """Looks for the next message again and again instead of sleeping until it comes."""

    def spin(server, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if server._context.stop_code:
                return server._session.on_event("coupler lost")
            try:
                return server._handle(server._socket.recv(zmq.DONTWAIT))
            except zmq.Again:
                pass

    assert server.Server._serve  # takes the place of what is there
    server.Server._serve = spin
    return run_fluid_component(Drag, FLUID)


# -- physics


def drives_what_moves():
    """Its force is along the motion: a sign is missing."""

    class Propulsion(Drag):
        def exchange(self, kinematics):
            force_N, torque_N_m = super().exchange(kinematics)
            return -force_N, torque_N_m

    return run_fluid_component(Propulsion, FLUID)


def pulls_at_an_obstacle():
    """An obstacle far from all motion feels what a body feels, and boxes are driven along their motion."""

    class Pulls(Drag):
        def __init__(self, setup, context):
            super().__init__(setup, context)
            signs = [-1 if shape.kind == schema.SHAPE_KIND_BOX else 1 for shape in setup.bodies]
            self.signs, self.obstacles = np.array(signs)[:, None], len(setup.obstacles)

        def exchange(self, kinematics):
            force_N, torque_N_m = super().exchange(kinematics)
            ends = self.signs[: len(force_N)] * force_N, torque_N_m
            return [np.concatenate([loads, loads[-1:].repeat(self.obstacles, axis=0)]) for loads in ends]

    return run_fluid_component(
        Pulls, with_features(FLUID, "shape:box", "shape:ellipsoid", "obstacles", "obstacle_loads")
    )


def turns_a_box_as_a_sphere():
    """The inertia tensor of the setup is left aside."""

    class Spheres(Masses):
        def __init__(self, setup, context):
            super().__init__(setup, context)
            radius_m = np.array([body.shape.radius_m for body in setup.bodies])[:, None]
            self.inertia_kg_m2 = 0.4 * self.mass_kg * radius_m**2

        def step(self, applied):
            state = super().step(applied)
            gained = self.step_s * applied.torque_N_m / self.inertia_kg_m2
            state.angular_velocity_rad_per_s = state.angular_velocity_rad_per_s + gained
            return state

    return run_body_component(Spheres, with_features(BODY, "shape:box", "inertia", without="neglects:torques"))


class Driven(Masses):
    """Whose drive depends on where the bodies are."""

    def __init__(self, setup, context):
        super().__init__(setup, context)
        self.setup = setup

    def drive_N(self, applied):
        force_N = np.zeros_like(self.state.position_m)
        self.add_drive(applied, self.state.position_m, force_N)
        return force_N


def freezes_its_drive():
    """Its actuators keep the directions that they had at the start."""

    class Freezes(Masses):
        def __init__(self, setup, context):
            super().__init__(setup, context)
            self.unit_N = np.zeros((len(setup.actuators), *self.state.position_m.shape))
            for unit_N, actuator in zip(self.unit_N, setup.actuators):
                A, B = actuator.body_A, actuator.body_B - 1
                if actuator.kind != schema.ACTUATOR_KIND_PAIR_FORCE:
                    unit_N[A] = actuator.direction
                    continue
                between_m = self.state.position_m[B] - self.state.position_m[A]
                unit_N[B] = between_m / np.linalg.norm(between_m)
                unit_N[A] = -unit_N[B]

        def drive_N(self, applied):
            return np.tensordot(applied.actuation[0], self.unit_N, axes=1)

    return run_body_component(
        Freezes, with_features(BODY, "actuator:pair_force", "actuator:body_force", "actuator:world_force")
    )


def drives_with_a_net_torque():
    """The forces of a pair are opposite, but not along the line between the bodies."""

    class Twists(Driven):
        def add_drive(self, applied, x_m, force_N):
            for actuator, value_N in zip(self.setup.actuators, applied.actuation[0]):
                A, B = actuator.body_A, actuator.body_B - 1
                askew = (x_m[B] - x_m[A]) / np.linalg.norm(x_m[B] - x_m[A]) + [0.0, 0.0, 1e-9]
                force_N[A] -= value_N * askew
                force_N[B] += value_N * askew

    return run_body_component(Twists, with_features(BODY, "actuator:pair_force"))


def turns_a_world_force():
    """A force fixed in the world turns with the spin of its body."""

    class Turns(Driven):
        def add_drive(self, applied, x_m, force_N):
            for actuator, value_N in zip(self.setup.actuators, applied.actuation[0]):
                turned = applied.step * self.step_s * self.state.angular_velocity_rad_per_s[actuator.body_A]
                direction = np.array(actuator.direction)
                force_N[actuator.body_A] += value_N * (direction + np.cross(turned, direction))

    return run_body_component(Turns, with_features(BODY, "actuator:world_force"))


def bends_without_reaction():
    """A bend pushes the ends of its arms, but not the body between them."""

    class Bends(Driven):
        def add_drive(self, applied, x_m, force_N):
            for bend in self.setup.bends:
                A, B, C = (x_m[body] for body in (bend.body_A, bend.body_B, bend.body_C))
                a_m, c_m = np.linalg.norm(A - B), np.linalg.norm(C - B)
                a, c = (A - B) / a_m, (C - B) / c_m
                angle = np.arccos(a @ c)
                moment_N_m = bend.stiffness_N_m_per_rad * (angle - bend.rest_angle_rad) / np.sin(angle)
                force_N[bend.body_A] += moment_N_m / a_m * (c - a @ c * a)
                force_N[bend.body_C] += moment_N_m / c_m * (a - a @ c * c)

    return run_body_component(Bends, with_features(BODY, "bends"))


def lets_its_rods_drift():
    """It prevents accelerations along a rod, but does not correct what is left."""

    class Rods(Driven):
        def add_drive(self, applied, x_m, force_N):
            for joint in self.setup.joints:
                A, B = joint.body_A, joint.body_B - 1
                apart_m, apart_m_per_s, acceleration = (
                    one[A] - one[B] for one in (x_m, self.state.velocity_m_per_s, applied.force_N / self.mass_kg)
                )
                length_m = np.linalg.norm(apart_m)
                along = apart_m / length_m
                across_m_per_s = apart_m_per_s - along * (along @ apart_m_per_s)
                lacking = -(along @ acceleration) - across_m_per_s @ across_m_per_s / length_m
                force_N[A] += 0.5 * self.mass_kg[A] * lacking * along
                force_N[B] -= 0.5 * self.mass_kg[B] * lacking * along

    return run_body_component(Rods, with_features(BODY, "joint:distance"))


def passes_exits():
    """It announces exits and does not look at them."""
    return run_body_component(Masses, with_features(BODY, "removal"))


def moves_on_behind_exits():
    """It puts the body of the check behind the exit in time, and lets it move on there."""

    class MovesOn(Driven):
        def step(self, applied):
            state = Masses.step(self, applied)
            if self.setup.walls and applied.step == 2:
                state.position_m[0, 2] -= 1.0
            return state

        def add_drive(self, applied, x_m, force_N):
            pass

    return run_body_component(MovesOn, with_features(BODY, "removal"))


if __name__ == "__main__":
    sys.exit(globals()[sys.argv.pop(1)]())
