"""Cases drawn at random: whatever a case may contain, in small domains and for few steps.

Everything is drawn in lattice units (cells, steps, masses of a cell of fluid) and written in SI units. `draw(seed,
attempt, shapes)` is a function of its arguments alone. Some cases are refused by `copepod check`; take another attempt.
"""

import math
import random

import numpy as np

CELL_M = 1.0e-6
DENSITY_KG_PER_M3 = 1360.0
VISCOSITY_M2_PER_S = 7.36e-5
MASS_KG = DENSITY_KG_PER_M3 * CELL_M**3  # of a cell of fluid
TRIES = 60  # places for a body, before it is left out


def draw(seed, attempt=0, shapes=False):
    """A case as a dictionary, which is YAML when it is written as JSON.

    `shapes`: most bodies have other shapes than spheres and capsules, and there are obstacles.
    """
    drawn = _Draw(random.Random(f"{seed}/{attempt}"), f"random_{seed}")
    if shapes:
        drawn.replace_shapes()
        drawn.add_obstacles()
    return drawn.case


def with_controllers(case, seed, command):
    """The case with one or two controllers that set all that it drives, or some; None if it drives nothing."""
    rng = random.Random(f"controllers {seed}")
    signals = {f"actuators.{i}": each["signal"] for i, each in enumerate(case.get("actuators", []))}
    signals |= {f"joints.{i}": each["signal"] for i, each in enumerate(case.get("joints", [])) if "signal" in each}
    for i, body in enumerate(case.get("bodies", [])):
        if isinstance(body.get("motion"), dict):
            signals[f"bodies.{i}.motion.prescribed"] = body["motion"]["prescribed"]["signal"]
    for i, swimmer in enumerate(case.get("swimmers", [])):
        for j, arm in enumerate(swimmer.get("arms", [])):
            signals |= {f"swimmers.{i}.arms.{j}": arm["drive"]["signal"]} if "drive" in arm else {}
    amplitudes = {
        path: next(v for k, v in signal.items() if k.startswith("amplitude")) for path, signal in signals.items()
    }
    parts = [[path for path in amplitudes if rng.random() < 0.8]]
    if rng.random() < 0.4:
        parts.append([parts[0].pop() for _ in range(len(parts[0]) // 2)])
    parts = [part for part in parts if part]
    controllers = [
        {
            "name": f"controller{number}",
            "command": command,
            "every_steps": rng.choice([1, 3, 7, 20]),
            "sets": part,
            "parameters": {"amplitudes": [amplitudes[path] for path in part]},
        }
        for number, part in enumerate(parts)
    ]
    return {**case, "controllers": controllers} if controllers else None


def stop_step(case):
    """A step within the run after which there is a checkpoint."""
    return case["output"]["checkpoint"]["every_steps"]


class _Body:
    """A body that has found its place: points and radii of spheres that fill it."""

    def __init__(self, name, centre, radius, half_length, axis, moves):
        self.name, self.centre, self.radius = name, np.array(centre), radius
        self.half_length, self.axis, self.moves = half_length, np.array(axis), moves
        count = 1 + 2 * math.ceil(half_length / (0.5 * radius))
        self.points = [self.centre + s * self.axis for s in np.linspace(-half_length, half_length, count)]

    @property
    def volume(self):
        return math.pi * self.radius**2 * (4 / 3 * self.radius + 2 * self.half_length)

    @property
    def half_extents(self):
        return self.radius + self.half_length * np.abs(self.axis)


class _Draw:
    def __init__(self, rng, name):
        self.rng = rng
        self.tau = rng.choice([0.55, 0.6, 2 / 3, 0.8, 1.0, 1.0, 1.5, 2.0])
        self.step_s = (self.tau - 0.5) * CELL_M**2 / (3 * VISCOSITY_M2_PER_S)
        self.viscosity = (self.tau - 0.5) / 3
        self.placed, self.pairs_jointed = [], set()
        self.case = {"case": name}
        self.steps = rng.randint(40, 200)
        self._draw_fluid()
        self.case.update(
            {key: [] for key in ("bodies", "swimmers", "joints", "springs", "bends", "actuators", "groups")}
        )
        for _ in range(rng.choice([0, 1, 1, 2])):
            rng.choice([self._add_chain, self._add_chain, self._add_three_beads, self._add_swimmer])()
        for _ in range(rng.randint(0 if self.placed else 1, 4)):
            self._add_single_body()
        self._add_springs_and_bends()
        self._add_actuators()
        self._add_swarm()
        self._draw_rest()
        self.case = {key: value for key, value in self.case.items() if value != []}

    # Units

    def speed(self, lattice):
        return lattice * CELL_M / self.step_s

    def force(self, lattice):
        return lattice * MASS_KG * CELL_M / self.step_s**2

    def stiffness(self, lattice):
        return lattice * MASS_KG / self.step_s**2

    # Numbers and vectors

    def chance(self, probability):
        return self.rng.random() < probability

    def uniform(self, low, high):
        return self.rng.uniform(low, high)

    def log_uniform(self, low, high):
        return math.exp(self.rng.uniform(math.log(low), math.log(high)))

    def direction(self):
        """A unit vector; along an axis where there are mirrors, or there would be few cases with mirrors."""
        if self.planes or self.chance(0.15):
            vector = np.zeros(3)
            vector[self.rng.randrange(3)] = self.rng.choice([-1.0, 1.0])
            return vector
        vector = np.array([self.rng.gauss(0, 1) for _ in range(3)])
        return vector / np.linalg.norm(vector)

    def vector(self, largest, across_planes=False):
        """Any vector; with a plane only what its mirror leaves: of an axial vector the part across the plane."""
        vector = self.uniform(0, largest) * self.direction()
        for axis in range(3):
            for plane in self.planes:
                if (axis == plane) != across_planes:
                    vector[axis] = 0.0
        return vector

    def across(self, axis):
        """A unit vector normal to another."""
        vector = np.cross(axis, self.direction())
        length = np.linalg.norm(vector)
        return vector / length if length > 0.1 else self.across(axis)

    # The fluid

    def _draw_fluid(self):
        rng = self.rng
        self.planes = [axis for axis in range(3) if self.chance(0.1)]
        self.cells = [2 * rng.randint(12, 18) if axis in self.planes else rng.randint(24, 36) for axis in range(3)]
        self.faces = [self._faces(axis) for axis in range(3)]
        collision = rng.choice(["trt", "central_moments"] + ["bgk"] * (self.tau > 0.59))
        self.fluid = {
            "solver": "lattice_boltzmann",
            "density_kg_per_m3": DENSITY_KG_PER_M3,
            "kinematic_viscosity_m2_per_s": VISCOSITY_M2_PER_S,
            "cell_size_m": CELL_M,
            "relaxation_time": self.tau,
            "domain_cells": self.cells,
            "boundaries": dict(zip("xyz", self.faces)),
            "symmetry_planes": ["xyz"[axis] for axis in self.planes],
            "collision": collision,
            "moving_boundary": rng.choice(["bounce_back", "interpolated", "central_linear", "parabolic", "parabolic"]),
            "refill": rng.choice(["equilibrium", "nonequilibrium", "grad"]),
            "precision": rng.choice(["double", "double", "single"]),
        }
        if self.chance(0.25):
            force = self.force(1) / CELL_M**3 * self.vector(1e-5)
            self.fluid["body_force_N_per_m3"] = list(force)
        if self.chance(0.2):
            self.fluid["initial_flow"] = {"kind": "uniform", "velocity_m_per_s": list(self.speed(self.vector(0.02)))}
        self.case["fluid"] = self.fluid

    def _faces(self, axis):
        if axis in self.planes:
            return self.rng.choice(["no_slip", "free_slip"])
        if self.chance(0.45):
            return "periodic"
        if self.chance(0.2):
            return self._stream(axis)
        return {"low": self._face(axis), "high": self._face(axis)}

    def _stream(self, axis):
        velocity = self.vector(0.02)
        velocity[axis] = self.rng.choice([-1, 1]) * self.uniform(0.002, 0.02)
        velocity = self.speed(velocity)
        face = math.prod(self.cells) // self.cells[axis]
        table = {"factors": [self.uniform(0.5, 1.0) for _ in range(face)]}
        inflow = {"velocity_m_per_s": list(velocity), "profile": self.rng.choice(["uniform", "parabolic", table])}
        self._vary(inflow)
        outflow = self.rng.choice(["outflow", {"outflow": {"bodies": "remove"}}])
        return dict(zip(self.rng.choice([("low", "high"), ("high", "low")]), (inflow, outflow)))

    def _vary(self, face):
        """In half of the cases in time."""
        kind = self.rng.choice(["sinusoid", "square", "trapezoid", "ramp", None, None, None, None])
        if kind == "ramp":
            face["signal"] = {"kind": "constant", "ramp_steps": self.rng.randint(1, 300)}
        elif kind is not None:
            face["signal"] = {"kind": kind, "period_steps": self.rng.randint(20, 200), "lag_deg": self.uniform(0, 360)}
        return face

    def _face(self, axis):
        kind = self.rng.choice(["no_slip", "no_slip", "no_slip", "free_slip", "moving", "pressure"])
        if kind == "moving":
            velocity = self.speed(self.vector(0.03))
            velocity[axis] = 0.0
            return self._vary({"velocity_m_per_s": list(velocity)})
        if kind == "pressure":
            excess = self.uniform(-0.004, 0.004)  # of the density
            return {"pressure_Pa": excess / 3 * DENSITY_KG_PER_M3 * self.speed(1) ** 2}
        return kind

    def periodic(self, axis):
        return self.faces[axis] == "periodic"

    # Places

    def gap(self, body, other):
        """Distance of the surfaces, to the nearest image; too small by a little for capsules."""
        least = math.inf
        for p in body.points:
            for q in other.points:
                r = p - q
                for axis in range(3):
                    if self.periodic(axis):
                        r[axis] -= self.cells[axis] * round(r[axis] / self.cells[axis])
                least = min(least, np.linalg.norm(r))
        return least - body.radius - other.radius

    def fits(self, body, least_gap, neighbours=()):
        half = body.half_extents
        for axis in range(3):
            low = body.centre[axis] - half[axis]
            high = self.cells[axis] - body.centre[axis] - half[axis]
            if self.periodic(axis):
                if 2 * half[axis] > self.cells[axis] - 2:
                    return False
            elif axis in self.planes:
                on_plane = body.centre[axis] == self.cells[axis] / 2
                if low < 0.2 or not on_plane and high - self.cells[axis] / 2 < 0.2:
                    return False
            elif min(low, high) < 0.2:
                return False
        others = [other for other in self.placed if other not in neighbours]
        return all(self.gap(body, other) >= least_gap for other in others)

    def place(self):
        """Anywhere; on a plane in every second case."""
        return np.array(
            [
                (
                    self.cells[axis] * self.rng.choice([0.5, self.uniform(0, 0.5)])
                    if axis in self.planes
                    else self.uniform(0, self.cells[axis])
                )
                for axis in range(3)
            ]
        )

    # Bodies

    def _shape(self, name, centre, axis=None, moves=True):
        radius = self.uniform(1.8, 4.2)
        half_length = self.rng.choice([0.0, self.uniform(0.5, 4.0)])
        if half_length > 0:
            radius = min(radius, 3.0)
        return _Body(name, centre, radius, half_length, self.direction() if axis is None else axis, moves)

    def _entry(self, body, density=None):
        """The section of a body in the case, with the mass of as much fluid, by a factor."""
        density = density or self.rng.choice([0.1, 0.4, 0.8, 1.0, 1.0, 1.5, 2.5, 8.0])
        entry = {
            "name": body.name,
            "shape": "capsule" if body.half_length > 0 else "sphere",
            "radius_m": body.radius * CELL_M,
            "mass_kg": density * body.volume * MASS_KG,
            "position_m": list(body.centre * CELL_M),
        }
        if body.half_length > 0:
            entry["length_m"] = 2 * body.half_length * CELL_M
            entry["orientation_wxyz"] = _from_z(body.axis)
        self.placed.append(body)
        self.case["bodies"].append(entry)
        return entry

    def _add_single_body(self):
        name = f"body_{len(self.placed)}"
        least_gap = self.rng.choice([0.05, 0.3, 1.0])
        for _ in range(TRIES):
            body = self._shape(name, self.place())
            if self.placed and self.chance(0.5) and not self.planes:  # beside another one
                other = self.rng.choice(self.placed)
                towards = self.direction()
                gap = self.uniform(0.1, 1.5)
                body = self._shape(name, self.rng.choice(other.points) + (other.radius + gap) * towards)
                body = _Body(name, body.centre + body.radius * towards, body.radius, 0.0, body.axis, True)
            if self.fits(body, least_gap):
                break
        else:
            return
        entry = self._entry(body)
        motion = self.rng.choice(["free"] * 5 + ["axis", "axis", "fixed", "prescribed", "signal"])
        velocity = list(self.speed(self.vector(0.02)))
        spin = list(self.vector(0.01, across_planes=True) / self.step_s)
        body.moves = motion in ("free", "axis")
        if motion == "signal":
            signal = {**self._wave(), "amplitude": 1.0}
            prescribed = {"velocity_m_per_s": velocity, "angular_velocity_rad_per_s": spin, "signal": signal}
            entry["motion"] = {"prescribed": prescribed}
            body.moves = None  # nothing may act on it
            return
        entry["motion"] = motion
        if motion != "fixed" and self.chance(0.5):
            entry["velocity_m_per_s"], entry["angular_velocity_rad_per_s"] = velocity, spin
        if motion == "axis":
            entry["axis"] = list(self.direction())
            entry["velocity_m_per_s"] = list(self.speed(self.uniform(-0.02, 0.02)) * np.array(entry["axis"]))
            entry["angular_velocity_rad_per_s"] = [0.0, 0.0, 0.0]

    def replace_shapes(self):
        """Other shapes, within the same sphere or capsule; our own solver has no contacts of theirs."""
        self.case.pop("contact", None)
        for entry in self.case.get("bodies", []):
            body = next(body for body in self.placed if body.name == entry["name"])
            if self.chance(0.8):
                entry |= self._other_shape(body.radius, body.half_length)
                if entry["shape"] != "cylinder":
                    entry.pop("radius_m"), entry.pop("length_m", None)
                if self.chance(0.2):
                    unit = 0.4 * entry["mass_kg"] * (body.radius * CELL_M) ** 2
                    entry["inertia_kg_m2"] = [unit, 1.1 * unit, 0.9 * unit, 0.0, 0.1 * unit, 0.0]
                elif self.chance(0.7):
                    entry["density_kg_per_m3"] = entry.pop("mass_kg") / (body.volume * CELL_M**3)

    def add_obstacles(self):
        obstacles = []
        for number in range(self.rng.choice([0, 1, 2])):
            for _ in range(TRIES):
                body = self._shape(f"obstacle_{number}", self.place())
                if all(self.gap(body, other) > 1.0 for other in self.placed):
                    break
            else:
                continue
            shape = self._other_shape(body.radius, body.half_length)
            place = {"position_m": list(body.centre * CELL_M), "orientation_wxyz": _from_z(body.axis)}
            obstacles.append({"name": body.name, **shape, **place, "loads": number == 1})
        if obstacles:
            self.case["obstacles"] = obstacles

    def _other_shape(self, radius, half_length):
        r, h = radius * CELL_M, half_length * CELL_M
        narrow = self.uniform(0.7, 1.0)
        kind = self.rng.choice(["ellipsoid", "cylinder", "box", "mesh", "mesh", "compound"])
        if kind == "ellipsoid":
            return {"shape": kind, "semi_axes_m": [narrow * r, r, r + h]}
        if kind == "cylinder":
            return {"shape": kind, "radius_m": 0.8 * r, "length_m": 2 * (h + 0.6 * narrow * r)}
        if kind == "box":
            return {"shape": kind, "edges_m": [1.1 * narrow * r, 1.1 * r, 2 * h + 1.2 * r]}
        if kind == "mesh":  # eight faces, of which four may meet in a dent
            top = self.rng.choice([1.0, -0.2])
            corners = [(1, 0, 0), (0, narrow, 0), (-1, 0, 0), (0, -narrow, 0), (0, 0, top), (0, 0, -1)]
            lines = [f"v {x * r / CELL_M} {y * r / CELL_M} {z * (r + h) / CELL_M}" for x, y, z in corners]
            lines += [f"f {a} {b} 5\nf {b} {a} 6" for a, b in ((1, 2), (2, 3), (3, 4), (4, 1))]
            return {"shape": kind, "text": "\n".join(lines), "unit_m": CELL_M}
        ends = [{"radius_m": 0.6 * r, "position_m": [0, 0, side * (h + 0.4 * r)]} for side in (-1, 1)]
        return {"shape": kind, "parts": [*ends, {"shape": "box", "edges_m": [1.1 * narrow * r, 0.6 * r, 2 * h + r]}]}

    def _add_chain(self):
        """Two to four bodies on joints, most of which overlap."""
        axis_joint = self.direction()
        for _ in range(TRIES):
            bodies = self._chain_bodies(self.rng.randint(2, 4), axis_joint)
            if all(self.fits(body, 0.3) for body in bodies):
                break
        else:
            return
        order = list(range(len(bodies)))
        self.rng.shuffle(order)  # the first one has the cells in common
        density = self.rng.choice([None, 1.0, 1.5])
        velocity = list(self.speed(self.vector(0.03)))
        for index in order:
            self._entry(bodies[index], density)["velocity_m_per_s"] = velocity
        for front, back in zip(bodies[1:], bodies):
            self._add_joint(front, back, axis_joint)
        if len(bodies) > 2 and self.chance(0.2):
            self._joint("distance", bodies[0], bodies[-1])
        if self.chance(0.2):
            kind = self.rng.choice(["ball", "hinge"])
            joint = self._joint(kind, bodies[0], None, anchor=bodies[0].centre)
            if kind == "hinge":
                joint["axis"] = list(axis_joint)

    def _chain_bodies(self, count, axis_joint):
        number = len(self.placed)
        alike, straight = self.chance(0.6), self.planes or self.chance(0.4)  # surfaces that coincide beside the joint
        bodies = [self._shape(f"link_{number}", self.place(), self.across(axis_joint))]
        for index in range(1, count):
            before = bodies[-1]
            along = before.axis if straight else _turned(before.axis, axis_joint, self.uniform(-0.8, 0.8))
            body = before if alike else self._shape("", before.centre)
            overlap = self.rng.choice([0.0, self.uniform(0.2, 1.2) * (before.radius + body.radius)])
            if body.half_length == 0:
                overlap = self.uniform(0.1, 1.2) * (before.radius + body.radius)
            centre = before.centre + before.half_length * before.axis + (overlap + body.half_length) * along
            bodies.append(_Body(f"link_{number + index}", centre, body.radius, body.half_length, along, True))
        return bodies

    def _joint(self, kind, one, other, anchor=None):
        joint = {"name": f"joint_{len(self.case['joints'])}", "kind": kind}
        joint["bodies"] = [one.name, other.name if other else "world"]
        if anchor is not None:
            joint["anchor_m"] = list(np.array(anchor) * CELL_M)
        self.case["joints"].append(joint)
        if other:
            self.pairs_jointed.add(frozenset((one.name, other.name)))
        return joint

    def _add_joint(self, front, back, axis_joint):
        kind = self.rng.choice(["hinge", "hinge", "hinge", "ball", "slider", "fixed", "distance"])
        if kind == "distance" and np.linalg.norm(front.centre - back.centre) < 0.5:
            kind = "ball"
        end = back.centre + back.half_length * back.axis
        joint = self._joint(kind, front, back, None if kind == "distance" else end)
        if kind == "hinge":
            joint["axis"] = list(axis_joint)
        if kind == "slider":
            joint["axis"] = list(back.axis)
        if kind not in ("hinge", "slider", "distance"):
            return
        unit, largest, rate = ("rad", 0.5, 0.004) if kind == "hinge" else ("m", 1.0 * CELL_M, 0.01 * CELL_M)
        way = self.rng.choice(["free", "signal", "signal", "spring", "limits"])
        if way == "signal":
            wave = self._wave(jumps=False)
            reach = min(largest, rate * wave.get("period_steps", 5))
            joint["signal"] = {**wave, f"amplitude_{unit}": self.uniform(0.3, 1.0) * reach}
        elif kind != "distance" and way == "limits":
            joint[f"limits_{unit}"] = [-self.uniform(0.05, 1.0) * largest, self.uniform(0.05, 1.0) * largest]
        elif kind != "distance" and way == "spring":
            mass = min(front.volume, back.volume)
            stiffness = mass * self.log_uniform(0.01, 0.1) ** 2
            if kind == "hinge":
                of_lattice = MASS_KG * CELL_M**2 / self.step_s**2
                joint["stiffness_N_m_per_rad"] = stiffness * of_lattice
                joint["damping_N_m_s_per_rad"] = 0.5 * stiffness * of_lattice * self.step_s
            else:
                joint["stiffness_N_per_m"] = self.stiffness(stiffness)
                joint["damping_N_s_per_m"] = 0.5 * self.stiffness(stiffness) * self.step_s

    # Swimmers

    def _beads_fit(self, name, beads):
        """`beads`: name, centre and radius."""
        bodies = [_Body(f"{name}.{bead}", centre, radius, 0.0, (0, 0, 1), True) for bead, centre, radius in beads]
        if not all(self.fits(body, 0.5) for body in bodies):
            return False
        self.placed += bodies
        return True

    def _spring(self, mass):
        stiffness = mass * self.log_uniform(0.02, 0.2) ** 2
        return {
            "stiffness_N_per_m": self.stiffness(stiffness),
            "damping_N_s_per_m": self.uniform(0, 2) * self.stiffness(stiffness) * self.step_s,
        }

    def _add_three_beads(self):
        name = f"swimmer_{len(self.case['swimmers'])}"
        radius, gaps = self.uniform(1.8, 2.5), [self.uniform(2, 4), self.uniform(2, 4)]
        for _ in range(TRIES):
            centre, axis = self.place(), self.direction()
            reach = [-2 * radius - gaps[0], 0.0, 2 * radius + gaps[1]]
            beads = [(bead, centre + s * axis, radius) for bead, s in zip(("B2", "B1", "B3"), reach)]
            if self._beads_fit(name, beads):
                break
        else:
            return
        mass = self.uniform(0.8, 3) * 4.19 * radius**3
        period = self.rng.randint(20, 100)
        self.case["swimmers"].append(
            {
                "name": name,
                "center_m": list(centre * CELL_M),
                "axis": list(axis),
                "beads": [{"radius_m": radius * CELL_M}] * 3,
                "bead_mass_kg": mass * MASS_KG,
                "rest_gap_m": [gap * CELL_M for gap in gaps],
                "spring": self._spring(mass),
                "stroke": {
                    "amplitude_N": self.force(self.uniform(0, 0.1)),
                    "period_steps": period,
                    "phase_lag_steps": self.rng.randrange(period),
                    "cycles": self.rng.randint(1, 4),
                },
            }
        )

    def _add_swimmer(self):
        name = f"swimmer_{len(self.case['swimmers'])}"
        swimmer, radius = self._template(name)
        for _ in range(TRIES):
            centre = self.place()
            beads = [
                (bead["name"], centre + np.array(bead["position_m"]) / CELL_M, radius) for bead in swimmer["beads"]
            ]
            if self._beads_fit(name, beads):
                self.case["swimmers"].append({**swimmer, "center_m": list(centre * CELL_M)})
                return

    def _template(self, name):
        """Three beads at the corners of a triangle, or bent, on two or three arms."""
        radius, side = self.uniform(1.8, 2.4), self.uniform(6.5, 9)
        places = [(0.0, 0.0, 0.0), (side, 0.0, 0.0), (0.4 * side, 0.9 * side, 0.0)]
        pairs = [("A", "B"), ("B", "C"), ("C", "A")][: self.rng.randint(2, 3)]
        arms = []
        for pair in pairs:
            arm = {"beads": list(pair), "spring": self._spring(4.19 * radius**3)}
            if self.chance(0.7):
                if self.chance(0.5):
                    signal = {**self._wave(), "amplitude_N": self.force(self.uniform(0, 0.08))}
                    arm["drive"] = {"kind": "pair_force", "signal": signal}
                else:
                    signal = {**self._wave(jumps=False), "amplitude_m": self.uniform(0, 1) * CELL_M}
                    arm["drive"] = {"kind": "rest_length", "signal": signal}
            arms.append(arm)
        density = self.rng.choice([0.5, 1.0, 2.0])
        swimmer = {
            "name": name,
            "beads": [
                {
                    "name": bead,
                    "radius_m": radius * CELL_M,
                    "density_kg_per_m3": density * DENSITY_KG_PER_M3,
                    "position_m": [x * CELL_M for x in place],
                }
                for bead, place in zip("ABC", places)
            ],
            "arms": arms,
            "phase_deg": self.uniform(0, 90),
        }
        if self.chance(0.4):
            stiffness = 4.19 * radius**3 * side**2 * self.log_uniform(0.01, 0.03) ** 2
            swimmer["bends"] = [
                {
                    "beads": ["A", "B", "C"],
                    "stiffness_N_m_per_rad": stiffness * MASS_KG * CELL_M**2 / self.step_s**2,
                    "rest_angle_deg": self.uniform(40, 90),
                }
            ]
        return swimmer, radius

    def _add_swarm(self):
        if self.chance(0.06) and not self.planes:
            template, _ = self._template("copy")
            self.case["swarm"] = {
                "template": template,
                "count": self.rng.randint(1, 3),
                "seed": self.rng.randint(1, 99),
            }

    # What acts on bodies

    def _wave(self, jumps=True):
        kinds = ["constant", "sinusoid", "sinusoid", "trapezoid", "table"] + (["square"] if jumps else [])
        wave = {"kind": self.rng.choice(kinds)}
        if wave["kind"] == "table":
            times = sorted({0, *(self.rng.randint(1, self.steps) for _ in range(4))})
            wave["times_steps"] = times
            wave["values"] = [0.0] + [self.uniform(-1, 1) for _ in times[1:]]
        elif wave["kind"] != "constant":
            wave["period_steps"] = self.rng.randint(20, 120)
            wave["lag_deg"] = self.uniform(0, 360)
        if self.chance(0.2):
            wave["ramp_steps"] = self.rng.randint(1, 40)
        if self.chance(0.2) and jumps:
            wave["start_step"] = self.rng.randint(0, 40)
            wave["stop_step"] = self.rng.randint(41, 200)
        return wave

    def _may_act_on(self, *bodies):
        """Bodies that the coupler moves take no force, fixed ones feel none."""
        return all(body.moves is not None for body in bodies) and any(body.moves for body in bodies)

    def _add_springs_and_bends(self):
        if len(self.placed) < 2:
            return
        for _ in range(self.rng.choice([0, 0, 1, 2])):
            one, other = self.rng.sample(self.placed, 2)
            if not self._may_act_on(one, other):
                continue
            length = np.linalg.norm(one.centre - other.centre)
            if length < 1:
                continue
            spring = {"bodies": [one.name, other.name], **self._spring(min(one.volume, other.volume))}
            spring["rest_length_m"] = self.uniform(0.9, 1.1) * length * CELL_M
            if self.chance(0.3) and not self.planes:
                spring["anchors_m"] = [list(body.radius * self.direction() * CELL_M) for body in (one, other)]
                del spring["rest_length_m"]
                spring["rest_length_m"] = length * CELL_M
            self.case["springs"].append(spring)
        if len(self.placed) > 2 and self.chance(0.2) and not self.planes:
            three = self.rng.sample(self.placed, 3)
            if all(body.moves for body in three):
                arm = min(np.linalg.norm(three[1].centre - body.centre) for body in (three[0], three[2]))
                stiffness = min(body.volume for body in three) * arm**2 * self.log_uniform(0.005, 0.03) ** 2
                self.case["bends"].append(
                    {
                        "bodies": [body.name for body in three],
                        "stiffness_N_m_per_rad": stiffness * MASS_KG * CELL_M**2 / self.step_s**2,
                        "rest_angle_deg": self.uniform(60, 150),
                    }
                )

    def _add_actuators(self):
        for _ in range(self.rng.choice([0, 1, 2, 3])):
            kind = self.rng.choice(
                ["pair_force", "rest_length", "body_force", "body_torque", "world_force", "world_torque"]
            )
            if kind == "rest_length":
                if not self.case["springs"]:
                    continue
                spring = self.rng.choice(self.case["springs"])
                amplitude = {"amplitude_m": self.uniform(0, 1.0) * CELL_M}
                actuator = {
                    "kind": kind,
                    "bodies": spring["bodies"],
                    "signal": {**self._wave(jumps=False), **amplitude},
                }
                self.case["actuators"].append(actuator)
                continue
            bodies = self.rng.sample(self.placed, min(len(self.placed), 2 if kind == "pair_force" else 1))
            if not self._may_act_on(*bodies) or kind == "pair_force" and len(bodies) < 2:
                continue
            drag = 6 * math.pi * self.viscosity * bodies[0].radius
            if "torque" in kind:
                torque = self.uniform(0, 0.02) * drag * bodies[0].radius ** 2 * MASS_KG * CELL_M**2 / self.step_s**2
                signal = {**self._wave(), "amplitude_N_m": torque}
            else:
                signal = {**self._wave(), "amplitude_N": self.force(self.uniform(0, 0.02) * drag)}
            actuator = {"kind": kind, "signal": signal}
            if kind == "pair_force":
                actuator["bodies"] = [body.name for body in bodies]
            else:
                actuator["body"] = bodies[0].name
                direction = self.vector(1.0, across_planes="torque" in kind)
                if not direction.any():
                    continue
                actuator["direction"] = list(direction)
            self.case["actuators"].append(actuator)

    def _draw_rest(self):
        rng = self.rng
        if self.chance(0.4):
            acceleration = CELL_M / self.step_s**2
            self.case["gravity_m_per_s2"] = list(acceleration * self.vector(self.log_uniform(1e-5, 1e-3)))
        cut_off = rng.choice(["auto", "auto", "auto", "none", self.uniform(0.5, 2.0)])
        self.case["lubrication"] = {"cut_off_cells": cut_off, "roughness_m": self.log_uniform(1e-10, 1e-7)}
        if self.chance(0.5):
            self.case["contact"] = {
                "restitution": self.uniform(0.2, 1.0),
                "friction": rng.choice([0.0, self.uniform(0, 0.5)]),
            }
        self.case["coupling"] = {
            "load_averaging": rng.choice(["two_step", "two_step", "none"]),
            "virtual_mass": rng.choice(["auto", "auto", "auto", "none", self.uniform(0, 1.5)]),
        }
        if self.chance(0.2):
            self.case["body"] = {"integrator": "semi_implicit_euler"}
        if self.placed and self.chance(0.2):
            bodies = rng.sample([body.name for body in self.placed], rng.randint(1, len(self.placed)))
            self.case["groups"].append({"name": "group", "bodies": bodies, "period_steps": rng.randint(20, 60)})
        self.case["run"] = {"steps": self.steps}
        self.case["output"] = {
            "trajectory": {"every_steps": rng.randint(1, 20), "format": rng.choice(["csv", "csv", "npy"])},
            "bodies": {"every_steps": 0},
            "checkpoint": {"every_steps": rng.randint(1, self.steps - 1), "every_wall_s": 0},
            "flow": {
                "every_steps": rng.randint(1, 20),
                "totals": self.chance(0.7),
                "probes": [],
                "faces": self.chance(0.6),
            },
        }
        for number in range(rng.randint(1, 3)):
            place = [rng.random() * CELL_M * cells for cells in self.case["fluid"]["domain_cells"]]
            self.case["output"]["flow"]["probes"].append({"name": f"probe{number}", "position_m": place})
        of_stream = {"speed_m_per_s": self.speed(0.05), "area_m2": 10 * CELL_M**2, "length_m": 3 * CELL_M}
        of_stream |= {"drag_axis": [1, 0, 0], "lift_axis": [0, 1, 0]}  # inflows may be oblique
        if self.placed:
            self.case["output"]["coefficients"] = [{"of": self.placed[0].name, **of_stream}]


def _from_z(direction):
    """The quaternion that turns e_z into a direction."""
    x, y, z = (float(component) for component in direction)
    if z < -1 + 1e-12:
        return [0.0, 1.0, 0.0, 0.0]
    q = np.array([1.0 + z, -y, x, 0.0])
    return [float(component) for component in q / np.linalg.norm(q)]


def _turned(vector, axis, angle):
    """Rodrigues' rotation."""
    return (
        vector * math.cos(angle)
        + np.cross(axis, vector) * math.sin(angle)
        + axis * np.dot(axis, vector) * (1 - math.cos(angle))
    )
