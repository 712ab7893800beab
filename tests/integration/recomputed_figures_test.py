"""Every figure of summary.json and cycles.csv, computed once more from the trajectory and the case.

Written from docs/theory.md, (C7) to (C15), and docs/conventions.md, with other means than the program where there are
any: rotations by NumPy, arms by least squares. No bodies are so close that films act: their loads are not averaged, and
loads before averaging follow from a trajectory without them only. An unknown key fails.
"""

import csv
import json
import unittest
from collections import defaultdict

import numpy as np

from copepod_session import WholeRunTest
from copepod_report.page import comparison_rows
from copepod_report.run_record import collect
from copepod_run.plan import plan_of

RELATIVE = 1e-9

# What no trajectory contains: about the run, its cost, its fluid.
OF_THE_RUN = {
    *("case", "parameter_set", "status", "steps", "resumed_from_step", "step_s", "cell_size_m", "wall_s", "mlups"),
    *("ranks", "precision", "digest", "mass_drift", "momentum_drift", "timing", "phases_s"),
}

HONEY = "density_kg_per_m3: 1360, kinematic_viscosity_m2_per_s: 7.36e-5, cell_size_m: 1.0e-6"
STOKES = "fluid: {solver: stokes, %s%s}\nstep_s: 7.5e-10\n"
LATTICE = "fluid: {solver: lattice_boltzmann, %s, relaxation_time: 0.8, domain_cells: %s, boundaries: %s%s}\n"
BEADS = "&bead {radius_m: 2.0e-6}, *bead, *bead"
ROW = """
  - name: %s
    center_m: %s
    axis: %s
    beads: [%s]
    bead_mass_kg: 6.8e-14
    rest_gap_m: [4.0e-6, 4.5e-6]
    spring: {stiffness_N_per_m: 16.3, damping_N_s_per_m: 1.57e-7}
    stroke: {amplitude_N: %s, period_steps: %s, phase_lag_steps: %s, cycles: 3}
"""
SPHERE = "radius_m: 4.0e-6, mass_kg: 5.44e-13"
PERIODIC = "{x: periodic, y: periodic, z: periodic}"
WALLS = "{x: no_slip, y: no_slip, z: periodic}"

