"""What a report adds for the runs of the paper: its designs by family."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from copepod_report.run_record import RunResult
from copepod_report.style import LIGHT, describe, new_figure

# The designs by family: what is changed from one to the next.
FAMILIES = (
    ("parallel capsules", "abcdef"),
    ("perpendicular capsules, wider gaps", "aghijk"),
    ("perpendicular capsules", "almnop"),
    ("big spheres", "q"),
)


def speeds_by_family(runs: Sequence[RunResult]) -> Any:
    """Swimming speed of every design, ours and published, a panel per family; None unless there are several designs."""
    speeds: dict[str, tuple[float, float | None]] = {}
    for run in runs:
        name = run.summary["case"]
        figures = run.summary.get("swimmers") or []
        if name.startswith("design_") and figures and figures[0].get("u_swim_lattice"):
            published = (figures[0].get("published") or {}).get("u_swim_lattice")
            speeds[name.removeprefix("design_")] = (figures[0]["u_swim_lattice"], published)
    if len(speeds) < 2:
        return None
    widths = [len(letters) + 1 for _, letters in FAMILIES]
    looks = {"label": "Copepod", "markersize": 6}, {"label": "published", "markersize": 9, "markerfacecolor": "none"}
    figure, panels = new_figure(3.4, ncols=len(FAMILIES), sharey=True, width_ratios=widths)
    for panel, (title, letters) in zip(panels, FAMILIES):
        values = 1e6 * np.array([speeds.get(letter, (None, None)) for letter in letters], float)
        for of_all, colour, look in zip(values.T, LIGHT.beads, looks):
            panel.plot(of_all, "o", color=colour, markeredgewidth=1.5, **look)
        panel.set_xticks(range(len(letters)), list(letters))
        panel.set_xlim(-0.7, len(letters) - 0.3)
        panel.set_title(title.replace(", ", ",\n"), fontsize=9, color=LIGHT.ink, wrap=True)
    panels[0].set_ylim(bottom=0)
    describe(panels[0], legend={"loc": "lower left"}, ylabel="u_swim [10⁻⁶ cells/step]")
    return figure
