#!/usr/bin/python3
"""Response of a sphere's load to a step in its velocity, and the stability of the coupling that follows from it: what
docs/decisions/virtual_mass.md quotes.

    tests/validation/load_response.py [bounce_back|interpolated|central_linear|parabolic]     some minutes
"""

import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "deploy"))

from copepod_report.trajectory import Trajectory  # noqa: E402
from copepod_validation.experiment import lattice_case, sphere, viscosity  # noqa: E402

STEPS = 60  # before the sound of the sphere's images in the periodic box returns
BOX = 48


def response(radius, tau, boundary, turns):
    """s_j: impulse in step j after a step in (angular) velocity, by that of as much fluid; shape (STEPS,)."""
    speed = 1e-6 / (radius if turns else 1.0)
    motion = {"angular_velocity_rad_per_s" if turns else "velocity_m_per_s": [0, 0, speed]}
    body = sphere(radius, [BOX / 2 + shift for shift in (0.3, 0.2, 0.1)], "prescribed", **motion)
    scheme = {"collision": "trt", "moving_boundary": boundary, "refill": "nonequilibrium"}
    case = {"case": "load_response", **lattice_case([BOX] * 3, tau, "periodic", [body], STEPS, **scheme)}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "case.yaml")
        file.write_text(json.dumps(case), encoding="utf-8")
        command = [ROOT / "deploy/copepod", "run", file, "--out", f"{folder}/run"]
        subprocess.run(command, check=True, capture_output=True)
        sample = Trajectory(Path(folder, "run/trajectory.csv")).of("sphere")
    displaced = 4 / 3 * math.pi * radius**3 * (0.4 * radius**2 if turns else 1.0)
    return -sample["torque_N_m" if turns else "force_N"][:STEPS, 2] / (displaced * speed)


def continued(found, radius, tau, turns):
    """The response with its later part from the theory of unsteady Stokes flow."""
    nu = viscosity(tau)
    time = (np.arange(1 << 14) + 0.5) * nu / radius**2
    if turns:  # 1/√(πt) − exp(t) erfc(√t), its expansion for large t
        tail = 15 * nu / radius**2 * (1 + 1 / (6 * np.sqrt(np.pi * time) * np.maximum(time, 1)))
    else:
        tail = 4.5 * nu / radius**2 * (1 + 1 / np.sqrt(np.pi * time))
    tail[: len(found)] = found
    return tail


def is_stable(response_s, mass, virtual_mass, averages):
    """No zero of (M + m) z − m + A(z) Σ s_j z^(−j) outside |z| = 1.0002, by the winding number of that function / z."""
    modulus, samples = 1.0002, 1 << 16
    turn = np.arange(samples)
    z = modulus * np.exp(2j * np.pi * (turn + 0.5) / samples)
    damped = np.zeros(samples, complex)
    damped[: len(response_s)] = response_s * modulus ** -np.arange(len(response_s))
    total = np.fft.fft(damped * np.exp(-1j * np.pi * turn / samples))
    function = ((mass + virtual_mass) * z - virtual_mass + (0.5 * (1 + 1 / z) if averages else 1) * total) / z
    angle = np.angle(function[np.r_[1:samples, 0]] / function)
    return abs(angle.sum()) < np.pi


def least(condition, highest=20.0):
    """The smallest number from which `condition` holds, found by bisection."""
    low, high = 0.0, highest
    if condition(low):
        return 0.0
    if not condition(high):
        return math.inf
    while high - low > 0.002:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if condition(middle) else (middle, high)
    return high


def main():
    boundary = sys.argv[1] if len(sys.argv) > 1 else "bounce_back"
    print("motion    r  tau   s_0 … s_3                      M, averaged  M, not  m of M = 0.01, averaged  not")
    for turns in (False, True):
        for radius, tau in ((4, 0.55), (4, 2 / 3), (4, 1.0), (4, 2.0), (8, 0.55), (8, 2 / 3), (8, 2.0)):
            found = response(radius, tau, boundary, turns)
            whole = continued(found, radius, tau, turns)
            masses = [least(lambda mass: is_stable(whole, mass, 0.0, averages)) for averages in (True, False)]
            added = [least(lambda added: is_stable(whole, 0.01, added, averages)) for averages in (True, False)]
            start = " ".join(f"{value:6.3f}" for value in found[:4])
            print(
                f"{'turning' if turns else 'moving':8} {radius:2}  {tau:.3f}  {start}    {masses[0]:6.3f}      "
                f"{masses[1]:7.3f}  {added[0]:6.2f}                 {added[1]:6.2f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