CASES = {
    "swimmer between walls": LATTICE % (HONEY, "[16, 16, 32]", WALLS, ", body_force_N_per_m3: [0, 0, -1.0e8]")
    + "swimmers:"
    + ROW % ("s", "[7.0e-6, 8.0e-6, 16.0e-6]", "[0.1, 0, 1]", BEADS, "4.0e-5", 100, 25)
    + "    published: {u_swim_lattice: 1.0e-6, K: 0.01, Re_bodies: {B2: 0.1}}\nrun: {steps: 360}",
    "backwards": STOKES % (HONEY, "")
    + "swimmers:"
    + ROW
    % ("s", "[0, 0, 0]", "[1, 2, 3]", "{radius_m: 2.0e-6}, {radius_m: 3.0e-6}, {radius_m: 2.5e-6}", "4.0e-5", 101, 76)
    + "run: {steps: 303}",
    "two periods and capsules": STOKES % (HONEY, "")
    + "swimmers:"
    + ROW % ("a", "[0, 0, 0]", "[0, 0, 1]", BEADS, "4.0e-5", 100, 25)
    + ROW
    % (
        *("b", "[2.0e-5, 0, 3.0e-6]", "[0.2, 0, 1]"),
        "*bead, {radius_m: 2.0e-6}, *bead",
        *("3.0e-5", 150, 40),
    )
    + "run: {steps: 470}",
    "pair in a periodic box": LATTICE % (HONEY, "[24, 16, 40]", PERIODIC, "")
    + "swimmers:"
    + ROW % ("a", "[4.0e-6, 8.0e-6, 20.0e-6]", "[0, 0, 1]", BEADS, "4.0e-5", 60, 15)
    + ROW % ("b", "[20.0e-6, 8.0e-6, 20.0e-6]", "[0, 0, -1]", "*bead, *bead, *bead", "4.0e-5", 60, 15)
    + "run: {steps: 180}",
    "group on rods": STOKES % (HONEY, "")
    + f"""
bodies:
  - {{name: rear, {SPHERE}, position_m: [0, 0, -40.0e-6]}}
  - {{name: middle, {SPHERE}, position_m: [1.0e-6, 0, 0]}}
  - {{name: front, {SPHERE}, position_m: [0, 0, 36.0e-6]}}
groups: [{{name: all, bodies: [rear, middle, front], axis: [0, 0, 1], period_steps: 200}}]
joints:
  - {{name: r, kind: distance, bodies: [rear, middle],
     signal: {{kind: sinusoid, amplitude_m: 8.0e-6, period_steps: 200}}}}
  - {{name: f, kind: distance, bodies: [middle, front],
     signal: {{kind: sinusoid, amplitude_m: 8.0e-6, period_steps: 200, lag_deg: 90}}}}
run: {{steps: 1400}}
""",
    "vacuum": "fluid: {solver: vacuum, cell_size_m: 1.0e-6}\nstep_s: 7.5e-10\nswimmers:"
    + ROW % ("s", "[0, 0, 0]", "[0, 1, 1]", BEADS, "2.0e-5", 400, 100)
    + "run: {steps: 1300}",
    "turning bodies that are driven": LATTICE % (HONEY, "[48, 48, 32]", WALLS, "")
    + f"""
bodies:
  - {{name: a, {SPHERE}, position_m: [12.0e-6, 20.0e-6, 16.0e-6], velocity_m_per_s: [1, 0, 0]}}
  - {{name: b, {SPHERE}, shape: capsule, length_m: 6.0e-6, axis: [1, 0, 1], position_m: [32.0e-6, 20.0e-6, 16.0e-6],
     angular_velocity_rad_per_s: [0, 1.0e5, 0]}}
  - {{name: wall, radius_m: 4.0e-6, mass_kg: 1, motion: fixed, position_m: [24.0e-6, 36.0e-6, 16.0e-6]}}
groups: [{{name: pair, bodies: [a, b], axis: [1, 0, 0]}}]
springs: [{{bodies: [a, b], stiffness_N_per_m: 16.3, damping_N_s_per_m: 1.0e-7, rest_length_m: 20.0e-6}}]
actuators:
  - {{kind: body_torque, body: b, direction: [0, 1, 0],
     signal: {{kind: sinusoid, amplitude_N_m: 1.0e-11, period_steps: 120}}}}
run: {{steps: 250}}
""",
}


def rotation_matrix(quaternion):
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def turn(vector):
    """Rodrigues."""
    angle = np.linalg.norm(vector)
    if angle == 0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def rotation_vector(R):
    axial = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
    sine, cosine = np.linalg.norm(axial), (np.trace(R) - 1) / 2
    return np.zeros(3) if sine == 0 else axial / sine * np.arctan2(sine, cosine)


def rigid_rotation(before, after):
    """(C13) of points in rows."""
    p, q = before - before.mean(0), after - after.mean(0)
    if len(p) < 2:
        return np.eye(3)
    spreads = [np.linalg.svd(points) for points in (p, q)]
    if any(s[1] <= 1e-3 * s[0] for _, s, _ in spreads):
        # The direction of the row, and where the fit takes it.
        u, _, v = np.linalg.svd(p.T @ q)
        first, second = u[:, 0], v[0]
        normal = np.cross(first, second)
        sine = np.linalg.norm(normal)
        return turn(np.zeros(3) if sine == 0 else normal / sine * np.arctan2(sine, first @ second))
    u, _, v = np.linalg.svd(p.T @ q)
    return v.T @ np.diag([1, 1, np.sign(np.linalg.det(v.T @ u.T))]) @ u.T


