#!/usr/bin/python3
"""Palabos beside our fluid, and both with every body component: prints the tables of docs/foreign_engines.md.

    foreign_engines.py /tmp/palabos_fluid/palabos_fluid [EXPERIMENT]…

Experiments: array, small, turning, wall, lift, carried, settling, swimmer, design_a, matrix, speed.
"""

import csv
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CASES = ROOT / "configs/examples/foreign"
YADE = "/usr/bin/python3 examples/yade_body/yade_body.py"
CELL_M, DENSITY_KG_PER_M3, VISCOSITY_M2_PER_S = 1e-5, 1000.0, 1e-6
VISCOSITY_PA_S = DENSITY_KG_PER_M3 * VISCOSITY_M2_PER_S
ZICK_HOMSY = {0.027: 2.008, 0.125: 4.292}
SCHEMES = (
    ("ours", False, "bgk", "bounce_back"),
    ("ours", False, "trt", "parabolic"),
    ("Palabos", True, "bgk", "immersed"),
)
PALABOS = ""


def run(case, palabos, *options, scheme="parabolic"):
    """Rows of the trajectory, and the summary, of a case (a file or a dictionary) in Palabos or in our fluid."""
    with tempfile.TemporaryDirectory() as folder:
        if isinstance(case, dict):
            file = Path(folder, "case.yaml")
            file.write_text(json.dumps(case))
            case = file
        ours = ["--set", f"fluid.moving_boundary={scheme}", "--set", "fluid.refill=nonequilibrium"]
        ours += ["--set", "fluid.solver=lattice_boltzmann", "--set", "lubrication.cut_off_cells=none"]
        command = [ROOT / "deploy/copepod", "run", case, "--out", Path(folder, "out"), *options]
        ended = subprocess.run(
            [*map(str, command), *(["--fluid", PALABOS] if palabos else ours)],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=False,
        )
        if ended.returncode:
            raise RuntimeError(ended.stdout + ended.stderr)
        with open(Path(folder, "out/trajectory.csv")) as file:
            rows = [{k: v if k == "body" else float(v) for k, v in row.items()} for row in csv.DictReader(file)]
        return rows, json.loads(Path(folder, "out/summary.json").read_text())


def case_of(cells, tau, body, steps, every, boundaries=None, collision="trt", **more):
    """A case in water-like units; `body` completes a ball of one ng."""
    fluid = {
        "solver": "lattice_boltzmann",
        "density_kg_per_m3": DENSITY_KG_PER_M3,
        "kinematic_viscosity_m2_per_s": VISCOSITY_M2_PER_S,
        "cell_size_m": CELL_M,
        "relaxation_time": tau,
        "domain_cells": cells,
        "boundaries": boundaries or {axis: "periodic" for axis in "xyz"},
        "collision": collision,
    }
    fluid |= {key: more.pop(key) for key in ("body_force_N_per_m3",) if key in more}
    output = {"trajectory": {"every_steps": every}}
    bodies = [{"name": "ball", "mass_kg": 1e-9} | body]
    return {"case": "foreign", "fluid": fluid, "bodies": bodies, "run": {"steps": steps}, "output": output} | more


def mean(rows, name, last):
    return sum(row[name] for row in rows[-last:]) / last


def torque_or_force(kind, direction, **amplitude):
    signal = {"kind": "constant"} | amplitude
    return [{"kind": kind, "body": "ball", "direction": direction, "signal": signal}]


def drag_in_array(cells, place, radius, tau, steps, collision, palabos, scheme="parabolic"):
    """A neutrally buoyant sphere is pushed against the fluid: K of F (1 − φ)⁻¹ = 6πμr U K(φ). Lengths in cells."""
    fraction, side_m = 4 / 3 * math.pi * (radius / cells) ** 3, cells * CELL_M
    stokes = 6 * math.pi * VISCOSITY_PA_S * radius * CELL_M
    force_N = stokes * 1e-3 * VISCOSITY_M2_PER_S / CELL_M / ((tau - 0.5) / 3)
    body = {"radius_m": radius * CELL_M, "position_m": [x * CELL_M for x in place]}
    body["mass_kg"] = DENSITY_KG_PER_M3 * fraction * side_m**3
    case = case_of([cells] * 3, tau, body, steps, 50, collision=collision)
    case["fluid"]["body_force_N_per_m3"] = [0, 0, -force_N / (1 - fraction) / side_m**3]
    case["actuators"] = torque_or_force("world_force", [0, 0, 1], amplitude_N=force_N)
    rows, _ = run(case, palabos, scheme=scheme)
    return force_N / stokes / mean(rows, "vz_m_per_s", 12) / (1 - fraction)


