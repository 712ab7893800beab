#!/usr/bin/python3
"""Spheres that meet in a fluid: rebound from a wall, drafting, kissing and tumbling, hindered settling.

    tests/validation/touching_spheres.py                          writes docs/results/contacts.md; 90 minutes
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

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "deploy"))

from copepod_report.style import LIGHT, new_figure, picture_of  # noqa: E402
from copepod_report.trajectory import Trajectory  # noqa: E402
from copepod_run.figures import markdown_table as table  # noqa: E402
from copepod_validation.experiment import lattice_case, sphere  # noqa: E402

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
    figure, panels = new_figure(3.0, ncols=3)
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
    (RESULTS / "contacts_tumbling.png").write_bytes(picture_of(figure))
    return _TUMBLING.format(**facts)


# --- hindered settling ---

_DIAMETER = 8  # cells
_WIDTHS = {0.05: 9, 0.1: 8, 0.15: 7, 0.2: 7}  # of the periodic cube by the volume fraction; diameters
_OTHER_WIDTHS = (6, 10)  # for 0.1
_REYNOLDS, _DENSITY = 10, 2  # of one sphere alone; over that of the fluid
_SPEED = 0.035  # expected in the suspension
_TRAVEL = 40  # diameters; the first quarter is left out
_BLOCKS = 6  # of the rest, for its error
_FINER = (8, 12, 16)  # cells per diameter of the same spheres in the same cube, 5 diameters wide
_START = 2.5  # diameters that these travel
_FASTER, _FASTER_WIDTH, _FASTER_TRAVEL = 50, 6, 30  # a larger Reynolds number, the cube and the travel there
_WIDER, _WIDER_TRAVEL = 14, 25  # cube for 0.05, with 6 cells per diameter
_DENSE = (0.3, 5, 8)  # volume fraction, cube and travel of a suspension that is squeezed
_CREEPING, _CREEPING_TIME, _CREEPING_DIAMETER = 0.05, 3.0, 6  # without inertia: Reynolds number, relaxation time, cells
_CREEPING_FRACTIONS = (0.05, 0.1, 0.15, 0.2, 0.25, 0.3)
_STARTS = {5: (10, 0.3), 8: (10, 0.2)}  # by the width of the cube: how many, up to which volume fraction
_OTHER_CREEPING = ((8, 3.0), (12, 3.0), (6, 1.0), (8, 1.0))  # cells and relaxation time for one of them

_SETTLING = """## Hindered settling

Spheres of 8 cells in diameter and twice the fluid's density, at random in a periodic cube, settle under their weight
less buoyancy, F. A body force on the fluid balances it: with the mean gradient of pressure nF, n spheres per volume,
the fluid feels nF against gravity, and each sphere F (1 − φ). The velocity U is the mean of all spheres, relative to
the volume flux of fluid and spheres. U₀ is that of one sphere alone under F, by the standard drag [Clift, Grace, Weber,
Bubbles, Drops and Particles, 1978, table 5.2]; the lattice gives 1.3 % more (Re = 10, a periodic box of 14 × 14 × 24
diameters, which makes some 1 % of it). The spheres travel {travel} diameters, of which the first quarter is left out; ±
is the standard error from the means of {blocks} parts of the rest. Restitution 0.9, friction 0.1, roughness 10⁻³ radii.

Richardson and Zaki [Trans. Inst. Chem. Eng. 32, 35, 1954] have U/U₀ = (1 − φ)ⁿ with n = 4.45 Re^−0.1 for Re of 1 to
500, here {n[0]}; Garside and Al-Dibouni [Ind. Eng. Chem. Process Des. Dev. 16, 206, 1977] have (5.1 − n)/(n − 2.7) =
0.1 Re^0.9, here {n[1]}. The last columns are k (1 − φ)ⁿ with the n of Richardson and Zaki and k = {k}, fitted to the
four velocities.

{table}

The velocity depends on φ as Richardson and Zaki found, within {worst} %, but for a factor k. Without it (k = 1) the
suspensions are {misses} % too slow: the 5 % that were aimed at are missed.

* *Other computations* are on this side, too. Yin and Koch [Phys. Fluids 19, 093302, 2007] have k near 0.9 for Re of 1
  to 20. The drag of random arrays of fixed spheres [Beetstra, van der Hoef and Kuipers, AIChE J. 53, 489, 2007] would
  give U/U₀ = {fixed}.
