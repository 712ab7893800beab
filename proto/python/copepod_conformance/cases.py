"""The cases that components are tested with: two spheres in a small closed box of liquid, or in empty space."""

import math

import numpy as np

from copepod_component.messages import Envelope, setup
from copepod_conformance.protocol import content
from copepod_conformance.verdicts import Violation

SOLVERS = {
    "lattice_boltzmann": setup.FLUID_KIND_LATTICE_BOLTZMANN,
    "stokes": setup.FLUID_KIND_STOKES,
    "vacuum": setup.FLUID_KIND_VACUUM,
    "external": setup.FLUID_KIND_LATTICE_BOLTZMANN,
}

STEP_S = 7.548e-10  # with cell and viscosity a relaxation time of 2/3
CELL_M = 1e-6
DENSITY_KG_PER_M3 = 1360.0
VISCOSITY_M2_PER_S = 7.36e-5
RADIUS_M = 3 * CELL_M
DOMAIN_CELLS = (32, 24, 24)
POSITIONS_M = ((8 * CELL_M, 12 * CELL_M, 12 * CELL_M), (24 * CELL_M, 12 * CELL_M, 12 * CELL_M))
SPEED_M_PER_S = 1e-3 * CELL_M / STEP_S  # a thousandth of a cell per step
SPIN_RAD_PER_S = SPEED_M_PER_S / RADIUS_M
DRAG_N = 6 * math.pi * DENSITY_KG_PER_M3 * VISCOSITY_M2_PER_S * RADIUS_M * SPEED_M_PER_S  # Stokes: a scale
DRAG_N_M = 8 * math.pi * DENSITY_KG_PER_M3 * VISCOSITY_M2_PER_S * RADIUS_M**3 * SPIN_RAD_PER_S
MASS_KG = 2.3e-13
INERTIA_KG_M2 = 0.4 * MASS_KG * RADIUS_M**2  # of a sphere of uniform density
FORCE_N = MASS_KG * 0.1 * SPEED_M_PER_S / STEP_S  # a tenth of the speed in every step
TORQUE_N_M = INERTIA_KG_M2 * 0.1 * SPIN_RAD_PER_S / STEP_S
ZERO = (0.0, 0.0, 0.0)
AT_CENTRES: dict = {"anchor_A_m": ZERO, "anchor_B_m": ZERO}
_INTEGRATORS = ("runge_kutta_4", "semi_implicit_euler")
DIRECTION = np.array([0.5, -1.0, 0.25])
_CORNERS_M = np.array([(8, 12, 12), (24, 12, 12), (16, 12, 20)]) * CELL_M
_PATTERN_OF_THREE = np.array([DIRECTION, -DIRECTION, 2 * DIRECTION])
_PARAMETERS = '{"target_m": [1e-6, 1e-6], "stroke_m": 1e-6}'  # of our own examples
_PATTERN = np.array([DIRECTION, (-0.25, 0.5, 1.0)])  # motion in units of SPEED and SPIN, loads in units of FORCE
_BALL = {"kind": setup.SHAPE_KIND_SPHERE, "radius_m": RADIUS_M}
_SPHERE = {
    "mass_kg": MASS_KG,
    "shape": _BALL,
    "motion": setup.MOTION_KIND_FREE,
    "axis": (0.0, 0.0, 1.0),
    "orientation_wxyz": (1.0, 0.0, 0.0, 0.0),
    "velocity_m_per_s": (SPEED_M_PER_S, 0.0, 0.0),
    "angular_velocity_rad_per_s": ZERO,
}


class FluidCase:
    def __init__(self, features, solver=None):
        self.solver = solver or next((name for name in SOLVERS if f"solver:{name}" in features), "external")

    def setup_request(self, **changes):
        """`changes`: fields of the setup that differ."""
        lattice = {"step_s": STEP_S, "cell_size_m": CELL_M, "domain_cells": DOMAIN_CELLS}
        liquid = {"density_kg_per_m3": DENSITY_KG_PER_M3, "kinematic_viscosity_m2_per_s": VISCOSITY_M2_PER_S}
        wall = {"kind": setup.BOUNDARY_KIND_NO_SLIP, "velocity_m_per_s": ZERO}
        choices = {
            "kind": SOLVERS[self.solver],
            "boundaries": 6 * [wall],
            "symmetry_planes": 3 * [False],
            "body_force_N_per_m3": ZERO,
            "initial_flow": {"kind": setup.INITIAL_FLOW_KIND_REST, "velocity_m_per_s": ZERO},
            "collision": setup.COLLISION_KIND_BGK,
            "precision": setup.PRECISION_DOUBLE,
            "moving_boundary": setup.MOVING_BOUNDARY_BOUNCE_BACK,
            "refill": setup.REFILL_EQUILIBRIUM,
            "bodies": len(POSITIONS_M) * [_BALL],
            "fields": {},
            "flow": {},
        }
        return Envelope(step=0, fluid_setup={**lattice, **liquid, **choices, **changes})

    def step_request(self, step):
        """Both bodies move and turn steadily."""
        return self.motion_request(step, SPEED_M_PER_S * _PATTERN, SPIN_RAD_PER_S * _PATTERN)

    @staticmethod
    def motion_request(step, velocity_m_per_s, spin_rad_per_s, start_m=POSITIONS_M):
        """Kinematics of bodies that have kept these velocities since step 0; the spheres' orientation stays."""
        motion = {
            "position_m": np.ravel(start_m + step * STEP_S * velocity_m_per_s),
            "orientation_wxyz": (1.0, 0.0, 0.0, 0.0) * len(start_m),
            "velocity_m_per_s": np.ravel(velocity_m_per_s),
            "angular_velocity_rad_per_s": np.ravel(spin_rad_per_s),
        }
        return Envelope(step=step, kinematics=motion)