def array():
    """Drag of a periodic array of spheres in 24³ cells, deviation from Zick & Homsy (1982)."""
    print("| φ | τ | collision | ours [%] | Palabos [%] |\n|---|---|---|---|---|")
    for fraction, reference in ZICK_HOMSY.items():
        radius = 24 * (fraction * 3 / 4 / math.pi) ** (1 / 3)
        for tau, steps in ((2 / 3, 3000), (1.0, 1500)):
            for collision in ("bgk", "trt"):
                errors = [
                    100
                    * (drag_in_array(24, [12.3, 12.21, 11.88], radius, tau, steps, collision, palabos) / reference - 1)
                    for palabos in (False, True)
                ]
                print(f"| {fraction} | {tau:.3f} | {collision} | {errors[0]:+.2f} | {errors[1]:+.2f} |", flush=True)


def small():
    """Drag of an array of spheres of radius 2 in 16³ cells, deviation from Sangani & Acrivos (1982) at three places."""
    phi = 4 / 3 * math.pi / 8**3
    reference = 1 / (1 - 1.7601 * phi ** (1 / 3) + phi - 1.5593 * phi**2 + 3.9799 * phi ** (8 / 3))
    for name, palabos, collision, scheme in SCHEMES:
        errors = [
            100 * (drag_in_array(16, place, 2, 2 / 3, 1500, collision, palabos, scheme) / reference - 1)
            for place in ([8.3, 8.21, 7.88], [8, 8.5, 8.5], [8.5, 8.5, 8])
        ]
        print(name, collision, scheme, *(f"{error:+.1f}" for error in errors), flush=True)


def turning():
    """8πμR³Ω = T (1 − φ): configs/validation/rotating_sphere.yaml."""
    print("| τ | collision | ours [%] | Palabos [%] |\n|---|---|---|---|")
    phi = 4 / 3 * math.pi * (4 / 24) ** 3
    expected = 5e-14 * (1 - phi) / (8 * math.pi * VISCOSITY_PA_S * (4 * CELL_M) ** 3)
    for tau, steps in ((2 / 3, 4000), (1.0, 1500)):
        for collision in ("bgk", "trt"):
            sets = (f"fluid.relaxation_time={tau}", f"fluid.collision={collision}", f"run.steps={steps}")
            options = [word for key in sets for word in ("--set", key)]
            errors = [
                100
                * (
                    mean(run(ROOT / "configs/validation/rotating_sphere.yaml", p, *options)[0], "wz_rad_per_s", 4)
                    / expected
                    - 1
                )
                for p in (False, True)
            ]
            print(f"| {tau:.3f} | {collision} | {errors[0]:+.2f} | {errors[1]:+.2f} |", flush=True)


def wall():
    """A sphere of radius 4 moves or turns near a wall: force over 6πμRU, torque over 8πμR³Ω, with U = RΩ."""
    print("| motion | height/R | load | theory | ours | Palabos |\n|---|---|---|---|---|---|")
    radius_m, step_s = 4 * CELL_M, CELL_M**2 / 6 / VISCOSITY_M2_PER_S
    speed = 1e-6 * CELL_M / step_s
    force_N, torque_N_m = (
        6 * math.pi * VISCOSITY_PA_S * radius_m * speed,
        8 * math.pi * VISCOSITY_PA_S * radius_m**2 * speed,
    )
    velocities = {"towards": ([0, 0, -speed], [0, 0, 0]), "along": ([speed, 0, 0], [0, 0, 0])}
    velocities["turning"] = ([0, 0, 0], [0, speed / radius_m, 0])
    for motion, height, theory in (
        ("towards", 2.3524, {"fz_N": 1.8374}),
        ("along", 2.3524, {"fx_N": -1.3079, "ty_N_m": None}),
        ("along", 1.5431, {"fx_N": -1.5675, "ty_N_m": 0.01465}),
        ("turning", 1.5431, {"fx_N": 0.01953, "ty_N_m": -1.0998}),
    ):
        velocity, spin = velocities[motion]
        body = {"radius_m": radius_m, "motion": "prescribed", "velocity_m_per_s": velocity}
        body |= {"angular_velocity_rad_per_s": spin, "position_m": [32.3 * CELL_M, 32.2 * CELL_M, height * radius_m]}
        faces = {"x": "periodic", "y": "periodic", "z": "no_slip"}
        case = case_of([64, 64, 48], 1.0, body, 600, 20, faces, coupling={"load_averaging": "none"})
        ours, palabos = (run(case, palabos)[0][-1] for palabos in (False, True))
        for load, expected in theory.items():
            unit, name = (force_N, "force") if load[0] == "f" else (torque_N_m, "torque")
            known = "–" if expected is None else f"{expected:+.4f}"
            print(
                f"| {motion} | {height} | {name} | {known} | {ours[load] / unit:+.4f} | {palabos[load] / unit:+.4f} |"
            )