* *The structure* is a cause in the dilute suspension: wakes drive apart pairs one above the other. At φ = 0.05 the
  spheres settle with 0.73 U₀ between two and four diameters of their way, while they are as they were placed, and with
  0.67 U₀ in the end, when such pairs (closer than two diameters, within 30° of the vertical) are 0.67 times as frequent
  as at random, after 0.87 at the start. From φ = 0.1 on neither changes by as much.
* *The cube* is a small part of it. At φ = 0.1 its width matters little; at φ = 0.05, a cube of {wider} D, with 6 cells
  per diameter and over {wider_travel} diameters, gives U/U₀ = {in_wider}.

{widths}

* *The numerics* are not. Fluid and spheres keep their momentum to 0.1 % of the weights, and the drag of dilute arrays
  with 8 cells is right to 0.4 % ([accuracy](accuracy.md)). Of the same spheres in a cube of 5 diameters, U/U₀ over
  their first {start} diameters, the first quarter left out, depends neither on the cells nor on the films:

{finer}

  Later, small differences between the arrangements have grown, and only means over time are comparable.
* *The reference* is a fit to experiments. Spheres at random and without inertia are slower than Richardson and Zaki
  have it, too: 1 − 6.546 φ + 21.918 φ² [Cichocki, Ekiel-Jeżewska, Szymczak and Wajnryb, J. Chem. Phys. 117, 1231,
  2002] is 0.73 and 0.56 at φ = 0.05 and 0.1, where (1 − φ)^4.65 is 0.79 and 0.61. Di Felice [Int. J. Multiphase Flow
  25, 559, 1999] compares dilute suspensions, which he measured, with concentrated ones, and suggests that the law be
  improved. Why k is smaller here than Yin and Koch found is not known.
* *The Reynolds number* is not. With Re = {faster} and n = {faster_n}, in cubes of {faster_width} D and over
  {faster_travel} diameters:

{faster_table}

* *Without inertia*, in the classical regime of Richardson and Zaki (Re < 0.2, n = 4.65), the suspensions are slower
  than their law, too, the more so the denser they are. Here Re = {creeping}; the spheres, with 6 cells per diameter and
  τ = 3, are hard spheres in equilibrium, no closer than 1.02 diameters, and have moved by less than 0.4 diameters. In a
  periodic cube they are slower than in an infinite suspension, by 1.7601 S(0) (φ/N)^⅓ η/η_s of U₀, with the structure
  factor S(0) and the viscosity η_s of hard spheres [Phillips, Brady and Bossis, Phys. Fluids 31, 3462, 1988; Ladd, J.
  Chem. Phys. 93, 3484, 1990; Mo and Sangani, Phys. Fluids 6, 1637, 1994]. The table adds it for each cube, and then has
  the mean of all starts; ± are standard errors. The two cubes test the correction only as far as these allow.

{without_inertia}

  In experiments without inertia the exponent depends on the structure. Brzinski and Durian [Phys. Rev. Fluids 3,
  124303, 2018] find n = 5.6 ± 0.1 where Brownian motion keeps spheres in equilibrium, as they are here, and 4.48 ± 0.04
  where it does not. Cells and relaxation time do not matter. Of one start at φ = 0.2, in a cube of 5 D:

{other_creeping}

Of the three regimes, none has four volume fractions within 5 % of Richardson and Zaki without a factor k.

From φ = 0.3 on fluid is squeezed in cells between spheres ([theory](../theory_fluid.md), *Squeezed fluid*). In a cube
of {dense[1]} D, over {dense[2]} diameters, U/U₀ at φ = {dense[0]} is {in_dense}; k (1 − φ)ⁿ is {dense_law:.3f}.

"""


def standard_drag(reynolds):
    """Of one sphere over Stokes' drag, for Reynolds numbers of 0.01 to 20 [Clift, Grace, Weber 1978, table 5.2]."""
    return 1 + 0.1315 * reynolds ** (0.82 - 0.05 * math.log10(reynolds))


def _count(fraction, width):
    """Of spheres in a cube of a width in diameters."""
    return round(fraction * width**3 * 6 / math.pi)


