"""What a body component is tried with: two free spheres in empty space."""

from copepod_conformance import fluid_case
from copepod_conformance.protocol import Envelope, part, setup

_INTEGRATORS = {
    "runge_kutta_4": setup.INTEGRATOR_RUNGE_KUTTA_4,
    "semi_implicit_euler": setup.INTEGRATOR_SEMI_IMPLICIT_EULER,
}

STEP_S = fluid_case.STEP_S
RADIUS_M = fluid_case.RADIUS_M
POSITIONS_M = fluid_case.POSITIONS_M
MASS_KG = 2.3e-13
INERTIA_KG_M2 = 0.4 * MASS_KG * RADIUS_M**2  # of a sphere of uniform density
SPEED_M_PER_S = fluid_case.SPEED_M_PER_S
SPIN_RAD_PER_S = fluid_case.SPIN_RAD_PER_S
FORCE_N = MASS_KG * 0.1 * SPEED_M_PER_S / STEP_S  # a tenth of the speed in every step
TORQUE_N_M = INERTIA_KG_M2 * 0.1 * SPIN_RAD_PER_S / STEP_S
ZERO = (0.0, 0.0, 0.0)
_CHECKED_LOADS = ((0.5, -1.0, 0.25), (-0.25, 0.5, 1.0))  # in units of FORCE and TORQUE


class BodyCase:
    def __init__(self, features, solver=None):
        self.solver = solver or ""
        named = [number for name, number in _INTEGRATORS.items() if f"integrator:{name}" in features]
        self._integrator = (named or list(_INTEGRATORS.values()))[0]
        self.driving_nodes = 1

    def setup_request(self):
        request = Envelope(step=0)
        message = part(request, "BodySetup")
        message.step_s, message.integrator = STEP_S, self._integrator
        message.gravity_m_per_s2.extend(ZERO)
        message.periodic_length_m.extend(ZERO)
        for number, position in enumerate(POSITIONS_M):
            body = message.bodies.add(name=f"sphere {number}", mass_kg=MASS_KG, motion=setup.MOTION_KIND_FREE)
            body.shape.kind, body.shape.radius_m = setup.SHAPE_KIND_SPHERE, RADIUS_M
            body.axis.extend((0.0, 0.0, 1.0))
            body.position_m.extend(position)
            body.orientation_wxyz.extend((1.0, 0.0, 0.0, 0.0))
            body.velocity_m_per_s.extend((SPEED_M_PER_S, 0.0, 0.0))
            body.angular_velocity_rad_per_s.extend(ZERO)
        return request

    def step_request(self, step):
        """Hydrodynamic loads on both bodies; they grow with the step so that no two steps are alike."""
        growth = 1 + step / 8
        force = [[growth * FORCE_N * u for u in body] for body in _CHECKED_LOADS]
        return self.loads_request(step, force, [ZERO, ZERO], [ZERO, ZERO])

    def loads_request(self, step, force_N, torque_N_m, driving_N):
        """Loads on the bodies; the driving force is the same at all nodes of the step."""
        request = Envelope(step=step)
        message = part(request, "AppliedLoads")
        message.force_N.extend(u for body in force_N for u in body)
        message.torque_N_m.extend(u for body in torque_N_m for u in body)
        message.driving_N.extend([u for body in driving_N for u in body] * self.driving_nodes)
        return request

    def learn(self, configured):
        """The body says at how many instants of a step it wants driving forces."""
        self.driving_nodes = len(configured.configured.driving_nodes)
