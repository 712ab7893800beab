"""A three-sphere swimmer near a no-slip wall: its turning over the height, and its path."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from copepod_report.style import Theme, new_figure
from copepod_run.figures import markdown_table
from copepod_swimmers.runs import Member
from copepod_swimmers.theory import Stroke, dipole_at_a_wall
from copepod_swimmers.three_spheres import Bulk


@dataclass(frozen=True)
class Turning:
    """Change of the pitch in a cycle, at one height, of a swimmer that points away from the wall and towards it [rad].

    The flow of a dipole's images turns both by opposite angles: half their difference is `odd`, half their sum `even`.
    """

    height_m: float
    odd: float
    even: float
    far_field: float  # of the dipole; to be compared with `odd`
    integrated: tuple[float, float]  # odd and even from the measured strokes, with Blake's images


def turning_of(towards: Member, away: Member, bulk: Bulk) -> Turning:
    """From the last cycles of two runs at the same height and with opposite pitch."""
    rows = [{key: column[-1] for key, column in run.cycles("swimmer").items()} for run in (towards, away)]
    measured = [-row["rotation_y_rad"] for row in rows]
    integrated = [_integrated(run, row) for run, row in zip((towards, away), rows)]
    height = (rows[0]["z_m"] + rows[1]["z_m"]) / 2
    pitch = (np.arcsin(rows[1]["axis_z"]) - np.arcsin(rows[0]["axis_z"])) / 2
    far_field = dipole_at_a_wall(bulk.dipole_N_m, height, pitch, bulk.viscosity_Pa_s).pitch * bulk.period_s
    return Turning(float(height), *_parts(measured), far_field, _parts(integrated))


def _parts(angles: Sequence[float]) -> tuple[float, float]:
    towards, away = angles
    return float(away - towards) / 2, float(away + towards) / 2


def _integrated(run: Member, row: dict[str, float]) -> float:
    arms = _arms_of(row, 2)
    along = np.concatenate([[0.0], np.cumsum(arms[:, 0])])
    axis = np.array([row[f"axis_{letter}"] for letter in "xyz"])
    places = np.outer(along - along.mean(), axis) + [row["x_m"], row["y_m"], row["z_m"]]
    stroke = Stroke(places, run.numbers("radius_m"), ((0, 1), (1, 2)), arms, straight=((0, 1, 2),), wall=True)
    ends = [place[2] - place[0] for place in stroke.motion(parts=48)]
    return float(np.diff([np.arctan2(end[2], end[0]) for end in ends])[0])


def _arms_of(row: dict[str, float], number: int) -> np.ndarray:
    """Lengths over one period from the fits of a row of cycles.csv, shape (number, 64) [m]."""
    phase = 2 * np.pi * np.arange(64) / 64
    return np.array(
        [
            row[f"arm{arm}_mean_m"] + row[f"arm{arm}_amplitude_m"] * np.cos(phase + row[f"arm{arm}_phase_rad"])
            for arm in range(number)
        ]
    )


def approach(turnings: Sequence[Turning], paths: Sequence[tuple[str, Member]], bulk: Bulk, theme: Theme) -> Any:
    """Left: turning per cycle over height, dots measured, lines theory. Right: paths, the swimmer every 300 cycles."""
    figure, (rate, path) = new_figure(theme, 3.6, ncols=2)
    heights = [1e6 * turning.height_m for turning in turnings]
    far_field = [abs(turning.far_field) for turning in turnings]
    rate.loglog(heights, far_field, "--", color=theme.ink, linewidth=1, label="far field of the dipole")
    for number, name in enumerate(("odd", "even")):
        colour = theme.beads[number]
        rate.loglog(heights, [abs(turning.integrated[number]) for turning in turnings], "-", color=colour)
        measured = [abs(getattr(turning, name)) for turning in turnings]
        rate.loglog(heights, measured, "o", color=colour, markersize=4, label=f"{name} in the pitch")
    rate.set_xlabel("height h [cells]")
    rate.set_ylabel("|turning| [rad per cycle]")
    for (name, run), colour in zip(paths, theme.beads):
        cycles = run.cycles("swimmer")
        path.plot(1e6 * cycles["x_m"], 1e6 * cycles["z_m"], color=colour, linewidth=1.2, label=name)
        for cycle in range(0, len(cycles["x_m"]), 300):
            ends = 1e6 * bulk.length_m / 2 * np.array([-1, 1])
            x, z = (1e6 * cycles[f"{axis}_m"][cycle] + ends * cycles[f"axis_{axis}"][cycle] for axis in "xz")
            path.plot(x, z, "-", color=colour, linewidth=3, alpha=0.5, solid_capstyle="round")
    path.set_xlabel("x [cells]")
    path.set_ylabel("height h [cells]")
    path.set_ylim(bottom=0)
    for panel in (rate, path):
        panel.legend(fontsize=8, labelcolor=theme.ink, frameon=False)
    return figure


def table(turnings: Sequence[Turning], bulk: Bulk) -> str:
    """Markdown: a row per height."""
    rows = (
        f"{turning.height_m / bulk.length_m:.2f} | {turning.odd:.3e} | {turning.odd / turning.far_field:.3f} | "
        f"{turning.odd / turning.integrated[0]:.3f} | {turning.even:.3e} | {turning.even / turning.integrated[1]:.3f}"
        for turning in turnings
    )
    heads = "h/L | odd part [rad per cycle] | over the dipole's far field | over theory with images | even part"
    return markdown_table(f"{heads} | over theory with images", rows)
