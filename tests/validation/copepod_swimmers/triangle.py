"""A triangle of three beads and three driven arms: its rotation over the square of the stroke and over its phases."""

from typing import Any

import numpy as np

from copepod import Run
from copepod_report.style import LIGHT, describe, new_figure
from copepod_run.figures import markdown_table
from copepod_swimmers.runs import last_cycle, period_s, radii_m, turn_fraction
from copepod_swimmers.theory import Stroke, rotation_about_z, triangle_rotation

LABELS = ("small strokes, small spheres", "Rotne-Prager")


def turn_of(run: Run) -> dict[str, float]:
    """The last cycle of one run, whose arms run around the triangle in the order of its beads: angles per cycle
    [degrees], measured and by LABELS of theory; mean of (ε/L)² over the arms; by what phase the second arm follows the
    first; drift of the centroid per side."""
    last, beads = run.cycles.loc["triangle"].iloc[-1], last_cycle(run, "triangle")
    arms = np.linalg.norm(np.roll(beads, -1, axis=0) - beads, axis=2)
    side = arms.mean()
    moved = Stroke(beads[:, 0], radii_m(run), ((0, 1), (1, 2), (2, 0)), arms).motion()
    theory = (triangle_rotation(arms, 1.0), rotation_about_z(moved[0], moved[1]))
    velocity = [last[f"u{axis}_m_per_s"] for axis in "xyz"]
    return {
        "measured": np.degrees(last["rotation_z_rad"]),
        "stroke_squared": np.mean([(last[f"arm{arm}_amplitude_m"] / side) ** 2 for arm in range(3)]),
        "phase": np.degrees(turn_fraction(last["arm0_phase_rad"] - last["arm1_phase_rad"])),
        "drift": np.linalg.norm(velocity) * period_s(run, "triangle") / side,
        **dict(zip(LABELS, np.degrees(theory))),
    }


def rotation(over_stroke: Any, over_phase: Any) -> Any:
    """Angle per cycle: dots measured, lines theory."""
    figure, panels = new_figure(3.4, ncols=2)
    for panel, turns, varied in zip(panels, (over_stroke, over_phase), ("stroke_squared", "phase")):
        turns = turns.sort_values(varied)
        for label, style, colour in zip(LABELS, ("-", ":"), LIGHT.beads[::2]):
            panel.plot(turns[varied], turns[label], style, color=colour, linewidth=1.4, label=label)
        panel.plot(turns[varied], turns["measured"], "o", color=LIGHT.ink, markersize=4, label="Copepod")
    describe(panels[0], legend={"loc": "upper left"}, xlabel="(ε/L)²", ylabel="rotation [degrees per cycle]")
    describe(panels[1], xlabel="phase between neighbouring arms [degrees]")
    return figure


def table(turns: Any) -> str:
    """Markdown: a row per run."""
    turning = turns.where(abs(turns["measured"]) > 1e-2 * abs(turns["measured"]).max())
    rows = [
        f"{abs(turn.phase):.1f} | {np.sqrt(turn.stroke_squared):.4f} | {turn.measured:.5f} | "
        f"{' | '.join(f'{ratio:.4f}' for ratio in ratios)} | {turn.drift:.1e}"
        for turn, *ratios in zip(turns.itertuples(), *(turning["measured"] / turning[label] for label in LABELS))
    ]
    heads = "phase [degrees] | ε/L | rotation [degrees per cycle] | over small strokes and spheres | over Rotne-Prager"
    return markdown_table(f"{heads} | drift per side and cycle", rows).replace("nan", "–")
