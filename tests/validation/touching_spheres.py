#!/usr/bin/python3
"""Spheres that meet in a fluid: rebound from a wall, drafting, kissing and tumbling, hindered settling.

    tests/validation/touching_spheres.py                          writes docs/results/contacts.md; half an hour
    tests/validation/touching_spheres.py rebound --runs FOLDER    one of the three; keeps the runs, uses those there
"""

import argparse
import json
import math
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "deploy"))

from copepod_report.style import LIGHT, new_figure, png_of  # noqa: E402
from copepod_report.trajectory import Trajectory  # noqa: E402
from copepod_validation.experiment import lattice_case, sphere, table  # noqa: E402

RESULTS = ROOT / "docs/results"
DRY = 0.97  # restitution of Gondret's steel spheres
_SEEN = (100, 50, 25)  # parts of a diameter from the wall at which a rebound is measured


def drag_factor(reynolds):
    """Of Stokes' drag at a Reynolds number [Schiller & Naumann 1933]."""
    return 1 + 0.15 * reynolds**0.687


def weight_to_settle(radius, viscosity, speed):
    """Force with which a sphere settles in an unbounded fluid of density 1."""
    return 6 * math.pi * viscosity * radius * speed * drag_factor(2 * radius * speed / viscosity)


def run(name, case, folder, **keys):
    path, out = folder / f"{name}.yaml", folder / name
    if not (out / "summary.json").exists():
        path.write_text(json.dumps({"case": name, "services": {"fluid": {"ranks": 2}}, **case, **keys}))
        done = subprocess.run([ROOT / "deploy/copepod", "run", path, "--out", out], capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(f"{name}: exit code {done.returncode}\n{done.stderr}")
    return Trajectory(out)


# --- rebound ---


def rebound(stokes, density, folder, diameter=16):
    """A sphere that settles onto a wall: (Stokes number of the impact, Reynolds number, restitution at each of _SEEN).

    The velocity of the impact is the largest within a radius of the wall."""
    speed, radius, height = 0.04, 0.5 * diameter, 5 * diameter
    reynolds = 9 * stokes / density
    viscosity = speed * diameter / reynolds
    cells = [4 * diameter, 4 * diameter, height + 2 * diameter]
    body = sphere(radius, [2 * diameter, 2 * diameter, height], "free", density, velocity_m_per_s=[0, 0, -speed])
    steps = round((1.6 * height + 2 * diameter) / speed)
    case = lattice_case(cells, 0.5 + 3 * viscosity, {"x": "periodic", "y": "periodic", "z": "no_slip"}, [body], steps)
    weight = weight_to_settle(radius, viscosity, speed)
    motion = run(
        f"rebound_{stokes}_{diameter}",
        case,
        folder,
        gravity_m_per_s2=[0, 0, -weight / ((density - 1) * body["mass_kg"] / density)],
        contact={"restitution": DRY, "friction": 0.1},
        lubrication={"cut_off_cells": "auto", "roughness_m": 1e-4 * radius},
    ).of("sphere")
    gap, velocity = motion["position_m"][:, 2] - radius, motion["velocity_m_per_s"][:, 2]
    lowest = int(np.argmin(gap))
    highest = lowest + int(np.argmax(gap[lowest:]))
    impact = -velocity[:lowest][gap[:lowest] < radius].min()
    way_back = slice(lowest, highest + 1)
    seen = np.interp(diameter / np.array(_SEEN), gap[way_back], velocity[way_back], right=0.0)  # if it comes so far
    return stokes * impact / speed, reynolds * impact / speed, seen / impact


_REBOUND = """## Rebound from a wall

A sphere of 16 cells in diameter settles from five diameters, with the velocity of an unbounded fluid at first, onto a
wall. Gondret, Lance and Petit [Phys. Fluids 14, 643, 2002] measured the restitution e for many spheres and liquids;
relative to the dry one it depends on the Stokes number St = ρ_s D U/(9 μ) alone. It vanishes below St = 10 to 20 and
follows exp(−35/St) above [Legendre, Daniel and Guiraud, Phys. Fluids 17, 097105, 2005]. Dry restitution 0.97, roughness
10⁻⁴ radii; U is the largest velocity within a radius of the wall.

A sphere loses velocity all the way back: to the film first, then to the fluid that follows it. So e depends on where
the rebound is measured; experiments resolve some hundredths of a diameter. The difference to the measured curve is that
at D/50, within 0.05 wherever there is a rebound.

{table}

Most of the loss is that of lubrication theory, ln(h/roughness)/St of the velocity on the way in and as much on the way
back. With the film's resistance as it is at the start of a step, e at St = 26 was 0.74 where it is 0.52 now right after
contact; with films that act in contact, too, e at St = 89 was 0.47.

"""


def rebounds(folder):
    rows = []
    for stokes, density in ((15, 8), (30, 8), (60, 8), (100, 8), (200, 15), (400, 30), (1000, 60)):
        st, reynolds, e = rebound(stokes, density, folder)
        measured = DRY * math.exp(-35 / st)
        cells = " | ".join(f"{value:.3f}" for value in e)
        rows.append(f"{st:.0f} | {reynolds:.0f} | {density} | {cells} | {measured:.3f} | {e[1] - measured:+.3f}")
        print(rows[-1], flush=True)
    heads = " | ".join(f"e at D/{part}" for part in _SEEN)
    return _REBOUND.format(table=table(f"St | Re | density ratio | {heads} | 0.97 exp(−35/St) | difference", rows))


# --- drafting, kissing and tumbling ---

_TUMBLING_DIAMETER_M = 1e-2 / 6
_TUMBLING = """## Drafting, kissing and tumbling

Two spheres of 1/6 cm, density 1.14, in a column of 1 × 1 × 6 cm of water, one 0.34 cm above the other: the case of
Glowinski et al. [J. Comput. Phys. 169, 363, 2001], with ten cells per diameter, in a column that is longer by a half,
and with the upper one off the axis by a hundredth of a diameter. It is drawn into the wake of the lower one (drafting),
reaches it (kissing), and the pair, unstable as it is one behind the other, turns over and parts (tumbling) [Fortes,
Joseph and Lundgren, J. Fluid Mech. 177, 467, 1987].

| | |
|---|---|
| drafting: the upper one is {faster:.0f} % faster than the lower one at most | until {kiss:.3f} s |
| kissing: the surfaces are closer than {near} diameters | {kiss:.3f} s to {part:.3f} s |
| tumbling: the line of centres passes 45° | {tumble:.3f} s |
| the upper one has passed the lower one | from {passed} on |

![Drafting, kissing and tumbling](contacts_tumbling.png)

"""


def _tumbling_case():
    radius_m, cell_m = 0.5 * _TUMBLING_DIAMETER_M, 0.1 * _TUMBLING_DIAMETER_M
    mass_kg = 1140 * 4 / 3 * math.pi * radius_m**3
    bodies = [
        {"name": name, "radius_m": radius_m, "mass_kg": mass_kg, "position_m": place}
        for name, place in (("leading", [5e-3, 5e-3, 5.16e-2]), ("trailing", [5.015e-3, 5.007e-3, 5.5e-2]))
    ]
    fluid = {
        "solver": "lattice_boltzmann",
        "density_kg_per_m3": 1000,
        "kinematic_viscosity_m2_per_s": 1e-6,
        "cell_size_m": cell_m,
        "relaxation_time": 0.51,
        "domain_cells": [60, 60, 360],
    }
    return {
        "fluid": fluid,
        "bodies": bodies,
        "gravity_m_per_s2": [0, 0, -9.81],
        "contact": {"restitution": 0.9, "friction": 0.1},
        "lubrication": {"cut_off_cells": "auto", "roughness_m": 1e-6},
        "run": {"steps": 11000},
        "output": {"trajectory": {"every_steps": 20}},
    }


def tumbling(folder):
    near = 0.02
    trajectory = run("tumbling", _tumbling_case(), folder)
    first, second = (trajectory.of(name) for name in ("leading", "trailing"))
    time_s = trajectory.time_s
    apart = second["position_m"] - first["position_m"]
    distance = np.linalg.norm(apart, axis=1)
    gap = distance / _TUMBLING_DIAMETER_M - 1
    tilt = np.degrees(np.arccos(apart[:, 2] / distance))
    kiss = int(np.argmax(gap < near))
    part = kiss + int(np.argmax(gap[kiss:] > near))
    tumble = int(np.argmax(tilt > 45))
    speeds = [motion["velocity_m_per_s"][:, 2] for motion in (first, second)]
    below = np.flatnonzero(tilt > 90)
    moving = slice(kiss // 4, kiss)
    facts = {
        "faster": 100 * (speeds[1][moving] / speeds[0][moving] - 1).max(),
        "kiss": time_s[kiss],
        "part": time_s[part],
        "tumble": time_s[tumble],
        "near": near,
        "passed": f"{time_s[below[0]]:.3f} s" if len(below) else "– (not in this run)",
    }
    print(facts, f"least gap {gap.min():.4f} D, largest tilt {tilt.max():.0f}")
    figure, panels = new_figure(LIGHT, 3.0, ncols=3)
    for motion, colour, name in ((first, LIGHT.beads[0], "lower at first"), (second, LIGHT.beads[1], "upper at first")):
        panels[0].plot(time_s, 100 * motion["position_m"][:, 2], color=colour, label=name)
        panels[1].plot(time_s, 100 * motion["velocity_m_per_s"][:, 2], color=colour)
    panels[2].plot(time_s, gap, color=LIGHT.ink, label="gap [diameters]")
    panels[2].plot(time_s, tilt / 90, color=LIGHT.beads[2], label="tilt [90°]")
    for panel, title in zip(panels, ("height [cm]", "velocity [cm/s]", "between them")):
        panel.set_title(title, fontsize=10)
        panel.set_xlabel("time [s]")
    panels[2].set_ylim(top=2.0)  # room for the legend
    for panel in (panels[0], panels[2]):
        panel.legend(fontsize=8, frameon=False)
    (RESULTS / "contacts_tumbling.png").write_bytes(png_of(figure))
    return _TUMBLING.format(**facts)


# --- hindered settling ---

_DIAMETER, _WIDTH, _HEIGHT = 8, 48, 128  # of a sphere and of the vessel; cells
_SPEED, _VISCOSITY, _DENSITY = 0.01, 0.1, 2.5  # of one sphere alone; Re = 0.8

_SETTLING = """## Hindered settling

Spheres of 8 cells in diameter, placed at random in a vessel of 6 × 6 × 16 diameters with floor, lid and periodic sides,
settle from rest; alone they would with Re = {reynolds}. The mean velocity of those between 5 and 11 diameters above the
floor, while each settles from 1.5 to 4.5 diameters, against Richardson and Zaki [Trans. Inst. Chem. Eng. 32, 35, 1954]:
(1 − φ)ⁿ with n = 4.35 Re^−0.03 = {exponent:.2f}; {seeds} arrangements each, with their spread.

{table}

"""


def settling_velocity(fraction, seed, folder):
    """Mean velocity in a suspension, over that of a sphere alone."""
    radius, volume = 0.5 * _DIAMETER, math.pi / 6 * _DIAMETER**3
    places = _random_places(round(fraction * _WIDTH**2 * _HEIGHT / volume), np.random.default_rng(seed))
    bodies = [
        sphere(radius, place, "free", _DENSITY) | {"name": f"sphere_{number}"} for number, place in enumerate(places)
    ]
    expected = _SPEED * (1 - fraction) ** 4.5
    steps = round(4.5 * _DIAMETER / expected)
    boundaries = {"x": "periodic", "y": "periodic", "z": "no_slip"}
    case = lattice_case([_WIDTH, _WIDTH, _HEIGHT], 0.5 + 3 * _VISCOSITY, boundaries, bodies, steps)
    case["output"] = {"trajectory": {"every_steps": 50}}
    weight = weight_to_settle(radius, _VISCOSITY, _SPEED)
    trajectory = run(
        f"settling_{fraction}_{seed}",
        case,
        folder,
        gravity_m_per_s2=[0, 0, -weight / ((_DENSITY - 1) * volume)],
        contact={"restitution": 0.9, "friction": 0.1},
        lubrication={"cut_off_cells": "auto", "roughness_m": 1e-3 * radius},
    )
    late = trajectory.steps > steps / 3
    height = trajectory.all_of("position_m")[late, :, 2] / _DIAMETER
    inside = (height > 5) & (height < 11)
    return float(-trajectory.all_of("velocity_m_per_s")[late, :, 2][inside].mean() / _SPEED)


def _random_places(count, random):
    """Centres of spheres that do not touch each other, floor or lid, one after the other; shape (count, 3)."""
    period, least = np.array([_WIDTH, _WIDTH, np.inf]), 1.02 * _DIAMETER
    low, high = [0, 0, 0.5 * least], [_WIDTH, _WIDTH, _HEIGHT - 0.5 * least]
    places = np.empty((0, 3))
    while len(places) < count:
        place = random.uniform(low, high)
        apart = np.abs(places - place)
        apart = np.minimum(apart, period - apart)
        if (np.square(apart).sum(axis=1) > least**2).all():
            places = np.vstack([places, place])
    return places


def settling(folder):
    reynolds, seeds, rows = _SPEED * _DIAMETER / _VISCOSITY, (1, 2, 3), []
    exponent = 4.35 * reynolds**-0.03
    for fraction in (0.05, 0.1, 0.2, 0.3):
        found = [settling_velocity(fraction, seed, folder) for seed in seeds]
        law, mean = (1 - fraction) ** exponent, np.mean(found)
        cells = f"{mean:.3f} | {min(found):.3f} … {max(found):.3f} | {law:.3f} | {100 * (mean / law - 1):+.1f} %"
        rows.append(f"{fraction} | {cells} | {math.log(mean) / math.log(1 - fraction):.2f}")
        print(rows[-1], flush=True)
    heads = "φ | velocity, over that alone | spread | (1 − φ)ⁿ | deviation | n"
    return _SETTLING.format(reynolds=f"{reynolds:g}", exponent=exponent, seeds=len(seeds), table=table(heads, rows))


PARTS = {"rebound": rebounds, "tumbling": tumbling, "settling": settling}

_HEAD = """# Spheres that meet in a fluid

```sh
tests/validation/touching_spheres.py        # writes this page; half an hour
```

Contacts without a fluid are in the tests ([decision](../decisions/contacts.md)); here films and contacts act together
([theory](../theory.md), C20 to C22). The page was written on two cores of {processor}.

"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", choices=[[], *PARTS], metavar="part", help=", ".join(PARTS))
    parser.add_argument("--runs", type=Path, help="keep the runs there")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        runs = arguments.runs or Path(folder)
        runs.mkdir(parents=True, exist_ok=True)
        texts = [PARTS[part](runs) for part in arguments.parts or PARTS]
    if not arguments.parts:
        processor = re.search(r"^model name\s*: (.*)$", Path("/proc/cpuinfo").read_text(), re.MULTILINE)[1]
        (RESULTS / "contacts.md").write_text(_HEAD.format(processor=processor) + "".join(texts).rstrip() + "\n")


if __name__ == "__main__":
    sys.exit(main())
