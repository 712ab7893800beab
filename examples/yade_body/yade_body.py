#!/usr/bin/python3
"""Yade as the bodies of Copepod: spheres under gravity that meet each other and plane walls.

Yade [yade-dem.org; Debian's package yade] detects the contacts, computes their forces (linear spring and damper with
the restitution of the case, Coulomb friction, rolling friction) and integrates:
    v(n+1) = v(n) + h F/m,   x(n+1) = x(n) + h v(n+1)
First order in the step h, which is divided where contacts are short. Weight, hydrodynamic loads, springs and drive go
to Yade as forces on its bodies. Run a case:
    deploy/copepod run CASE.yaml --body "/usr/bin/python3 examples/yade_body/yade_body.py --rolling-friction 0.1"
"""

import argparse
import dataclasses
import hashlib
import math
import os
import shutil
import sys
from functools import partial
from pathlib import Path

import numpy as np

from copepod_component import CaseError, Capabilities, Kinematics, SolverError, StorageError, Summary
from copepod_component import run_body_component
from copepod_component.messages import setup as schema

YADE_MODULES = "/usr/lib/x86_64-linux-gnu/yade-double/py"
FEATURES = """integrator:semi_implicit_euler shape:sphere motion:free motion:fixed motion:prescribed gravity springs
    actuator:pair_force actuator:world_force contact contact:friction walls checkpoint""".split()
POISSON = 2 / 7  # ratio of the tangential to the normal stiffness