def spinning(cells, tau, faces, speed, steps, every):
    """A sphere of radius 4 that turns about y at 0.02 cells per step and moves along x; speed [cells/step]."""
    cells_per_step = VISCOSITY_M2_PER_S / CELL_M / ((tau - 0.5) / 3)
    spin = 0.02 * cells_per_step / (4 * CELL_M)
    middle = [(0.5 * cells + offset) * CELL_M for offset in (0.3, 0.2, 0.1)]
    body = {"radius_m": 4 * CELL_M, "motion": "prescribed", "position_m": middle}
    body |= {"velocity_m_per_s": [speed * cells_per_step, 0, 0], "angular_velocity_rad_per_s": [0, spin, 0]}
    case = case_of([cells] * 3, tau, body, steps, every, dict.fromkeys("xyz", faces))
    unit_N = DENSITY_KG_PER_M3 * (4 * CELL_M) ** 3 * spin * speed * cells_per_step
    return case | {"coupling": {"load_averaging": "none"}}, unit_N


def lift():
    """A turning sphere moves in a closed box of 64³ cells, τ = 1; lift over πρR³ΩU [Rubinow & Keller 1961]."""
    case, unit_N = spinning(64, 1.0, "no_slip", 0.002, 3000, 20)
    for name, palabos in (("ours", False), ("Palabos", True)):
        force_N = mean(run(case, palabos)[0], "fz_N", 25)  # while it moves by a cell
        print(f"{name}: {-force_N / unit_N / math.pi:+.3f}", flush=True)


def carried():
    """A turning sphere sweeps all fluid of 24³ periodic cells along: lateral force over ρVΩU, change of the torque."""
    print("| τ | ours: force | torque [%] | Palabos: force | torque [%] |\n|---|---|---|---|---|")
    for tau, steps in ((2 / 3, 15000), (1.0, 5000)):
        cells = [f"{tau:.3f}"]
        for palabos in (False, True):
            rows, turning_only = (
                run(spinning(24, tau, "periodic", speed, steps, 5)[0], palabos)[0] for speed in (0.02, 0.0)
            )
            force_N = math.hypot(mean(rows, "fy_N", 100), mean(rows, "fz_N", 100))  # while it moves by ten cells
            unit_N = 4 / 3 * math.pi * spinning(24, tau, "periodic", 0.02, steps, 5)[1]
            torque = mean(rows, "ty_N_m", 100) / mean(turning_only, "ty_N_m", 100)
            cells += [f"{force_N / unit_N:.4f}", f"{100 * (torque - 1):+.2f}"]
        print(f"| {' | '.join(cells)} |", flush=True)


def settling():
    """Experiment E2 of ten Cate et al. (2002), twelve cells per diameter; largest velocity over u∞."""
    case = {
        "case": "settling_E2",
        "fluid": {
            "solver": "lattice_boltzmann",
            "density_kg_per_m3": 965,
            "kinematic_viscosity_m2_per_s": 2.196891e-4,
            "cell_size_m": 1.25e-3,
            "relaxation_time": 0.76365,
            "domain_cells": [80, 80, 128],
        },
        "bodies": [{"name": "ball", "radius_m": 7.5e-3, "mass_kg": 1.9792e-3, "position_m": [0.05, 0.05, 0.1275]}],
        "gravity_m_per_s2": [0, 0, -9.81],
        "run": {"steps": 3200},
        "output": {"trajectory": {"every_steps": 10}},
    }
    for name, palabos in (("ours", False), ("Palabos", True)):
        rows, _ = run(case, palabos, "--ranks", "2")
        print(f"{name}: {max(-row['vz_m_per_s'] for row in rows) / 0.06:.4f} u∞, measured 0.953")