class Body:
    """A body of the case and its motion in every step."""

    def __init__(self, name, section, mass_kg, moves, rows):
        self.name, self.mass_kg, self.moves = name, mass_kg, moves
        self.radius_m, self.core_m = section["radius_m"], 0.0
        if section.get("shape") == "capsule":
            self.core_m = section["length_m"]
        self.equivalent_radius_m = self.radius_m + self.core_m / 4
        values = np.array([[float(row[key]) for key in list(row)[3:]] for row in rows])
        self.x, self.q, self.v, self.w, self.F, self.T, self.drive = np.split(values, (3, 7, 10, 13, 16, 19), axis=1)
        self.drive_torque = np.zeros_like(self.drive)

    def core(self, step=0):
        """Half of the capsule's core as a vector."""
        return rotation_matrix(self.q[step])[:, 2] * self.core_m / 2

    def extent_m(self, direction):
        return 2 * (self.radius_m + abs(self.core() @ direction))

    def inertia_kg_m2(self, step):
        """Of a uniform capsule: a cylinder between two half spheres."""
        r, length = self.radius_m, self.core_m
        ball, rod = 4 / 3 * r**3, r**2 * length
        ball, rod = self.mass_kg * np.array([ball, rod]) / (ball + rod)
        along = 0.4 * ball * r**2 + 0.5 * rod * r**2
        across = rod * (length**2 / 12 + r**2 / 4)
        # Of half spheres: about their own centroid, 3r/8 from the flat face, and from there to the middle.
        across += ball * (0.4 - 9 / 64) * r**2 + ball * (length / 2 + 3 * r / 8) ** 2
        R = rotation_matrix(self.q[step])
        return R @ np.diag([across, across, along]) @ R.T


