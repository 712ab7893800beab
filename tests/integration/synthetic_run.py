"""Writes a run directory with a swimmer whose motion is known in closed form."""

import json
import math

import h5py
import numpy as np

from surfaces import with_surfaces

CELL_M, STEP_S = 1e-6, 1e-9
PERIOD, CYCLES = 400, 5
ARMS = ((16.0, 2.5, 0.3), (16.5, 3.75, -0.9))  # l̄ [cells], d [cells], φ [rad]
SPEED = 1e-3  # of the middle bead [cells/step]
DOMAIN = (20, 24, 60)


def write_run(folder, name="design_a", published=None, mean_flow=True, steps=2400):
    """Run directory `folder`: case.yaml is what the stand-in coupler reads."""
    folder.mkdir(parents=True)
    case = {
        "case": name,
        "run": {"steps": steps},
        "fluid": {
            "solver": "lattice_boltzmann",
            "domain_cells": list(DOMAIN),
            "boundaries": {axis: {"low": "no_slip", "high": "no_slip"} for axis in "xyz"},
            "precision": "double",
        },
        "swimmers": [
            {
                "name": "swimmer",
                "center_m": [10e-6, 12e-6, 30e-6],
                "orientation_wxyz": [1, 0, 0, 0],
                "beads": [
                    {"shape": "sphere", "radius_m": 4e-6, "length_m": 0, "orientation": "parallel"},
                    {"shape": "capsule", "radius_m": 4e-6, "length_m": 8e-6, "orientation": "perpendicular"},
                    {"shape": "capsule", "radius_m": 2e-6, "length_m": 4e-6, "orientation": "parallel"},
                ],
                "stroke": {"period_steps": PERIOD, "cycles": CYCLES},
            }
        ],
        "output": {"fields": {"mean_over_steps": [0, 2000]}},
    }
    surfaces = with_surfaces(case)["surfaces"]
    (folder / "case.yaml").write_text(json.dumps({"name": name, "steps": steps, "case": case, "surfaces": surfaces}))
    swimmer = {
        "name": "swimmer",
        "u_swim_lattice": SPEED,
        "d1_cells": 2.5,
        "d2_cells": 3.75,
        "efficiency": None,
        "Re_bodies": {"B2": 0.1, "B1": None, "B3": 0.2},
        "published": published,
    }
    (folder / "summary.json").write_text(
        json.dumps(
            {
                "case": name,
                "parameter_set": None,
                "status": "finished",
                "steps": steps,
                "step_s": STEP_S,
                "cell_size_m": CELL_M,
                "wall_s": 12.0,
                "mlups": 33.0,
                "ranks": 2,
                "precision": "double",
                "digest": "00ff00ff00ff00ff",
                "timing": {"fluid_s": 11.0, "coupling_overhead": 0.01},
                "swimmers": [swimmer],
            }
        )
    )
    _write_trajectory(folder / "trajectory.csv", steps)
    _write_cycles(folder / "cycles.csv", min(CYCLES, steps // PERIOD))
    if mean_flow:
        _write_fields(folder / "fields.h5")


def write_unfinished_run(folder, steps=2400, at_step=1000, **provenance):
    """One that has not reached its last step; `provenance`: entries of provenance.json."""
    write_run(folder, mean_flow=False, steps=steps)
    (folder / "summary.json").unlink()
    (folder / "provenance.json").write_text(json.dumps({"status": "running", **provenance}))
    _write_trajectory(folder / "trajectory.csv", at_step)
    _write_cycles(folder / "cycles.csv", at_step // PERIOD)


def write_swarm(folder, swimmers=100, samples=60):
    """Swimmers on a ring that swim away from its centre at different speeds, without cycles.csv."""
    write_run(folder, "swarm", mean_flow=False)
    content = json.loads((folder / "case.yaml").read_text())
    (first,) = content["case"]["swimmers"]
    content["case"]["swimmers"] = [{**first, "name": f"s{number}"} for number in range(swimmers)]
    content["surfaces"] = with_surfaces(content["case"])["surfaces"]
    (folder / "case.yaml").write_text(json.dumps(content))
    summary = json.loads((folder / "summary.json").read_text())
    entries = [{"name": f"s{number}"} for number in range(swimmers)]
    (folder / "summary.json").write_text(json.dumps({**summary, "swimmers": entries}))
    (folder / "cycles.csv").unlink()
    header = (folder / "trajectory.csv").read_text().splitlines()[0]
    lines = [header]
    for sample in range(samples):
        for number in range(swimmers):
            angle = 2 * math.pi * number / swimmers
            for bead, place in (("B2", -1.0), ("B1", 0.0), ("B3", 1.0)):
                radius = 1e-6 * (400 + 16 * place + 0.01 * number * sample)
                values = [radius * math.cos(angle), 0.0, radius * math.sin(angle), 1, 0, 0, 0, *([0.0] * 15)]
                lines.append(f"{sample},{sample * STEP_S!r},s{number}.{bead}," + ",".join(map(str, values)))
    (folder / "trajectory.csv").write_text("\n".join(lines) + "\n")


def write_snapshot(path, step, velocity_m_per_s):
    """Adds one to a fields.h5, which need not exist; velocity of shape (nz, ny, nx, 3)."""
    with h5py.File(path, "a") as file:
        file[f"step_{step:09d}/velocity_m_per_s"] = velocity_m_per_s.astype(np.float32)


def _write_trajectory(path, steps):
    names = (
        "step,time_s,body,x_m,y_m,z_m,qw,qx,qy,qz,vx_m_per_s,vy_m_per_s,vz_m_per_s,wx_rad_per_s,wy_rad_per_s,"
        "wz_rad_per_s,fx_N,fy_N,fz_N,tx_N_m,ty_N_m,tz_N_m,drive_fx_N,drive_fy_N,drive_fz_N"
    )
    lines = [names]
    for step in range(0, steps + 1, 20):
        angle = 2 * math.pi * step / PERIOD
        arm_1, arm_2 = (mean + amplitude * math.cos(angle + phase) for mean, amplitude, phase in ARMS)
        middle = 30.0 + SPEED * step
        for bead, z in (("B2", middle - arm_1), ("B1", middle), ("B3", middle + arm_2)):
            values = [10e-6, 12e-6, z * CELL_M, 1, 0, 0, 0, *([0.0] * 14), 1e-5 * math.sin(angle)]
            lines.append(f"{step},{step * STEP_S!r},swimmer.{bead}," + ",".join(map(repr, values)))
    path.write_text("\n".join(lines) + "\n")


def _write_cycles(path, cycles):
    names = (
        "swimmer,cycle,start_step,start_s,x_m,y_m,z_m,axis_x,axis_y,axis_z,tilt_rad,u_along_m_per_s,u_across_m_per_s,"
        "ux_m_per_s,uy_m_per_s,uz_m_per_s,rotation_x_rad,rotation_y_rad,rotation_z_rad,power_W,dissipation_W,"
        "efficiency,Re,arm0_mean_m,arm0_amplitude_m,arm0_phase_rad,arm1_mean_m,arm1_amplitude_m,arm1_phase_rad"
    )
    lines = [names]
    speed = SPEED * CELL_M / STEP_S
    for cycle in range(cycles):
        start = cycle * PERIOD
        arms = [value for mean, amplitude, phase in ARMS for value in (mean * CELL_M, amplitude * CELL_M, phase)]
        values = [cycle, start, start * STEP_S, 10e-6, 12e-6, (30 + SPEED * start) * CELL_M, 0, 0, 1, 0, speed, 0]
        values += [0, 0, speed, 0, 0, 0, 1e-5, 1e-5, "", "", *arms]
        lines.append("swimmer," + ",".join(map(str, values)))
    path.write_text("\n".join(lines) + "\n")


def _write_fields(path):
    """A vortex in every plane normal to x; shape (nz, ny, nx, 3)."""
    nx, ny, nz = DOMAIN
    z, y, _ = np.meshgrid(np.arange(nz), np.arange(ny), np.arange(nx), indexing="ij")
    velocity = np.zeros((nz, ny, nx, 3))
    velocity[..., 1] = np.sin(2 * np.pi * z / nz) * 1e-3
    velocity[..., 2] = np.sin(2 * np.pi * y / ny) * 2e-3
    with h5py.File(path, "w") as file:
        file["mean/velocity_m_per_s"] = velocity
        file["mean/density_kg_per_m3"] = np.full((nz, ny, nx), 1360.0)
        for number, step in enumerate((400, 800), 2):
            file[f"step_{step:09d}/velocity_m_per_s"] = number * velocity