def _settle(name, folder, places, diameters, diameter, reynolds, alone, steps, start, every, films):
    """Spheres at these places settle: mean velocity relative to the volume flux, over `alone`, that of a sphere alone,
    from step `start` on. Fields are read every so many steps, for the flux."""
    radius, volume, width = 0.5 * diameter, math.pi / 6 * diameter**3, diameters * diameter
    bodies = [
        sphere(radius, place, "free", _DENSITY) | {"name": f"sphere_{number}"}
        for number, place in enumerate(diameter * places)
    ]
    fraction, viscosity = len(bodies) * volume / width**3, alone * diameter / reynolds
    drag = 6 * math.pi * viscosity * radius * alone * standard_drag(reynolds)
    force = {"body_force_N_per_m3": [0, 0, len(bodies) * drag / width**3]}
    case = lattice_case([width] * 3, 0.5 + 3 * viscosity, "periodic", bodies, steps, **force)
    case["output"] = {
        "trajectory": {"every_steps": min(100, steps // 50)},
        "fields": {
            "mean_over_steps": [start, steps],
            "mean_every_steps": every,
            "quantities": ["velocity"],
        },
    }
    trajectory = run(
        name,
        case,
        folder,
        services={"transport": "in_process"},
        gravity_m_per_s2=[0, 0, -(1 - fraction) * drag / ((_DENSITY - 1) * volume)],
        contact={"restitution": 0.9, "friction": 0.1},
        lubrication={"cut_off_cells": films, **({"roughness_m": 1e-3 * radius} if films == "auto" else {})},
    )
    with h5py.File(folder / name / "fields.h5") as file:
        flux = file["mean/velocity_m_per_s"][..., 2].mean()  # of fluid and spheres
    late = trajectory.all_of("velocity_m_per_s")[trajectory.steps > start, :, 2].mean(axis=1)
    return (flux - late) / alone


def settling_velocity(
    fraction, diameters, folder, diameter=_DIAMETER, travel=_TRAVEL, films="auto", reynolds=_REYNOLDS, speed=_SPEED
):
    """Mean velocity relative to the volume flux, over that of a sphere alone, and its standard error."""
    places = _random_places(_count(fraction, diameters), diameters)
    exact, steps = len(places) * math.pi / 6 / diameters**3, round(travel * diameter / speed)
    name = f"settling_{reynolds}_{fraction}_{diameters}_{diameter}_{travel}_{films}"
    alone = speed / (1 - exact) ** 4.5
    late = _settle(name, folder, places, diameters, diameter, reynolds, alone, steps, steps // 4, 50, films)
    blocks = [block.mean() for block in np.array_split(late, _BLOCKS)]
    return late.mean(), np.std(blocks, ddof=1) / math.sqrt(_BLOCKS)


def creeping_velocity(fraction, diameters, folder, start, diameter=_CREEPING_DIAMETER, time=_CREEPING_TIME):
    """The same without inertia, of spheres in equilibrium, soon after they have started."""
    places = _random_places(_count(fraction, diameters), diameters, start, sweeps=100)
    viscosity, name = (time - 0.5) / 3, f"creeping_{fraction}_{diameters}_{diameter}_{time}_{start}"
    steps = round(0.2 * (diameters * diameter) ** 2 / viscosity)
    alone = _CREEPING * viscosity / diameter
    return _settle(
        name, folder, places, diameters, diameter, _CREEPING, alone, steps, 6 * steps // 10, steps // 50, "auto"
    ).mean()


def missing_in_a_cube(fraction, count):
    """By which spheres in a periodic cube are slower than in an infinite suspension, over U₀ [Ladd 1990]:
    1.7601 S(0) (φ/N)^⅓ η/η_s, with the structure factor of Carnahan and Starling and the viscosity of Ladd."""
    solid = fraction
    structure = (1 - solid) ** 4 / (1 + 4 * solid + 4 * solid**2 - 4 * solid**3 + solid**4)
    part = solid * (1 + solid - 0.189 * solid**2)
    return 1.7601 * structure * (solid / count) ** (1 / 3) * (1 - part) / (1 + 1.5 * part)


def _at_the_start(fraction, folder):
    """Of the same spheres with each number of cells per diameter, and with the first one without films."""
    for cells, films in [(cells, "auto") for cells in _FINER] + [(_FINER[0], "none")]:
        yield settling_velocity(fraction, 5, folder, cells, _START, films)[0]


def _without_inertia(folder):
    """Tables by volume fraction, and of one start by cells and relaxation time."""
    rows = []
    for fraction in _CREEPING_FRACTIONS:
        cells, found = [], []
        for width, (starts, largest) in _STARTS.items():
            if fraction > largest:
                cells.append("–")
                continue
            count = _count(fraction, width)
            exact = count * math.pi / 6 / width**3
            missing = missing_in_a_cube(exact, count)
            here = [creeping_velocity(fraction, width, folder, start) for start in range(1, starts + 1)]
            error = np.std(here, ddof=1) / math.sqrt(starts)
            cells.append(f"{np.mean(here):.3f} ± {error:.3f} + {missing:.3f}")
            found += [velocity + missing for velocity in here]
        mean, error = np.mean(found), np.std(found, ddof=1) / math.sqrt(len(found))
        laws = [(1 - fraction) ** exponent for exponent in (4.65, 5.6)]
        compared = " | ".join(f"{law:.3f} | {100 * (mean / law - 1):+.0f} %" for law in laws)
        rows.append(f"{fraction} | {' | '.join(cells)} | {mean:.3f} ± {error:.3f} | {compared}")
        print(rows[-1], flush=True)
    widths = " | ".join(f"{width} D, {starts} starts" for width, (starts, _) in _STARTS.items())
    by_fraction = table(f"φ | {widths} | U/U₀ | (1 − φ)^4.65 | deviation | (1 − φ)^5.6 | deviation", rows)
    settings = [(_CREEPING_DIAMETER, _CREEPING_TIME), *_OTHER_CREEPING]
    of_one = [creeping_velocity(0.2, 5, folder, 1, cells, time) for cells, time in settings]
    return by_fraction, table(
        "cells, τ | " + " | ".join(f"{cells}, {time:g}" for cells, time in settings),
        ["U/U₀ | " + " | ".join(f"{velocity:.4f}" for velocity in of_one)],
    )


def _faster(folder):
    """Table of two volume fractions at the larger Reynolds number."""
    rows, exponent = [], 4.45 * _FASTER**-0.1
    for fraction in (0.1, 0.2):
        velocity, error = settling_velocity(
            fraction, _FASTER_WIDTH, folder, travel=_FASTER_TRAVEL, reynolds=_FASTER, speed=0.04
        )
        law = (1 - fraction) ** exponent
        rows.append(f"{fraction} | {velocity:.3f} ± {error:.3f} | {law:.3f} | {100 * (velocity / law - 1):+.1f} %")
    return table("φ | U/U₀ | Richardson, Zaki | deviation", rows)


def fixed_array_velocity(fraction):
    """Velocity over that of a sphere alone, by the drag of random arrays of fixed spheres [Beetstra et al. 2007]."""
    alone, solid, void = standard_drag(_REYNOLDS), fraction, 1 - fraction
    found = 1.0
    for _ in range(100):
        re = _REYNOLDS * found
        inertial = 1 / void + 3 * solid * void + 8.4 * re**-0.343
        inertial /= 1 + 10 ** (3 * solid) * re ** (-0.5 - 2 * solid)
        drag = 10 * solid / void**2 + void**2 * (1 + 1.5 * solid**0.5) + 0.413 * re / (24 * void**2) * inertial
        found = 0.5 * (found + void * alone / drag)
    return found


def _random_places(count, width, seed=1, sweeps=0):
    """Centres of spheres that do not touch, in a periodic cube, one after the other; diameters, shape (count, 3).
    Then each moves at random, if it touches none there, `sweeps` times: to the equilibrium of hard spheres."""
    random, places = np.random.default_rng(seed), np.empty((0, 3))

    def is_free(place, others):
        apart = np.abs(others - place)
        apart = np.minimum(apart, width - apart)
        return (np.square(apart).sum(axis=1) > 1.02**2).all()

    while len(places) < count:
        place = random.uniform(0, width, 3)
        if is_free(place, places):
            places = np.vstack([places, place])
    for _ in range(sweeps):
        for i in range(count):
            place = (places[i] + random.uniform(-0.3, 0.3, 3)) % width
            if is_free(place, np.delete(places, i, axis=0)):
                places[i] = place
    return places


def settling(folder):
    turn = 0.1 * _REYNOLDS**0.9
    exponents = 4.45 * _REYNOLDS**-0.1, (5.1 + 2.7 * turn) / (1 + turn)
    fractions = list(_WIDTHS)
    found = [settling_velocity(fraction, width, folder) for fraction, width in _WIDTHS.items()]
    laws = [[(1 - fraction) ** exponent for fraction in fractions] for exponent in exponents]
    prefactor = math.exp(np.mean([math.log(velocity / law) for (velocity, _), law in zip(found, laws[0])]))
    laws.append([prefactor * law for law in laws[0]])
    off = [[100 * (velocity / value - 1) for (velocity, _), value in zip(found, law)] for law in laws]
    rows = []
    for i, (fraction, (velocity, error)) in enumerate(zip(fractions, found)):
        cells = [f"{law[i]:.3f} | {deviation[i]:+.1f} %" for law, deviation in zip(laws, off)]
        rows.append(f"{fraction} | {_WIDTHS[fraction]} D | {velocity:.3f} ± {error:.3f} | {' | '.join(cells)}")
        print(rows[-1], flush=True)
    by_width = {width: settling_velocity(0.1, width, folder) for width in sorted((_WIDTHS[0.1], *_OTHER_WIDTHS))}
    print(by_width)
    finer = table(
        "φ | " + " | ".join(f"{cells} cells" for cells in _FINER) + f" | {_FINER[0]} cells, no films",
        [
            f"{fraction} | " + " | ".join(f"{velocity:.4f}" for velocity in _at_the_start(fraction, folder))
            for fraction in (0.1, 0.2)
        ],
    )
    print(finer)
    wider = settling_velocity(0.05, _WIDER, folder, 6, _WIDER_TRAVEL)
    dense = settling_velocity(_DENSE[0], _DENSE[1], folder, travel=_DENSE[2])
    without_inertia, other_creeping = _without_inertia(folder)
    heads = "φ | cube | U/U₀ | Richardson, Zaki | deviation | Garside, Al-Dibouni | deviation | k (1 − φ)ⁿ | deviation"
    widths = table(
        "width | " + " | ".join(f"{width} D" for width in by_width),
        ["U/U₀ | " + " | ".join(f"{velocity:.3f} ± {error:.3f}" for velocity, error in by_width.values())],
    )
    return _SETTLING.format(
        table=table(heads, rows),
        widths="  " + widths.replace("\n", "\n  "),
        finer="  " + finer.replace("\n", "\n  "),
        wider=_WIDER,
        wider_travel=_WIDER_TRAVEL,
        in_wider=f"{wider[0]:.3f} ± {wider[1]:.3f}",
        faster=_FASTER,
        faster_width=_FASTER_WIDTH,
        faster_travel=_FASTER_TRAVEL,
        faster_n=f"{4.45 * _FASTER**-0.1:.2f}",
        faster_table="  " + _faster(folder).replace("\n", "\n  "),
        creeping=_CREEPING,
        without_inertia="  " + without_inertia.replace("\n", "\n  "),
        other_creeping="  " + other_creeping.replace("\n", "\n  "),
        dense=_DENSE,
        in_dense=f"{dense[0]:.3f} ± {dense[1]:.3f}",
        dense_law=prefactor * (1 - _DENSE[0]) ** exponents[0],
        start=_START,
        travel=_TRAVEL,
        blocks=_BLOCKS,
        n=[f"{exponent:.2f}" for exponent in exponents],
        k=f"{prefactor:.2f}",
        worst=f"{max(map(abs, off[2])):.1f}",
        misses=f"{-max(off[0]):.0f} to {-min(off[0]):.0f}",
        fixed=", ".join(f"{fixed_array_velocity(fraction):.2f}" for fraction in fractions),
    )


PARTS = {"rebound": rebounds, "tumbling": tumbling, "settling": settling}

_HEAD = """# Spheres that meet in a fluid

```sh
tests/validation/touching_spheres.py        # writes this page; 90 minutes by estimate
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
