"""Two equal three-sphere swimmers side by side: what one does to the other, over phase difference and distance."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from copepod_report.style import Theme, new_figure
from copepod_run.figures import markdown_table
from copepod_swimmers.runs import Member
from copepod_swimmers.theory import Stroke
from copepod_swimmers.three_spheres import Bulk, bulk_of
from copepod_swimmers.triangle import turn_fraction

NAMES = ("left", "right")
STRAIGHT = ((0, 1, 2), (3, 4, 5))


@dataclass(frozen=True)
class Pair:
    """The last cycle of one run, and the same from the measured strokes by integration."""

    phase: float  # of the right swimmer behind the left one [rad]
    distance_m: float
    speeds: tuple[float, float]  # per cycle, of left and right [m]
    parting: float  # change of the distance in the cycle [m], less what the tilt makes of the speed
    theory_speeds: tuple[float, float]
    theory_parting: float


@dataclass(frozen=True)
class Alone:
    """What a swimmer without a neighbour does in a cycle, and the same from its stroke by integration."""

    measured: float  # [m]
    theory: float  # [m]
    bulk: Bulk

    def dipolar_parting(self, distance_m: float) -> float:
        """Change of the distance of two swimmers side by side, in the mean flow of each other's dipole, p: −p/(4πηd²).

        Far field, from u = p (3 cos²θ − 1)/(8πηr²) at cos θ = 0, twice; times the period [m].
        """
        bulk = self.bulk
        return -bulk.dipole_N_m / (4 * np.pi * bulk.viscosity_Pa_s * distance_m**2) * bulk.period_s


def alone_of(run: Member) -> Alone:
    """From a run of a swimmer called swimmer."""
    beads = run.last_cycle("swimmer")
    arms = np.linalg.norm(np.diff(beads, axis=0), axis=2)
    moved = Stroke(beads[:, 0], run.numbers("radius_m"), ((0, 1), (1, 2)), arms).motion()
    bulk = bulk_of(run, "swimmer")
    return Alone(bulk.speed_m_per_s * bulk.period_s, float(np.linalg.norm((moved[1] - moved[0]).mean(axis=0))), bulk)


def pair_of(run: Member) -> Pair:
    """From cycles.csv of swimmers that point along z, the right one on the positive side of x."""
    rows = []
    for name in NAMES:
        cycles = run.cycles(name)
        period_s = cycles["start_s"][1] - cycles["start_s"][0]
        rows.append({key: column[-1] for key, column in cycles.items()} | {"period_s": period_s})
    beads = np.concatenate([run.last_cycle(name) for name in NAMES])
    pairs = ((0, 1), (1, 2), (3, 4), (4, 5))
    arms = np.array([np.linalg.norm(beads[j] - beads[i], axis=1) for i, j in pairs])
    axes = np.array([[row[f"axis_{letter}"] for letter in "xyz"] for row in rows])
    stroke = Stroke(beads[:, 0], run.numbers("radius_m"), pairs, arms, STRAIGHT)
    moved = stroke.motion()
    ways = (moved[1] - moved[0]).reshape(2, 3, 3).mean(axis=1)
    speeds = np.sum(ways * axes, axis=1)
    sideways = ways[:, 0] - speeds * axes[:, 0]
    return Pair(
        turn_fraction(rows[0]["arm1_phase_rad"] - rows[1]["arm1_phase_rad"]),
        float(rows[1]["x_m"] - rows[0]["x_m"]),
        (rows[0]["u_along_m_per_s"] * period_s, rows[1]["u_along_m_per_s"] * period_s),
        (_sideways(rows[1]) - _sideways(rows[0])) * period_s,
        (float(speeds[0]), float(speeds[1])),
        float(sideways[1] - sideways[0]),
    )


def _sideways(row: dict[str, float]) -> float:
    """Velocity along x across the swimmer's own axis at the start of the cycle [m/s]: swimmers side by side tilt."""
    return row["ux_m_per_s"] - row["u_along_m_per_s"] * row["axis_x"]


