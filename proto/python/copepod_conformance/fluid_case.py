"""What a fluid component is tried with: two spheres in a small closed box of liquid."""

import math

from copepod_conformance.protocol import Envelope, part, setup

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
REST = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
_CHECKED_MOTION = ((0.5, -1.0, 0.25), (-0.25, 0.5, 1.0))  # in units of SPEED and SPIN


class FluidCase:
    def __init__(self, features, solver=None):
        self.solver = solver or next((name for name in SOLVERS if f"solver:{name}" in features), "external")

    def setup_request(self):
        request = Envelope(step=0)
        message = part(request, "FluidSetup")
        message.kind = SOLVERS[self.solver]
        message.step_s, message.cell_size_m = STEP_S, CELL_M
        message.density_kg_per_m3, message.kinematic_viscosity_m2_per_s = DENSITY_KG_PER_M3, VISCOSITY_M2_PER_S
        message.domain_cells.extend(DOMAIN_CELLS)
        for _ in range(6):
            message.boundaries.add(kind=setup.BOUNDARY_KIND_NO_SLIP, velocity_m_per_s=[0, 0, 0])
        message.symmetry_planes.extend([False] * 3)
        message.body_force_N_per_m3.extend([0.0] * 3)
        message.collision, message.precision = setup.COLLISION_KIND_BGK, setup.PRECISION_DOUBLE
        message.moving_boundary, message.refill = setup.MOVING_BOUNDARY_BOUNCE_BACK, setup.REFILL_EQUILIBRIUM
        for _ in POSITIONS_M:
            message.bodies.add(kind=setup.SHAPE_KIND_SPHERE, radius_m=RADIUS_M)
        message.fields.SetInParent()
        return request

    def step_request(self, step):
        """Both bodies move and turn steadily."""
        velocity = [[SPEED_M_PER_S * u for u in body] for body in _CHECKED_MOTION]
        spin = [[SPIN_RAD_PER_S * u for u in body] for body in _CHECKED_MOTION]
        return self.motion_request(step, velocity, spin)

    @staticmethod
    def motion_request(step, velocity_m_per_s, spin_rad_per_s):
        """Kinematics of bodies that have kept these velocities since step 0; the spheres' orientation stays."""
        request = Envelope(step=step)
        message = part(request, "Kinematics")
        for start, velocity, spin in zip(POSITIONS_M, velocity_m_per_s, spin_rad_per_s):
            message.position_m.extend(x + step * STEP_S * u for x, u in zip(start, velocity))
            message.orientation_wxyz.extend([1.0, 0.0, 0.0, 0.0])
            message.velocity_m_per_s.extend(velocity)
            message.angular_velocity_rad_per_s.extend(spin)
        return request

    def learn(self, configured):
        """Nothing in the answer to the setup matters to a fluid's requests."""
