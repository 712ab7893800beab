"""A three-sphere swimmer near a no-slip wall: its turning over the height, and its path."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from copepod import Run
from copepod_report.style import LIGHT, describe, new_figure
from copepod_run.figures import markdown_table
from copepod_swimmers.runs import radii_m
from copepod_swimmers.theory import Stroke, turning_at_a_wall
from copepod_swimmers.three_spheres import ROW, Alone


def turning_of(towards: Run, away: Run, alone: Alone) -> dict[str, float]:
    """Change of the pitch in the last cycles of two runs at the same height, of a swimmer that points towards the wall
    and away from it [rad].

    The flow of a dipole's images turns both by opposite angles: half their difference is `odd`, half their sum `even`.
    Beside them the same from the measured strokes, with Blake's images, and for `odd` the far field of the dipole.
    """
    rows = [run.cycles.loc["swimmer"].iloc[-1] for run in (towards, away)]
    height, tilts = np.mean([row["z_m"] for row in rows]), np.arcsin([row["axis_z"] for row in rows])
    measured = np.array([-row["rotation_y_rad"] for row in rows])
    integrated = np.array([_integrated(run, row) for run, row in zip((towards, away), rows)])
    turning = turning_at_a_wall(alone.dipole_N_m, height, np.diff(tilts)[0] / 2, alone.viscosity_Pa_s)
    return {
        "height": height,
        "odd": np.diff(measured)[0] / 2,
        "even": measured.mean(),
        "far field": turning * alone.period_s,
        "(odd)": np.diff(integrated)[0] / 2,
        "(even)": integrated.mean(),
    }


def _integrated(run: Run, row: Any) -> float:
    phase = 2 * np.pi * np.arange(64) / 64  # of the fits of a row of cycles.csv
    arms = [
        row[f"{arm}_mean_m"] + row[f"{arm}_amplitude_m"] * np.cos(phase + row[f"{arm}_phase_rad"])
        for arm in ("arm0", "arm1")
    ]
    along = np.concatenate([[0.0], np.cumsum([arm[0] for arm in arms])])
    axis = [row[f"axis_{letter}"] for letter in "xyz"]
    places = np.outer(along - along.mean(), axis) + [row["x_m"], row["y_m"], row["z_m"]]
    stroke = Stroke(places, radii_m(run), ROW, np.array(arms), straight=((0, 1, 2),), wall=True)
    ends = [place[2] - place[0] for place in stroke.motion(parts=48)]
    return float(np.diff([np.arctan2(end[2], end[0]) for end in ends])[0])


def approach(turnings: Any, paths: Mapping[str, Run], length_m: float) -> Any:
    """Left: turning per cycle over height, dots measured, lines theory. Right: paths, the swimmer every 300 cycles."""
    figure, (rate, path) = new_figure(LIGHT, 3.6, ncols=2)
    heights, sizes = 1e6 * turnings["height"], abs(turnings)
    rate.loglog(heights, sizes["far field"], "--", color=LIGHT.ink, linewidth=1, label="far field of the dipole")
    for name, colour in zip(("odd", "even"), LIGHT.beads):
        rate.loglog(heights, sizes[f"({name})"], "-", color=colour)
        rate.loglog(heights, sizes[name], "o", color=colour, markersize=4, label=f"{name} in the pitch")
    for (name, run), colour in zip(paths.items(), LIGHT.beads):
        cycles = run.cycles.loc["swimmer"]
        path.plot(1e6 * cycles["x_m"], 1e6 * cycles["z_m"], color=colour, linewidth=1.2, label=name)
        for _, cycle in cycles[::300].iterrows():
            ends = 1e6 * length_m / 2 * np.array([-1, 1])
            x, z = (1e6 * cycle[f"{axis}_m"] + ends * cycle[f"axis_{axis}"] for axis in "xz")
            path.plot(x, z, "-", color=colour, linewidth=3, alpha=0.5, solid_capstyle="round")
    path.set_ylim(bottom=0)
    describe(rate, legend={}, xlabel="height h [cells]", ylabel="|turning| [rad per cycle]")
    describe(path, legend={}, xlabel="x [cells]", ylabel="height h [cells]")
    return figure


def table(turnings: Any, length_m: float) -> str:
    """Markdown: a row per height."""
    rows = [
        f"{one['height'] / length_m:.2f} | {one['odd']:.3e} | {one['odd'] / one['far field']:.3f} | "
        f"{one['odd'] / one['(odd)']:.3f} | {one['even']:.3e} | {one['even'] / one['(even)']:.3f}"
        for _, one in turnings.iterrows()
    ]
    heads = "h/L | odd part [rad per cycle] | over the dipole's far field | over theory with images | even part"
    return markdown_table(f"{heads} | over theory with images", rows)