class BodyCase:
    def __init__(self, features, solver=None):
        self.solver = solver or ""
        named = next((name for name in _INTEGRATORS if f"integrator:{name}" in features), _INTEGRATORS[0])
        self._integrator = setup.Integrator.Value(f"INTEGRATOR_{named.upper()}")
        self._is_driven = "actuator:pair_force" in features
        self.driving_nodes = [0.0]  # at which it requests values of actuators [steps]; its Configured replaces them

    def setup_request(self, **changes):
        """`changes`: fields of the setup that differ."""
        numbers = {"step_s": STEP_S, "gravity_m_per_s2": ZERO, "periodic_length_m": ZERO}
        actuators = [actuator("pair_force", body_B=2)] if self._is_driven else []
        parts = {"integrator": self._integrator, "bodies": spheres({}, {}), "actuators": actuators}
        return Envelope(step=0, body_setup={**numbers, **parts, **changes})

    def step_request(self, step):
        """Hydrodynamic loads on both bodies, and the drive; they grow, so that no two steps are alike."""
        force_N = (1 + step / 8) * FORCE_N
        return self.loads_request(step, force_N * _PATTERN, [ZERO, ZERO], [force_N] if self._is_driven else ())

    def loads_request(self, step, force_N, torque_N_m, values=()):
        """Loads on the bodies, and the values of the actuators: constant, or a function of time in steps."""
        actuation = [values(step + node) if callable(values) else values for node in self.driving_nodes]
        loads = {"force_N": np.ravel(force_N), "torque_N_m": np.ravel(torque_N_m), "actuation": np.ravel(actuation)}
        return Envelope(step=step, applied_loads=loads)


class ControllerCase:
    """Three spheres, of which it sees the motion that a fluid would meet; it sets three actuators."""

    def __init__(self, features, solver=None):
        self.solver = ""

    def setup_request(self, **changes):
        """`changes`: fields of the setup that differ."""
        setup = {"name": "pilot", "step_s": STEP_S, "every_steps": 1, "parameters": _PARAMETERS}
        names = {"bodies": ["A", "B", "C"], "actuators": [f"actuators.{number}" for number in range(3)]}
        return Envelope(step=0, controller_setup={**setup, **names, **changes})

    def step_request(self, step):
        velocity, spin = SPEED_M_PER_S * _PATTERN_OF_THREE, SPIN_RAD_PER_S * _PATTERN_OF_THREE
        motion = content(FluidCase.motion_request(step, velocity, spin, _CORNERS_M))
        fields: dict = {field.name: list(value) for field, value in motion.ListFields()}
        loads = {"force_N": FORCE_N * np.ravel(velocity), "torque_N_m": TORQUE_N_M * np.ravel(spin)}
        return Envelope(step=step, observation={**fields, **loads})


OTHER_SHAPES = ("capsule", "ellipsoid", "cylinder", "box", "mesh", "compound")
_LENGTHS_IN_CELLS: dict[str, dict] = {
    "sphere": {"radius_m": 2.5},
    "capsule": {"radius_m": 2.0, "length_m": 3.0},
    "ellipsoid": {"radius_m": 24 ** (1 / 3), "extents_m": (2.0, 3.0, 4.0)},
    "cylinder": {"radius_m": 2.5, "length_m": 5.0},
    "box": {"radius_m": (90 / math.pi) ** (1 / 3), "extents_m": (4.0, 5.0, 6.0)},
    "mesh": {"radius_m": 4 / math.pi ** (1 / 3)},  # an octahedron
    "compound": {"radius_m": 2.5 * 2 ** (1 / 3)},  # two spheres
}


def give_shape(content, shape, name):
    """Makes `shape`, part of a setup, one of this kind around its centre of mass, some six cells long."""
    lengths = {key: np.multiply(CELL_M, cells) for key, cells in _LENGTHS_IN_CELLS[name].items()}
    shape.MergeFrom(setup.Shape(kind=f"SHAPE_KIND_{name.upper()}", **lengths))
    if name == "mesh":
        corners = np.concatenate([np.eye(3), -np.eye(3)]) * 4 * CELL_M
        upper = [(0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2)]
        triangles = upper + [(b, a, 5) for a, b, _ in upper]
        content.meshes.add(vertices_m=corners.ravel(), triangles=np.ravel(triangles))
        shape.mesh = len(content.meshes)
    if name == "compound":
        for end in (-2.5, 2.5):
            part = shape.parts.add(position_m=(0, 0, end * CELL_M), orientation_wxyz=(1, 0, 0, 0))
            give_shape(content, part.shape, "sphere")


def spheres(*changes):
    """Bodies of a BodySetup: both spheres, each with the fields that differ."""
    return [
        {"name": f"sphere {number}", "position_m": position, **_SPHERE, **change}
        for number, (position, change) in enumerate(zip(POSITIONS_M, changes))
    ]


def actuator(name, direction=(0.0, 0.0, 1.0), **fields):
    """An actuator of a BodySetup, with its anchors in the centres."""
    return {"kind": f"ACTUATOR_KIND_{name.upper()}", "direction": direction, **AT_CENTRES, **fields}


def rows(message, field, width=3, bodies=len(POSITIONS_M)):
    """A field of the reply, shape (bodies, width); raises Violation if it is not of that size."""
    numbers = np.array(getattr(message, field))
    if numbers.size != width * bodies:
        where = f"{message.DESCRIPTOR.name}.{field}"
        raise Violation(f"{numbers.size} numbers in {where} instead of {width} for each of {bodies} bodies")
    return numbers.reshape(bodies, width)