def interaction(
    over_phase: Sequence[Pair], together: Sequence[Pair], opposed: Sequence[Pair], alone: Alone, theme: Theme
) -> Any:
    """Speeds relative to a lone swimmer and change of distance: dots measured, lines theory."""
    figure, (by_phase, by_distance) = new_figure(theme, 6.0, nrows=2, ncols=2)
    _draw_phases(by_phase, over_phase, alone, theme)
    _draw_distances(by_distance, together, opposed, alone, theme)
    for panels, label in ((by_phase, "phase of the right swimmer [degrees]"), (by_distance, "distance d [cells]")):
        for panel in panels:
            panel.set_xlabel(label)
            panel.legend(fontsize=8, labelcolor=theme.ink, frameon=False)
    return figure


def _draw_phases(panels: Sequence[Any], pairs: Sequence[Pair], alone: Alone, theme: Theme) -> None:
    speed, parting = panels
    pairs = sorted(pairs, key=lambda pair: pair.phase)
    phases = np.degrees([pair.phase for pair in pairs])
    for side, name in enumerate(NAMES):
        colour = theme.beads[side]
        speed.plot(phases, [100 * (pair.theory_speeds[side] / alone.theory - 1) for pair in pairs], "-", color=colour)
        ours = [100 * (pair.speeds[side] / alone.measured - 1) for pair in pairs]
        speed.plot(phases, ours, "o", color=colour, markersize=4, label=name)
    parting.plot(phases, [1e9 * pair.theory_parting for pair in pairs], "-", color=theme.beads[2], label="Rotne-Prager")
    parting.plot(phases, [1e9 * pair.parting for pair in pairs], "o", color=theme.ink, markersize=4, label="Copepod")
    speed.set_ylabel("change of speed [%]")
    parting.set_ylabel("change of distance [nm per cycle]")


def _draw_distances(
    panels: Sequence[Any], together: Sequence[Pair], opposed: Sequence[Pair], alone: Alone, theme: Theme
) -> None:
    """Half the sum over both phases («dead», what a passive body would feel) and half the difference («live»)."""
    speed, parting = panels
    for sign, name, colour in ((1, "dead", theme.beads[0]), (-1, "live", theme.beads[1])):
        pairs = list(zip(together, opposed))
        places = 1e6 * np.array([one.distance_m for one, _ in pairs])
        for panel, ours, theirs in (
            (
                speed,
                [
                    one.speeds[0] / alone.measured - 1 + sign * (two.speeds[0] / alone.measured - 1)
                    for one, two in pairs
                ],
                [
                    one.theory_speeds[0] / alone.theory - 1 + sign * (two.theory_speeds[0] / alone.theory - 1)
                    for one, two in pairs
                ],
            ),
            (
                parting,
                [1e9 * (one.parting + sign * two.parting) for one, two in pairs],
                [1e9 * (one.theory_parting + sign * two.theory_parting) for one, two in pairs],
            ),
        ):
            panel.loglog(places, np.abs(theirs) / 2, "-", color=colour)
            panel.loglog(places, np.abs(ours) / 2, "o", color=colour, markersize=4, label=name)
    places = np.array([pair.distance_m for pair in together])
    dipole = [1e9 * abs(alone.dipolar_parting(place)) for place in places]
    parting.loglog(1e6 * places, dipole, "--", color=theme.ink, linewidth=1, label="mean dipole")
    speed.set_ylabel("|change of speed|, relative")
    parting.set_ylabel("|change of distance| [nm per cycle]")


def table(pairs: Sequence[Pair], alone: Alone) -> str:
    """Markdown: a row per run."""
    rows = []
    for pair in pairs:
        ours = ", ".join(f"{speed / alone.measured:.4f}" for speed in pair.speeds)
        theirs = ", ".join(f"{speed / alone.theory:.4f}" for speed in pair.theory_speeds)
        rows.append(
            f"{1e6 * pair.distance_m:.1f} | {abs(np.degrees(pair.phase)):.1f} | {ours} | {theirs} | "
            f"{1e9 * pair.parting:.4f} | {1e9 * pair.theory_parting:.4f}"
        )
    heads = "distance [cells] | phase [degrees] | speed of left, right over alone | theory"
    return markdown_table(f"{heads} | change of distance [nm per cycle] | theory", rows)
