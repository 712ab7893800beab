#!/usr/bin/python3
"""Response of a sphere's load to a step in its velocity, and the stability of the coupling that follows from it: what
docs/decisions/virtual_mass.md quotes.

    tests/validation/load_response.py parabolic                               half an hour
    tests/validation/load_response.py parabolic --points 4,1 4,2 8,1 8,2      for some radii and relaxation times
    tests/validation/load_response.py central_linear --collision bgk --points 4,0.55 --box 24 --steps 1500

The response depends on where the sphere is between the cells, so that six places are examined, and the largest values
are printed; surfaces that return staggered momentum do so for hundreds of steps. For small relaxation times virtual
masses also have an upper limit, which the sound of the box sets: examine boxes of six radii with 1500 steps or more.
"""

import argparse
import json
import math
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "deploy"))

from copepod_report.trajectory import Trajectory  # noqa: E402
from copepod_validation.experiment import lattice_case, sphere, viscosity  # noqa: E402

# Centres relative to the centre of a cell: it, the middles of a face and an edge, a corner, and two others.
PLACES = ((0, 0, 0), (0, 0, 0.5), (0, 0.5, 0.5), (0.5, 0.5, 0.5), (0.3, 0.2, 0.1), (0.15, 0.4, 0.25))
POINTS = ((4, 0.55), (4, 2 / 3), (4, 1.0), (4, 1.5), (4, 2.0), (8, 0.55), (8, 2 / 3), (8, 1.0), (8, 2.0))


def response(radius, tau, scheme, turns, place, steps, box):
    """s_j: impulse in step j after a step in (angular) velocity, by that of as much fluid; shape (steps,)."""
    speed = 1e-6 / (radius if turns else 1.0)
    motion = {"angular_velocity_rad_per_s" if turns else "velocity_m_per_s": [0, 0, speed]}
    body = sphere(radius, [box / 2 + 0.5 + shift for shift in place], "prescribed", **motion)
    case = {"case": "load_response", **lattice_case([box] * 3, tau, "periodic", [body], steps, **scheme)}
    case["services"] = {"transport": "in_process"}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "case.yaml")
        file.write_text(json.dumps(case), encoding="utf-8")
        command = [ROOT / "deploy/copepod", "run", file, "--out", f"{folder}/run"]
        subprocess.run(command, check=True, capture_output=True)
        sample = Trajectory(Path(folder, "run")).of("sphere")
    displaced = 4 / 3 * math.pi * radius**3 * (0.4 * radius**2 if turns else 1.0)
    return -sample["torque_N_m" if turns else "force_N"][:steps, 2] / (displaced * speed)


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


def stable_range(condition):
    """The lowest range of virtual masses, up to 20, for which `condition` holds."""
    tried = np.geomspace(0.02, 20, 90)
    held = [condition(added) for added in tried]
    if not any(held):
        return math.inf, 0.0
    first = held.index(True)
    end = held.index(False, first) if False in held[first:] else None
    return tried[first], math.inf if end is None else tried[end - 1]


@dataclass(frozen=True)
class Limits:
    """Of one response; masses in displaced masses."""

    start: str  # s_0 … s_3
    staggered: float  # P = Σ (−1)^j s_j: without averaging, a mode of period two needs M + 2m > P
    masses: tuple[float, float]  # the least M without virtual mass: loads averaged, not averaged
    added: tuple[float, float]  # the least m of M = 0.01
    most: tuple[float, float]  # from there on, where M = 0.01 becomes unstable again


def limits(radius, tau, scheme, turns, place, steps, box):
    found = response(radius, tau, scheme, turns, place, steps, box)
    whole = continued(found, radius, tau, turns)
    signs = (-1.0) ** np.arange(steps)
    signs[-1] *= 0.5  # the mean of the last two sums
    return Limits(
        " ".join(f"{value:6.3f}" for value in found[:4]),
        float(signs @ found),
        tuple(least(lambda mass: is_stable(whole, mass, 0.0, averages)) for averages in (True, False)),
        *zip(*(stable_range(lambda added: is_stable(whole, 0.01, added, averages)) for averages in (True, False))),
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("boundary", choices=["bounce_back", "interpolated", "central_linear", "parabolic"])
    parser.add_argument("--points", nargs="+", metavar="R,TAU", help="radius in cells, relaxation time")
    parser.add_argument("--steps", type=int, default=400, help="of which the response is measured; default: 400")
    parser.add_argument("--collision", choices=["trt", "bgk"], default="trt")
    parser.add_argument("--box", type=int, default=48, help="edge of the periodic box in cells; default: 48")
    chosen = parser.parse_args()
    scheme = {"collision": chosen.collision, "moving_boundary": chosen.boundary, "refill": "nonequilibrium"}
    points = [tuple(map(float, point.split(","))) for point in chosen.points] if chosen.points else POINTS
    print(
        "motion   r  tau    s_0 … s_3 in the centre of a cell    P  M, averaged    not  m of M = 0.01, averaged    not"
    )
    for turns in (False, True):
        for radius, tau in points:
            places = [limits(radius, tau, scheme, turns, place, chosen.steps, chosen.box) for place in PLACES]
            masses, added = (np.max([getattr(one, name) for one in places], axis=0) for name in ("masses", "added"))
            most = np.min([one.most for one in places], axis=0)
            print(
                f"{'turning' if turns else 'moving':7} {radius:2.0f}  {tau:.3f}  {places[0].start}  "
                f"{max(one.staggered for one in places):9.2f}  {masses[0]:11.2f}  {masses[1]:5.2f}  "
                f"{added[0]:12.2f} … {most[0]:5.2f}  {added[1]:5.2f} … {most[1]:5.2f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