class Measured:
    """A swimmer or group, over its cycles."""

    def __init__(self, case, name, bodies, axis, arms, period, cycles, steps):
        self.name, self.bodies, self.axis, self.arms, self.period = name, bodies, np.array(axis), arms, period
        self.turned, self.cycles = [np.eye(3)], []
        fluid, step_s = case["fluid"], case["step_s"]
        placed = np.array([body.x for body in bodies])
        self.length_m = max(body.extent_m(self.axis) for body in bodies)
        for i, one in enumerate(bodies):
            for other in bodies[:i]:
                line = one.x[0] - other.x[0]
                distance = np.linalg.norm(line)
                extents = one.extent_m(line / distance) + other.extent_m(line / distance)
                self.length_m = max(self.length_m, distance + extents / 2)
        for number in range(min(cycles, steps // period)):
            start, stop = number * period, (number + 1) * period
            before, after = placed[:, start], placed[:, stop]
            R = rigid_rotation(before, after)
            e = self.turned[number] @ self.axis
            u = (after - before).mean(0) / (period * step_s)
            phase = 2 * np.pi * np.arange(period) / period
            design = np.stack([np.ones(period), np.cos(phase), np.sin(phase)], axis=1)
            fits = []
            for A, B in arms:
                lengths = np.linalg.norm(B.x[start:stop] - A.x[start:stop], axis=1)
                mean, a, b = np.linalg.lstsq(design, lengths, rcond=None)[0]
                fits.append((mean, np.hypot(a, b), np.arctan2(-b, a)))
            steps_of = slice(start, stop)
            power = sum(
                np.sum(b.drive[steps_of] * b.v[steps_of] + b.drive_torque[steps_of] * b.w[steps_of]) for b in bodies
            )
            dissipation = -sum(np.sum(b.F[steps_of] * b.v[steps_of] + b.T[steps_of] * b.w[steps_of]) for b in bodies)
            cycle = {
                "number": number,
                "e": e,
                "u": u,
                "across": u - u @ e * e,
                "tilt": np.arctan2(np.linalg.norm(np.cross(self.axis, e)), self.axis @ e),
                "rotation": rotation_vector(R),
                "centroid": before.mean(0),
                "arms": fits,
                "power": power / period,
                "dissipation": dissipation / period,
                "efficiency": None,
                "Re": None,
                "speeds": {b.name: np.linalg.norm(b.v[steps_of], axis=1).max() for b in bodies},
            }
            if fluid["solver"] != "vacuum":
                cycle["Re"] = np.linalg.norm(u) * self.length_m / fluid["kinematic_viscosity_m2_per_s"]
                cycle["efficiency"] = self.efficiency(fluid, np.linalg.norm(u), cycle["power"])
            self.cycles.append(cycle)
            self.turned.append(R @ self.turned[number])

    def efficiency(self, fluid, speed, power):
        """(C11), (C15)."""
        if fluid["solver"] == "vacuum" or power == 0:
            return None
        viscosity = fluid["density_kg_per_m3"] * fluid["kinematic_viscosity_m2_per_s"]
        return 6 * np.pi * viscosity * sum(body.equivalent_radius_m for body in self.bodies) * speed**2 / power

    def is_row(self):
        """Whether the bodies lie on one line at the start."""
        first = np.array([body.x[0] for body in self.bodies])
        return np.linalg.matrix_rank(first - first.mean(axis=0), tol=1e-6 * self.length_m) == 1

    def along_the_axis(self, cycle):
        """Fits of the arms, the trailing one first."""
        middles = [(A.x[0] + B.x[0]) @ self.axis for A, B in self.arms]
        return [cycle["arms"][arm] for arm in np.argsort(middles)]

    def geometrical_factor(self, cycle):
        """K of (C9)."""
        r1, r2, r3 = (body.equivalent_radius_m for body in self.bodies)
        l1, l2 = (fit[0] for fit in cycle["arms"])
        return 1.5 * r1 * r2 * r3 / (r1 + r2 + r3) ** 2 * (1 / l1**2 + 1 / l2**2 - 1 / (l1 + l2) ** 2)

    def row(self, number, step_s, most_arms):
        """Of cycles.csv."""
        cycle = self.cycles[number]
        row = {"swimmer": self.name, "cycle": number, "start_step": number * self.period}
        row |= {"start_s": number * self.period * step_s, "tilt_rad": cycle["tilt"]}
        for key, vector in (
            ("%s_m", "centroid"),
            ("axis_%s", "e"),
            ("u%s_m_per_s", "u"),
            ("rotation_%s_rad", "rotation"),
        ):
            row |= {key % axis: cycle[vector][i] for i, axis in enumerate("xyz")}
        row |= {"u_along_m_per_s": cycle["u"] @ cycle["e"], "u_across_m_per_s": np.linalg.norm(cycle["across"])}
        row |= {"power_W": cycle["power"], "dissipation_W": cycle["dissipation"]}
        row |= {"efficiency": cycle["efficiency"], "Re": cycle["Re"]}
        for arm in range(most_arms):
            fit = cycle["arms"][arm] if arm < len(cycle["arms"]) else (None, None, None)
            row |= {f"arm{arm}_{key}": value for key, value in zip(("mean_m", "amplitude_m", "phase_rad"), fit)}
        return row

    def kinematics(self, case, cell_m):
        cycle, T, step_s = self.cycles[-1], self.period, case["step_s"]
        report = {"cycle": cycle["number"], "window_steps": [cycle["number"] * T, (cycle["number"] + 1) * T]}
        report |= {"period_steps": T, "velocity_m_per_s": cycle["u"], "velocity_across_m_per_s": cycle["across"]}
        speeds = {"u_along": cycle["u"] @ cycle["e"], "u_across": np.linalg.norm(cycle["across"])}
        if len(self.bodies) == 3 and len(self.arms) == 2 and self.is_row():
            K, (_, d1, phi1), (_, d2, phi2) = self.geometrical_factor(cycle), *self.along_the_axis(cycle)
            speeds["u_GA"] = K * d1 * d2 * 2 * np.pi / (T * step_s) * np.sin(phi1 - phi2)
        if len(self.cycles) > 3:
            latest = [each["u"] @ each["e"] for each in self.cycles[1:]][-5:]
            speeds |= {"u_along_mean": np.mean(latest), "u_along_spread": np.std(latest, ddof=1)}
        for key, speed in speeds.items():
            report |= {f"{key}_m_per_s": speed, f"{key}_um_per_s": 1e6 * speed}
            report |= {f"{key}_cells_per_step": speed * step_s / cell_m}
            report |= {f"{key}_lengths_per_cycle": speed * T * step_s / self.length_m}
        report |= {"axis": cycle["e"], "tilt_rad": cycle["tilt"], "rotation_rad": cycle["rotation"]}
        report["arms"] = [
            {"bodies": [A.name, B.name], "mean_m": mean, "amplitude_m": d, "phase_rad": phase}
            for (A, B), (mean, d, phase) in zip(self.arms, cycle["arms"])
        ]
        report |= {"power_W": cycle["power"], "dissipation_W": cycle["dissipation"]}
        report |= {"efficiency": cycle["efficiency"], "length_m": self.length_m, "Re": cycle["Re"]}
        report["max_speed_m_per_s"] = cycle["speeds"]
        moved, turned = np.linalg.norm(cycle["u"]) * T * step_s, np.linalg.norm(cycle["rotation"])
        report["at_rest"] = moved <= 1e-9 * self.length_m and turned <= 1e-9
        report["change_from_last_cycle"] = {"velocity": None, "rotation": None}
        if len(self.cycles) > 1:
            frames, last = self.turned[-3:-1], self.cycles[-2]
            for key, of, rests in (
                ("velocity", "u", moved <= 1e-9 * self.length_m),
                ("rotation", "rotation", turned <= 1e-9),
            ):
                difference = frames[1].T @ cycle[of] - frames[0].T @ last[of]
                change = None if rests else np.linalg.norm(difference) / np.linalg.norm(cycle[of])
                report["change_from_last_cycle"][key] = change
        return report

    def figures_of_paper(self, case, swimmer, cell_m):
        """(C7) to (C12)."""
        stroke, fluid, step_s, T = swimmer["stroke"], case["fluid"], case["step_s"], self.period
        last = stroke["cycles"] - 1
        cycle, window = self.cycles[last], slice(last * T, (last + 1) * T)
        e = cycle["e"]
        B2, B1, B3 = self.bodies
        u = (B1.x[window.stop] - B1.x[window.start]) @ e / (T * step_s)
        (l1, d1, phi1), (l2, d2, phi2) = cycle["arms"]
        K = self.geometrical_factor(cycle)
        speeds = [np.abs(body.v[window] @ e).max() for body in self.bodies]
        extents = [
            2 * b["radius_m"] + (b["length_m"] if b["orientation"] == "parallel" else 0) for b in swimmer["beads"]
        ]
        viscosity = fluid.get("kinematic_viscosity_m2_per_s")

        def reynolds(speed, length):
            return None if fluid["solver"] == "vacuum" else abs(speed) * length / viscosity

        def at(omega, power):
            u_GA = K * d1 * d2 * omega * np.sin(phi1 - phi2)
            return {
                "omega_lattice": omega * step_s,
                "u_GA_lattice": u_GA * step_s / cell_m,
                "u_GA_m_per_s": u_GA,
                "error_percent": 100 * abs((u_GA - u) / u_GA),
                "efficiency": self.efficiency(fluid, u, power),
            }

        names = ("B2", "B1", "B3")
        report = {
            "analysed": True,
            "window_steps": [window.start, window.stop],
            "u_swim_lattice": u * step_s / cell_m,
            "u_swim_m_per_s": u,
            "d1_cells": d1 / cell_m,
            "d2_cells": d2 / cell_m,
            "sin_dphi": np.sin(phi1 - phi2),
            "mean_arm_cells": [l1 / cell_m, l2 / cell_m],
            "K": K * cell_m,
            **at(2 * np.pi / (T * step_s), cycle["power"]),
            "Re_swim": reynolds(u, sum(extents) + sum(swimmer["rest_gap_m"])),
            "Re_bodies": {name: reynolds(*pair) for name, pair in zip(names, zip(speeds, extents))},
            "mean_power_W": cycle["power"],
            "max_speed_m_per_s": dict(zip(names, speeds)),
        }
        if published := swimmer.get("published"):
            # The rounded ω, and B1 and B2 exchanged, as in the table of parameters.
            omega = float(f"{2 * np.pi / T:.1e}")
            t = np.arange(window.start, window.stop)
            s1, s2 = (stroke["amplitude_N"] * np.sin(omega * (t - lag)) for lag in (0, stroke["phase_lag_steps"]))
            forces = zip(self.bodies, (-s1, s1 - s2, s2))
            power = sum(np.mean(force * (body.v[window] @ e)) for body, force in forces)
            exchanged = [speeds[1], speeds[0], speeds[2]]
            report["published"] = published
            report["as_in_paper"] = at(omega / step_s, power) | {"mean_power_W": power}
            report["as_in_paper"]["Re_bodies"] = {
                name: reynolds(*pair) for name, pair in zip(names, zip(exchanged, extents))
            }
        return report


def balance(case, bodies):
    """Momentum and energy of docs/conventions.md."""
    dt, moved = case["step_s"], [body for body in bodies if body.moves]
    momentum, energy = defaultdict(lambda: np.zeros(3)), defaultdict(float)
    for body in moved:
        for key, step in (("bodies_at_start", 0), ("bodies_at_end", -1)):
            momentum[key] += body.mass_kg * body.v[step]
            energy[key] += body.mass_kg * body.v[step] @ body.v[step] / 2
            energy[key] += body.w[step] @ body.inertia_kg_m2(step) @ body.w[step] / 2
        F, T, v, w = body.F[:-1], body.T[:-1], body.v[:-1], body.w[:-1]
        if case["coupling"]["load_averaging"] == "two_step":
            F, T = (loads_before_averaging(loads) for loads in (F, T))
        momentum["from_fluid"] += dt * F.sum(0)
        momentum["from_drive"] += dt * body.drive[:-1].sum(0)
        energy["from_fluid"] += dt * np.sum(F * v + T * w)
        energy["from_drive"] += dt * np.sum(body.drive[:-1] * v + body.drive_torque[:-1] * w)
    return {"momentum_N_s": momentum, "energy_J": energy}


def loads_before_averaging(averaged):
    """(C3) backwards."""
    loads = np.zeros_like(averaged)
    for step, load in enumerate(averaged):
        loads[step] = 2 * load - (loads[step - 1] if step else 0)
    return loads


def swarm(case, measured):
    if len(measured) < 2:
        return None
    along = np.array([one.cycles[-1]["u"] @ one.cycles[-1]["e"] for one in measured])
    centroids = np.array([np.mean([body.x[-1] for body in one.bodies], axis=0) for one in measured])
    apart = centroids[:, None] - centroids
    for axis, name in enumerate("xyz"):
        if (case["fluid"].get("boundaries") or {}).get(name, {}).get("low") == "periodic":
            length = case["fluid"]["domain_cells"][axis] * case["fluid"]["cell_size_m"]
            apart[..., axis] -= length * np.round(apart[..., axis] / length)
    distances = np.linalg.norm(apart, axis=2) + np.diag([np.inf] * len(measured))
    return {
        "swimmers": len(measured),
        "u_along_mean_m_per_s": along.mean(),
        "u_along_spread_m_per_s": along.std(),
        "polar_order": np.linalg.norm(sum(one.turned[-1] @ one.axis for one in measured)) / len(measured),
        "nearest_distance_mean_m": distances.min(1).mean(),
        "nearest_distance_least_m": distances.min(),
    }


def rows_of(table):
    with table.open() as file:
        return list(csv.DictReader(file))


class Recomputation:
    """A run's figures from its trajectory."""

    def __init__(self, directory, case):
        self.case = case
        rows = defaultdict(list)
        for row in rows_of(directory / "trajectory.csv"):
            rows[row["body"]].append(row)
        self.bodies = {}
        for swimmer in case.get("swimmers") or []:
            for name, bead in zip(("B2", "B1", "B3"), swimmer["beads"]):
                name = f"{swimmer['name']}.{name}"
                self.bodies[name] = Body(name, bead, swimmer["bead_mass_kg"], True, rows[name])
        for body in case.get("bodies") or []:
            name = body["name"]
            self.bodies[name] = Body(name, body, body["mass_kg"], body.get("motion", "free") == "free", rows[name])
        for actuator in case.get("actuators") or []:
            assert (actuator["kind"], actuator["signal"]["kind"]) == ("body_torque", "sinusoid")
            body, signal = self.bodies[actuator["body"]], actuator["signal"]
            phase = 2 * np.pi * np.arange(len(body.q)) / signal["period_steps"]
            directions = np.array([rotation_matrix(q) @ actuator["direction"] for q in body.q])
            body.drive_torque += signal["amplitude_N_m"] * np.sin(phase)[:, None] * directions
        steps = len(next(iter(rows.values()))) - 1
        self.swimmers = []
        for swimmer in case.get("swimmers") or []:
            beads = [self.bodies[f"{swimmer['name']}.{bead}"] for bead in ("B2", "B1", "B3")]
            stroke, axis = swimmer["stroke"], rotation_matrix(swimmer["orientation_wxyz"])[:, 2]
            arms = [(beads[0], beads[1]), (beads[1], beads[2])]
            drive = (stroke["period_steps"], stroke["cycles"])
            self.swimmers.append(Measured(case, swimmer["name"], beads, axis, arms, *drive, steps))
        self.groups = []
        for group in case.get("groups") or []:
            members = [self.bodies[name] for name in group["bodies"]]
            springs = [[self.bodies[name] for name in spring["bodies"]] for spring in case.get("springs") or []]
            periods = [actuator["signal"]["period_steps"] for actuator in case.get("actuators") or []]
            period = group.get("period_steps") or periods[0]
            axis = np.array(group["axis"]) / np.linalg.norm(group["axis"])
            self.groups.append(Measured(case, group["name"], members, axis, springs, period, 10**9, steps))

    def summary(self, cell_m):
        report = {"swimmers": [], "balance": balance(self.case, self.bodies.values())}
        for section, swimmer in zip(self.case.get("swimmers") or [], self.swimmers):
            entry = {"name": swimmer.name, **swimmer.figures_of_paper(self.case, section, cell_m)}
            report["swimmers"].append(entry | {"kinematics": swimmer.kinematics(self.case, cell_m)})
        if self.groups:
            report["groups"] = [{"name": g.name, "kinematics": g.kinematics(self.case, cell_m)} for g in self.groups]
        if together := swarm(self.case, self.swimmers):
            report["swarm"] = together
        return report

    def cycles(self):
        """Rows by swimmer and cycle."""
        measured = [*self.swimmers, *self.groups]
        most_arms = max(len(one.arms) for one in measured)
        step_s = self.case["step_s"]
        return {
            (one.name, str(number)): one.row(number, step_s, most_arms)
            for one in measured
            for number in range(len(one.cycles))
        }


class RecomputedFiguresTest(WholeRunTest):
    def setUp(self):
        super().setUp()
        self.compared = 0

    def set_sizes(self, run):
        """What a figure is a small difference of, by endings of its key: rounding errors are 1e-13 of these."""
        moved = [body for body in run.bodies.values() if body.moves]
        speed = max(np.linalg.norm(body.v, axis=1).max() for body in moved)
        cell_m, step_s = run.case["fluid"]["cell_size_m"], run.case["step_s"]
        impulse = step_s * sum(
            np.linalg.norm(body.F, axis=1).sum() + np.linalg.norm(body.drive, axis=1).sum() for body in moved
        )
        length = max(np.abs(body.x).max() for body in moved)
        energy = sum(body.mass_kg for body in moved) * speed**2
        self.sizes = {
            "momentum_N_s": impulse + sum(body.mass_kg for body in moved) * speed,
            "energy_J": energy,
            "um_per_s": 1e6 * speed,
            "m_per_s": speed,
            "cells_per_step": speed * step_s / cell_m,
            "u_swim_lattice": speed * step_s / cell_m,
            "lengths_per_cycle": 1e3 * speed * step_s / length,
            "_rad": 1.0,
            **dict.fromkeys(("axis", "polar_order"), 1.0),
            **dict.fromkeys(("axis_x", "axis_y", "axis_z"), 1.0),
            **dict.fromkeys(("x_m", "y_m", "z_m"), length),
            "change_from_last_cycle": 1e3,
        }

    def assert_same(self, ours, theirs, place, key=""):
        if isinstance(theirs, dict):
            self.assertEqual(sorted(ours), sorted(theirs), place)
            for name, value in theirs.items():
                known = key in ("momentum_N_s", "energy_J", "change_from_last_cycle")
                self.assert_same(ours[name], value, f"{place}.{name}", key if known else name)
        elif isinstance(theirs, list):
            self.assertEqual(len(ours), len(theirs), place)
            for number, value in enumerate(theirs):
                self.assert_same(ours[number], value, f"{place}.{number}", key)
        elif isinstance(theirs, float):
            self.compared += 1
            size = max((size for ending, size in self.sizes.items() if key.endswith(ending)), default=0.0)
            limit = RELATIVE * abs(theirs) + 1e-13 * size
            self.assertLessEqual(abs(ours - theirs), limit, f"{place}: {ours}, not {theirs}")
        else:
            self.assertEqual(ours, theirs, place)

    def test_tables_and_pages_of_sweeps_show_groups(self):
        case_file = self.folder / "sweep.yaml"
        sweep = "services: {transport: in_process}\nsweep: {parameters: {bodies.0.radius_m: [3.0e-6, 4.0e-6]}}\n"
        case_file.write_text("case: rods\n" + CASES["group on rods"] + sweep)
        out = self.run_of(case_file)
        rows = rows_of(out / "results.csv")
        self.assertEqual(len(rows), 2)
        runs = collect(out, lambda path: plan_of(path).case)
        figures = [figures for _, name, figures in comparison_rows(runs) if name == "all"]
        for row, cells in zip(rows, figures, strict=True):
            summary = json.loads((out / row["case"] / "summary.json").read_text())
            speed = summary["groups"][0]["kinematics"]["u_along_um_per_s"]
            self.assertEqual(float(row["kinematics.u_along_um_per_s"]), speed)
            self.assertEqual(cells["kinematics.u_along_um_per_s"].ours, speed)

    def compare(self, name):
        case_file = self.folder / "case.yaml"
        text = CASES[name] + "\noutput: {trajectory: {every_steps: 1}}\nservices: {transport: in_process}\n"
        case_file.write_text(f"case: {name.replace(' ', '_')}\n{text}")
        out = self.run_of(case_file)
        summary = json.loads((out / "summary.json").read_text())
        case = plan_of(out / "case.yaml").case
        case["step_s"] = summary["step_s"]
        again = Recomputation(out, case)
        self.assertLessEqual(OF_THE_RUN, set(summary))
        figures = {key: value for key, value in summary.items() if key not in OF_THE_RUN}
        self.set_sizes(again)
        ours = again.summary(summary["cell_size_m"])
        for entry in [*figures["swimmers"], *figures.get("groups", [])]:
            entry["kinematics"].pop("note", None)
        self.assertEqual(sorted(ours), sorted(figures))
        for key, value in figures.items():
            self.assert_same(ours[key], value, key)
        rows = rows_of(out / "cycles.csv")
        expected = again.cycles()
        self.assertEqual(sorted((row["swimmer"], row["cycle"]) for row in rows), sorted(expected))
        for row in rows:
            other = expected[row["swimmer"], row["cycle"]]
            self.assertEqual(sorted(row), sorted(other))
            for key, value in row.items():
                place = f"{row['swimmer']}, cycle {row['cycle']}, {key}"
                if isinstance(other[key], str) or other[key] is None:
                    self.assertEqual(value, other[key] or "", place)
                else:
                    self.assert_same(other[key], float(value), place, key)
        self.assertGreater(self.compared, 60)


def _test_of(name):
    return lambda self: self.compare(name)


for _name in CASES:
    setattr(RecomputedFiguresTest, f"test_{_name.replace(' ', '_')}", _test_of(_name))

if __name__ == "__main__":
    unittest.main()
