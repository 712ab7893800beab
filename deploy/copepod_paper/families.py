"""The paper's designs by family: what is changed from one to the next."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from copepod_report.run_record import RunResult
from copepod_report.style import Theme, describe, new_figure

FAMILIES = (
    ("parallel capsules", "abcdef"),
    ("perpendicular capsules, wider gaps", "aghijk"),
    ("perpendicular capsules", "almnop"),
    ("big spheres", "q"),
)


def speeds_by_family(runs: Sequence[RunResult], theme: Theme) -> Any:
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
    widths = [len(letters) for _, letters in FAMILIES]
    figure, panels = new_figure(
        theme, 3.4, ncols=len(FAMILIES), sharey=True, width_ratios=[width + 1 for width in widths]
    )
    for panel, (title, letters) in zip(panels, FAMILIES):
        for column, look in enumerate(
            ({"label": "Copepod", "markersize": 6}, {"label": "published", "markersize": 9, "markerfacecolor": "none"})
        ):
            values = [(place, speeds[letter][column]) for place, letter in enumerate(letters) if letter in speeds]
            points = np.reshape([(place, 1e6 * value) for place, value in values if value is not None], (-1, 2))
            panel.plot(*points.T, "o", color=theme.beads[column], markeredgewidth=1.5, **look)
        panel.set_xticks(range(len(letters)), list(letters))
        panel.set_xlim(-0.7, len(letters) - 0.3)
        panel.set_title(title.replace(", ", ",\n"), fontsize=9, color=theme.ink, wrap=True)
    panels[0].set_ylim(bottom=0)
    describe(panels[0], legend={"loc": "lower left"}, ylabel="u_swim [10⁻⁶ cells/step]")
    return figure