def load_yade():
    """Yade, its quaternions and its one scene. While its library loads, no thread of Python can answer a ping."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    sys.path.insert(1, YADE_MODULES)
    import yade.wrapper
    from yade.minieigenHP import Quaternion

    scene = yade.wrapper.Omega()
    shutil.rmtree(Path(scene.tmpFilename()).parent, ignore_errors=True)  # which Yade would leave behind
    return yade.wrapper, Quaternion, scene


def _column(entries, name):
    return np.array([getattr(entry, name) for entry in entries], dtype=float)


def _rows(entries, name):
    return np.array([list(getattr(entry, name)) for entry in entries], dtype=float).reshape(-1, 3)


class Pairs:
    """Springs and pair forces between the centres of bodies; arrays have one row per pair."""

    def __init__(self, entries, first_number):
        if _rows(entries, "anchor_A_m").any() or _rows(entries, "anchor_B_m").any():
            raise CaseError("A spring or pair force has an anchor (unknown to yade_body). Attach it to the centre.")
        self.A = _column(entries, "body_A").astype(int)
        self.B = _column(entries, "body_B").astype(int) - first_number

    def directions(self, position_m):
        """Unit vectors from A to B, and the distances."""
        between_m = position_m[self.B] - position_m[self.A]
        length_m = np.linalg.norm(between_m, axis=1)
        if not length_m.all():
            raise SolverError("Two bodies that a spring or pair force joins coincide. Start them apart.")
        return between_m / length_m[:, None], length_m

    def add(self, force_N, attraction_N, direction):
        for bodies, sign in ((self.A, 1), (self.B, -1)):
            np.add.at(force_N, bodies, sign * attraction_N[:, None] * direction)


class YadeBodies:
    def __init__(self, setup, _context, engine, rolling_friction):
        self._yade, self._quaternion, self._scene = engine
        self._count = len(setup.bodies)
        self._springs, self._spring_entries = Pairs(setup.springs, 0), setup.springs
        self._is_pair = np.array([a.kind == schema.ACTUATOR_KIND_PAIR_FORCE for a in setup.actuators], dtype=bool)
        self._pair_forces = Pairs([a for a, pair in zip(setup.actuators, self._is_pair) if pair], 1)
        self._world_forces = [a for a, pair in zip(setup.actuators, self._is_pair) if not pair]
        volume_m3 = 4 / 3 * np.pi * np.array([body.shape.radius_m for body in setup.bodies]) ** 3
        heavier_kg = _column(setup.bodies, "mass_kg") - setup.fluid_density_kg_per_m3 * volume_m3
        self._weight_N = heavier_kg[:, None] * np.array(setup.gravity_m_per_s2)
        for body in setup.bodies:
            self._add_sphere(body, setup.contact, rolling_friction)
        for wall in setup.walls:
            self._add_wall(wall, setup, rolling_friction)
        self._substeps, self._step = 1, 0
        if setup.bodies and setup.contact.stiffness_N_per_m:  # a contact lasts π contact_s
            contact_s = np.sqrt(min(body.mass_kg for body in setup.bodies) / 2 / setup.contact.stiffness_N_per_m)
            self._substeps = max(1, math.ceil(setup.step_s / (0.1 * contact_s)))
        self._scene.dt = setup.step_s / self._substeps
        self._set_engines(setup.contact.stiffness_N_per_m > 0)

    def _set_engines(self, contacts):
        y = self._yade
        collider = y.InsertionSortCollider([y.Bo1_Sphere_Aabb(), y.Bo1_Wall_Aabb()], verletDist=0.0)
        shapes = [y.Ig2_Sphere_Sphere_ScGeom(), y.Ig2_Wall_Sphere_ScGeom()]
        laws = [y.Ip2_ViscElMat_ViscElMat_ViscElPhys()], [y.Law2_ScGeom_ViscElPhys_Basic()]
        search = [collider, y.InteractionLoop(shapes, *laws)]
        newton = y.NewtonIntegrator(damping=0, gravity=(0, 0, 0))
        self._scene.engines = [y.ForceResetter(), *(search if contacts else []), newton]

    def _material(self, contact, young_Pa, friction, rolling_friction):
        """The damper of a contact follows from the restitution."""
        e, angle_rad = contact.restitution, math.atan(friction)
        elastic = {"young": young_Pa, "poisson": POISSON, "en": e, "et": e}
        return self._yade.ViscElMat(**elastic, frictionAngle=angle_rad, mR=rolling_friction)

    def _add(self, shape, material, position_m, velocity_m_per_s, moves_freely):
        body = self._yade.Body()
        body.shape, body.material, body.bound, body.aspherical = shape, material, self._yade.Aabb(), False
        body.state.pos, body.state.vel = tuple(position_m), tuple(velocity_m_per_s)
        body.state.blockedDOFs = "" if moves_freely else "xyzXYZ"
        self._scene.bodies.append(body)
        return body.state

    def _add_sphere(self, body, contact, rolling_friction):
        radius_m, free = body.shape.radius_m, body.motion == schema.MOTION_KIND_FREE
        young_Pa = contact.stiffness_N_per_m / (2 * radius_m)  # two spheres then meet with that stiffness
        material = self._material(contact, young_Pa, contact.friction, rolling_friction)
        shape = self._yade.Sphere(radius=radius_m)
        state = self._add(shape, material, body.position_m, body.velocity_m_per_s, free)
        state.angVel = tuple(body.angular_velocity_rad_per_s)
        state.ori = self._quaternion(*body.orientation_wxyz)
        state.mass, state.inertia = body.mass_kg, 3 * (0.4 * body.mass_kg * radius_m**2,)

    def _add_wall(self, wall, setup, rolling_friction):
        axis = int(np.argmax(np.abs(wall.normal)))
        if wall.friction > setup.contact.friction:
            raise CaseError("A wall is rougher than the bodies (Yade takes the lower friction). Lower wall friction.")
        rigid_Pa = 1e15 * setup.contact.stiffness_N_per_m  # beside that of a sphere
        material = self._material(setup.contact, rigid_Pa, wall.friction, rolling_friction)
        shape = self._yade.Wall(axis=axis, sense=int(np.sign(wall.normal[axis])))
        state = self._add(shape, material, wall.point_m, wall.velocity_m_per_s, False)
        state.mass = 1e9 * max((body.mass_kg for body in setup.bodies), default=1.0)  # of a light one Yade takes half

    def driving_nodes(self):
        return [0.0]

    def kinematics(self):
        states = [self._scene.bodies[i].state for i in range(self._count)]

        def array(name, width=3):
            return np.array([list(getattr(state, name)) for state in states], dtype=float).reshape(-1, width)

        orientation = np.roll(array("ori", 4), 1, axis=1)  # Yade has x, y, z, w
        return Kinematics(self._step, array("pos"), orientation, array("vel"), array("angVel"))

    def step(self, applied):
        now, force_N = self.kinematics(), self._weight_N + applied.force_N
        values_N = applied.actuation[0]
        direction, _ = self._pair_forces.directions(now.position_m)
        self._pair_forces.add(force_N, -values_N[self._is_pair], direction)
        for actuator, value_N in zip(self._world_forces, values_N[~self._is_pair]):
            force_N[actuator.body_A] += value_N * np.array(actuator.direction)
        self._springs.add(force_N, *self._tensions(now))
        for i in range(self._count):
            self._scene.forces.setPermF(i, tuple(force_N[i]))
            self._scene.forces.setPermT(i, tuple(applied.torque_N_m[i]))
        for _ in range(self._substeps):
            self._scene.step()
        self._step = applied.step + 1
        return self.kinematics()

    def _tensions(self, now):
        direction, length_m = self._springs.directions(now.position_m)
        velocity, entries = now.velocity_m_per_s, self._spring_entries
        stretching = ((velocity[self._springs.B] - velocity[self._springs.A]) * direction).sum(axis=1)
        elastic_N = _column(entries, "stiffness_N_per_m") * (length_m - _column(entries, "rest_length_m"))
        return elastic_N + _column(entries, "damping_N_s_per_m") * stretching, direction

    def save(self, path):
        """Yade's own file of the scene, contacts included, and its checksum."""
        folder = Path(path)
        try:
            folder.mkdir()
            self._scene.save(str(folder / "scene.yade"))
            digest = hashlib.sha256((folder / "scene.yade").read_bytes()).hexdigest()
            (folder / "state").write_text(f"{self._step} {digest}")
        except (OSError, RuntimeError) as error:
            shutil.rmtree(folder, ignore_errors=True)
            raise StorageError(f"The folder {path} cannot be written ({error}). Choose another path.") from error

    def restore(self, path):
        step, digest = (Path(path) / "state").read_text().split()
        if hashlib.sha256((Path(path) / "scene.yade").read_bytes()).hexdigest() != digest:
            raise ValueError("its checksum is wrong")  # what is raised here is a damaged file to the kit
        self._scene.load(str(Path(path) / "scene.yade"))
        self._step = int(step)

    def summarise(self):
        now = dataclasses.astuple(self.kinematics())
        bits = b"".join(array.tobytes() for array in now[1:])
        return Summary(digest=int.from_bytes(hashlib.sha256(bits).digest()[:8], "little"))


if __name__ == "__main__":
    own = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    own.add_argument("--rolling-friction", type=float, default=0.0)
    options, of_the_kit = own.parse_known_args()
    capabilities = Capabilities("Yade", "2023.02", FEATURES)
    engine = None if "--capabilities" in of_the_kit else load_yade()  # before the coupler expects answers to its pings
    make_bodies = partial(YadeBodies, engine=engine, rolling_friction=options.rolling_friction)
    sys.exit(run_body_component(make_bodies, capabilities, arguments=of_the_kit))
