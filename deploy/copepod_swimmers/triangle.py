"""A triangle of three beads and three driven arms: its rotation over the square of the stroke and over its phases."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from copepod_report.style import Theme, new_figure
from copepod_run.figures import markdown_table
from copepod_swimmers.runs import Member
from copepod_swimmers.theory import Stroke, rotation_about_z, triangle_rotation

LABELS = ("small strokes, small spheres", "Rotne-Prager")


@dataclass(frozen=True)
class Turn:
    """The last cycle of one run; angles in radians per cycle."""

    measured: float
    theory: tuple[float, float]  # as in LABELS
    stroke_squared: float  # mean of (ε/L)² over the arms
    phase: float  # by which the second arm follows the first [rad], in [0, 2π)
    drift: float  # of the centroid in the cycle, per side


def turn_of(run: Member) -> Turn:
    """The swimmer's arms run around the triangle in the order of its beads."""
    cycles = run.cycles("triangle")
    last = {key: column[-1] for key, column in cycles.items()}
    beads = run.last_cycle("triangle")
    arms = np.linalg.norm(np.roll(beads, -1, axis=0) - beads, axis=2)
    side = arms.mean()
    moved = Stroke(beads[:, 0], run.numbers("radius_m"), ((0, 1), (1, 2), (2, 0)), arms).motion()
    velocity = np.array([last[f"u{axis}_m_per_s"] for axis in "xyz"])
    return Turn(
        last["rotation_z_rad"],
        (triangle_rotation(arms, 1.0), rotation_about_z(moved[0], moved[1])),
        float(np.mean([(last[f"arm{arm}_amplitude_m"] / side) ** 2 for arm in range(3)])),
        turn_fraction(last["arm0_phase_rad"] - last["arm1_phase_rad"]),
        float(np.linalg.norm(velocity) * (cycles["start_s"][1] - cycles["start_s"][0]) / side),
    )


def turn_fraction(angle: float) -> float:
    """The angle in one turn that starts just below zero, so that nothing is not mistaken for a whole turn [rad]."""
    return float((angle + 0.1) % (2 * np.pi) - 0.1)


def rotation(over_stroke: Sequence[Turn], over_phase: Sequence[Turn], theme: Theme) -> Any:
    """Angle per cycle: dots measured, lines theory."""
    figure, panels = new_figure(theme, 3.4, ncols=2)
    degrees = 180 / np.pi
    over_stroke = sorted(over_stroke, key=lambda turn: turn.stroke_squared)
    over_phase = sorted(over_phase, key=lambda turn: turn.phase)
    for panel, turns, place in (
        (panels[0], over_stroke, [turn.stroke_squared for turn in over_stroke]),
        (panels[1], over_phase, [degrees * turn.phase for turn in over_phase]),
    ):
        for number, (label, style) in enumerate(zip(LABELS, ("-", ":"))):
            values = [degrees * turn.theory[number] for turn in turns]
            panel.plot(place, values, style, color=theme.beads[2 * number], linewidth=1.4, label=label)
        measured = [degrees * turn.measured for turn in turns]
        panel.plot(place, measured, "o", color=theme.ink, markersize=4, label="Copepod")
    panels[0].set_xlabel("(ε/L)²")
    panels[0].set_ylabel("rotation [degrees per cycle]")
    panels[0].legend(loc="upper left", fontsize=8, labelcolor=theme.ink, frameon=False)
    panels[1].set_xlabel("phase between neighbouring arms [degrees]")
    return figure


def table(turns: Sequence[Turn]) -> str:
    """Markdown: a row per run."""
    rows = []
    for turn in turns:
        turns_round = abs(turn.measured) > 1e-2 * max(abs(other.measured) for other in turns)
        ratios = [f"{turn.measured / theory:.4f}" if turns_round else "–" for theory in turn.theory]
        rows.append(
            f"{abs(np.degrees(turn.phase)):.1f} | {np.sqrt(turn.stroke_squared):.4f} | "
            f"{np.degrees(turn.measured):.5f} | {ratios[0]} | {ratios[1]} | {turn.drift:.1e}"
        )
    heads = "phase [degrees] | ε/L | rotation [degrees per cycle] | over small strokes and spheres | over Rotne-Prager"
    return markdown_table(f"{heads} | drift per side and cycle", rows)
