"""Two equal three-sphere swimmers side by side: what one does to the other, over phase difference and distance."""

from typing import Any

import numpy as np

from copepod import Run
from copepod_report.style import LIGHT, describe, new_figure
from copepod_run.figures import markdown_table
from copepod_swimmers.runs import last_cycle, period_s, radii_m
from copepod_swimmers.theory import Stroke
from copepod_swimmers.three_spheres import Alone
from copepod_swimmers.triangle import turn_fraction

NAMES = ("left", "right")


def pair_of(run: Run) -> dict[str, float]:
    """The last cycle of swimmers that point along z, the right one on the positive side of x: `phase` of the right
    swimmer behind the left one [degrees], `distance` [m]; per cycle [m] `left` and `right` speeds, and `parting`, the
    change of the distance less what the tilt makes of the speed. The same from the measured strokes by integration has
    names in brackets."""
    rows = [run.cycles.loc[name].iloc[-1] for name in NAMES]
    beads = np.concatenate([last_cycle(run, name) for name in NAMES])
    pairs = ((0, 1), (1, 2), (3, 4), (4, 5))
    arms = np.array([np.linalg.norm(beads[j] - beads[i], axis=1) for i, j in pairs])
    moved = Stroke(beads[:, 0], radii_m(run), pairs, arms, ((0, 1, 2), (3, 4, 5))).motion()
    ways = (moved[1] - moved[0]).reshape(2, 3, 3).mean(axis=1)
    period = period_s(run, "right")
    found = {
        "phase": np.degrees(turn_fraction(rows[0]["arm1_phase_rad"] - rows[1]["arm1_phase_rad"])),
        "distance": rows[1]["x_m"] - rows[0]["x_m"],
    }
    sideways = []
    for name, row, way in zip(NAMES, rows, ways):
        axis = np.array(row[["axis_x", "axis_y", "axis_z"]])
        measured = row[["ux_m_per_s", "u_along_m_per_s"]] * period
        found |= {name: measured[1], f"({name})": way @ axis}
        sideways.append([across - along * axis[0] for across, along in (measured, (way[0], way @ axis))])
    return found | dict(zip(("parting", "(parting)"), np.diff(sideways, axis=0)[0]))


def changes(pairs: Any, alone: Alone) -> Any:
    """Speeds over those of a lone swimmer, less one, and partings in nm."""
    of_speeds = {name: pairs[name] / alone.measured - 1 for name in NAMES}
    of_theory = {f"({name})": pairs[f"({name})"] / alone.theory - 1 for name in NAMES}
    return pairs.assign(**of_speeds, **of_theory, **{name: 1e9 * pairs[name] for name in ("parting", "(parting)")})


def interaction(over_phase: Any, together: Any, opposed: Any, alone: Alone) -> Any:
    """Speeds relative to a lone swimmer and change of distance: dots measured, lines theory."""
    figure, (by_phase, by_distance) = new_figure(LIGHT, 6.0, nrows=2, ncols=2)
    _draw_phases(by_phase, changes(over_phase, alone).sort_values("phase"))
    _draw_distances(by_distance, changes(together, alone), changes(opposed, alone), alone)
    for panels, label in ((by_phase, "phase of the right swimmer [degrees]"), (by_distance, "distance d [cells]")):
        for panel in panels:
            describe(panel, legend={}, xlabel=label)
    return figure


def _draw_phases(panels: Any, pairs: Any) -> None:
    phases = pairs["phase"]
    for name, colour in zip(NAMES, LIGHT.beads):
        panels[0].plot(phases, 100 * pairs[f"({name})"], "-", color=colour)
        panels[0].plot(phases, 100 * pairs[name], "o", color=colour, markersize=4, label=name)
    panels[1].plot(phases, pairs["(parting)"], "-", color=LIGHT.beads[2], label="Rotne-Prager")
    panels[1].plot(phases, pairs["parting"], "o", color=LIGHT.ink, markersize=4, label="Copepod")
    panels[0].set_ylabel("change of speed [%]")
    panels[1].set_ylabel("change of distance [nm per cycle]")


def _draw_distances(panels: Any, together: Any, opposed: Any, alone: Alone) -> None:
    """Half the sum over both phases («dead», what a passive body would feel) and half the difference («live»)."""
    places = 1e6 * together["distance"]
    for panel, what in zip(panels, ("left", "parting")):
        for sign, name, colour in ((1, "dead", LIGHT.beads[0]), (-1, "live", LIGHT.beads[1])):
            part = abs(together + sign * opposed) / 2
            panel.loglog(places, part[f"({what})"], "-", color=colour)
            panel.loglog(places, part[what], "o", color=colour, markersize=4, label=name)
    # Two swimmers in the mean flow of each other's dipole p: −p/(4πηd²), from u = p (3 cos²θ − 1)/(8πηr²) at cos θ = 0.
    strength = alone.dipole_N_m * alone.period_s / (4 * np.pi * alone.viscosity_Pa_s)
    dipole = 1e9 * strength / together["distance"] ** 2
    panels[1].loglog(places, dipole, "--", color=LIGHT.ink, linewidth=1, label="mean dipole")
    panels[0].set_ylabel("|change of speed|, relative")
    panels[1].set_ylabel("|change of distance| [nm per cycle]")


def table(pairs: Any, alone: Alone) -> str:
    """Markdown: a row per run."""
    rows = [
        f"{1e6 * pair['distance']:.1f} | {abs(pair['phase']):.1f} | {1 + pair['left']:.4f}, {1 + pair['right']:.4f} | "
        f"{1 + pair['(left)']:.4f}, {1 + pair['(right)']:.4f} | {pair['parting']:.4f} | {pair['(parting)']:.4f}"
        for _, pair in changes(pairs, alone).iterrows()
    ]
    heads = "distance [cells] | phase [degrees] | speed of left, right over alone | theory"
    return markdown_table(f"{heads} | change of distance [nm per cycle] | theory", rows)
