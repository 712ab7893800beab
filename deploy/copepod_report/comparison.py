"""Several runs beside each other: one table, one plot of the swimming speeds."""

from copepod_command.figures import number_text
from copepod_command.table import swimmer_rows
from copepod_report.style import new_figure

_COLUMNS = (
    "swimming speed u_swim",
    "theory u_GA (Golestanian, Ajdari)",
    "difference to theory",
    "efficiency",
    "geometry factor K",
    "amplitude of arm 1, d1",
    "amplitude of arm 2, d2",
    "sin(phi1 - phi2)",
    "Re of the swimmer",
    "Re of B2, trailing",
    "Re of B1, middle",
    "Re of B3, leading",
)


def comparison_rows(runs):
    """(run name, swimmer name, {column: (ours, published or None, deviation in percent or None)}) of every swimmer."""
    rows = []
    for run in runs:
        for swimmer in run.swimmers():
            cells = {}
            for name, unit, value, others in swimmer_rows(swimmer.figures):
                if name in _COLUMNS:
                    published = others.get("published")
                    deviation = 100 * (value / published - 1) if published else None
                    cells[name] = (value, published, deviation)
            rows.append((run.name, swimmer.name, cells))
    return rows


def comparison_columns(rows):
    """The columns that any row fills, in the paper's order."""
    return [name for name in _COLUMNS if any(name in cells for _, _, cells in rows)]


def cell_text(cell):
    """«9.12e-06», «published 9.05e-06, +0.8 %»; the second part may be empty."""
    ours, published, deviation = cell
    beside = "" if published is None else f"published {number_text(published)}, {deviation:+.1f} %"
    return number_text(ours), beside


def speeds(runs, theme):
    """Swimming speed of every run, ours and the published one, or None if no run was analysed."""
    rows = [
        (name, cells["swimming speed u_swim"])
        for name, _, cells in comparison_rows(runs)
        if "swimming speed u_swim" in cells
    ]
    if not rows:
        return None
    figure, axes = new_figure(theme, 1.2 + 0.3 * len(rows))
    places = range(len(rows), 0, -1)
    axes.hlines(places, 0, [ours for _, (ours, _, _) in rows], color=theme.faint, linewidth=2)
    axes.plot([ours for _, (ours, _, _) in rows], places, "o", color=theme.beads[0], markersize=8, label="this run")
    published = [(value, place) for (_, (_, value, _)), place in zip(rows, places) if value is not None]
    if published:
        axes.plot(
            *zip(*published),
            "o",
            markerfacecolor="none",
            markeredgecolor=theme.beads[1],
            markeredgewidth=1.6,
            markersize=11,
            label="published",
        )
    axes.set_yticks(list(places), [name for name, _ in rows])
    axes.grid(axis="y", visible=False)
    axes.set_ylim(0.4, len(rows) + 0.6)
    axes.set_xlabel("u_swim [cells/step]")
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2, fontsize=9, labelcolor=theme.ink, frameon=False)
    return figure