def swimmer():
    """configs/quick/three_sphere.yaml in the whole domain."""
    whole = ("--set", "fluid.symmetry_planes=[]", "--set", "output.fields.mean_over_steps=[0,0]", "--ranks", "2")
    for name, palabos in (("ours", False), ("Palabos", True)):
        for collision in ("bgk", "trt"):
            case = ROOT / "configs/quick/three_sphere.yaml"
            _, summary = run(case, palabos, *whole, "--set", f"fluid.collision={collision}")
            one = summary["swimmers"][0]
            names = ("u_swim_lattice", "d1_cells", "d2_cells", "sin_dphi", "u_GA_lattice")
            print(name, collision, *(f"{number}={one[number]:.5g}" for number in names), flush=True)


def design_a():
    """Design (a) of the paper at half its resolution, three cycles, in the whole domain."""
    sets = {"cell_size_m": "2.0e-6", "domain_cells": [50, 50, 100], "symmetry_planes": [], "precision": "double"}
    sets = {f"fluid.{key}": value for key, value in sets.items()} | {"run.steps": 21087}
    stroke = {"period_steps": 7029, "phase_lag_steps": 1757, "cycles": 3}
    sets |= {f"swimmers.0.stroke.{key}": value for key, value in stroke.items()}
    sets |= {"output.fields.mean_over_steps": [0, 0]}
    options = [word for key, value in sets.items() for word in ("--set", f"{key}={value}")]
    for name, palabos, collision, scheme in SCHEMES:
        sets = ("--set", f"fluid.collision={collision}")
        _, summary = run(ROOT / "configs/paper/design_a.yaml", palabos, *options, *sets, "--ranks", "1", scheme=scheme)
        one = summary["swimmers"][0]
        names = ("u_swim_lattice", "d1_cells", "d2_cells", "sin_dphi", "u_GA_lattice")
        change = one["kinematics"]["change_from_last_cycle"]["velocity"]
        print(name, collision, scheme, *(f"{key}={one[key]:.5g}" for key in names), f"change={change:.2g}", flush=True)


def matrix():
    """Both fluids with four body components."""
    print(
        "| fluid | bodies | settling: peak [mm/s] | first contact [s] | apart at the end [mm] |\n|---|---|---|---|---|"
    )
    for palabos in (False, True):
        for body in ("own", "bullet", "mujoco", "yade"):
            who = ("--ranks", "1", *(("--body", YADE) if body == "yade" else ("--set", f"body.solver={body}")))
            rows, _ = run(CASES / "settling_sphere_palabos.yaml", palabos, *who)
            cells = [f"{1e3 * max(-row['vz_m_per_s'] for row in rows):.3f}"]
            try:
                rows, _ = run(CASES / "colliding_spheres_palabos_yade.yaml", palabos, *who)
            except RuntimeError as refused:
                cells += ["refused: contact:friction" if "contact:friction" in str(refused) else "failed", ""]
            else:
                pairs = list(zip(rows[::2], rows[1::2]))
                apart = [math.dist(*([row[f"{axis}_m"] for axis in "xyz"] for row in pair)) for pair in pairs]
                first = next(pair[0]["time_s"] for pair, gap in zip(pairs, apart) if gap <= 0.015)
                cells += [f"{first:.3f}", f"{1e3 * apart[-1]:.2f}"]
            print(f"| {'Palabos' if palabos else 'ours'} | {body} | {' | '.join(cells)} |", flush=True)


def speed():
    """Million cell updates per second, coupled, one sphere of radius 4 in a periodic cube."""
    for cells in (32, 64):
        body = {"radius_m": 4 * CELL_M, "motion": "fixed", "position_m": [0.5 * cells * CELL_M] * 3}
        case = case_of([cells] * 3, 1.0, body, 800_000 // cells**2, 50)
        for ranks in ("1", "2"):
            found = [run(case, palabos, "--ranks", ranks)[1]["mlups"] for palabos in (False, True)]
            print(f"{cells}³ on {ranks} rank(s): ours {found[0]:.1f}, Palabos {found[1]:.2f} MLUPS", flush=True)


if __name__ == "__main__":
    PALABOS, *chosen = sys.argv[1:] or sys.exit(__doc__)
    for experiment in (array, small, turning, wall, lift, carried, settling, swimmer, design_a, matrix, speed):
        if not chosen or experiment.__name__ in chosen:
            print(f"\n{experiment.__name__}: {experiment.__doc__}\n", flush=True)
            experiment()
