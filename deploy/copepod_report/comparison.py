"""Several runs beside each other: one table, results over swept keys, or one plot of the swimming speeds."""

from collections.abc import Callable, Sequence
from typing import Any

from copepod_report import sweeps
from copepod_report.run_record import RunResult
from copepod_report.style import LIGHT, WIDTH_INCHES, legend_above, new_figure
from copepod_run.figures import FIGURES, Figure, figures_by_name, number_text, percent_text

Draw = Callable[..., list[str]]
Row = tuple[int, str, dict[str, Figure]]  # number of the run, swimmer name, figures by key


def comparison_rows(runs: Sequence[RunResult]) -> list[Row]:
    """A row for every swimmer and group, or one for a run without any."""
    return [
        (number, name, figures)
        for number, run in enumerate(runs)
        for name, figures in figures_by_name(run.summary) or [("", {})]
    ]


def comparison_columns(rows: Sequence[Row]) -> list[tuple[str, str]]:
    """(key, heading) of the columns that any row fills, in the paper's order."""
    return [(key, heading) for key, heading in FIGURES.items() if any(key in cells for _, _, cells in rows)]


def cell_texts(figure: Figure) -> tuple[str, ...]:
    """Ours, the published figure and the deviation from it: «9.12e-06», «9.05e-06», «+0.8 %»; or ours only."""
    if figure.published is None:
        return (number_text(figure.ours),)
    return number_text(figure.ours), number_text(figure.published), percent_text(figure.deviation_percent)


def speeds(runs: Sequence[RunResult]) -> Any:
    """Swimming speed of every run, ours and the published one, or None if no run was analysed."""
    rows = [
        (runs[number].name, cells["u_swim_lattice"].ours, cells["u_swim_lattice"].published)
        for number, _, cells in comparison_rows(runs)
        if "u_swim_lattice" in cells
    ]
    if not rows:
        return None
    figure, axes = new_figure(LIGHT, 1.2 + 0.3 * len(rows))
    places = range(len(rows), 0, -1)
    axes.hlines(places, 0, [ours for _, ours, _ in rows], color=LIGHT.faint, linewidth=2)
    axes.plot([ours for _, ours, _ in rows], places, "o", color=LIGHT.beads[0], markersize=8, label="this run")
    published = [(value, place) for (_, _, value), place in zip(rows, places) if value is not None]
    if published:
        axes.plot(
            *zip(*published),
            "o",
            markerfacecolor="none",
            markeredgecolor=LIGHT.beads[1],
            markeredgewidth=1.6,
            markersize=11,
            label="published",
        )
    axes.set_yticks(list(places), [name for name, _, _ in rows])
    axes.grid(axis="y", visible=False)
    axes.set(ylim=(0.4, len(rows) + 0.6), xlabel="u_swim [cells/step]")
    legend_above(axes, LIGHT)
    return figure


def first_figures(runs: Sequence[RunResult], draw: Draw, choice: sweeps.Choice) -> list[str]:
    """HTML of the figure that answers each sweep. `draw(name, figure, caption, …)` writes a figure."""
    figures = []
    for sweep in sweeps.sweeps_of(runs, choice):
        for result in sweep.results[:1] if sweep.axes else []:
            figure, narrow = sweeps.curves(sweep, result, WIDTH_INCHES), sweeps.curves(sweep, result)
            text, table = sweeps.caption(sweep, result, is_map=False), sweeps.values_csv(sweep, result)
            figures += draw(f"{sweep.name}_{result.key}", figure, text, wide=True, narrow=narrow, table=table)
    return figures


def other_figures(runs: Sequence[RunResult], draw: Draw, choice: sweeps.Choice) -> list[str]:
    """HTML of every other result that varies over the swept keys, as curves, and of all of them as maps where two keys
    form a grid."""
    others, maps = [], []
    for sweep in sweeps.sweeps_of(runs, choice):
        for result in sweep.results if sweep.axes else []:
            name, text = f"{sweep.name}_{result.key}", sweeps.caption(sweep, result, is_map=False)
            if result is not sweep.results[0]:
                others += draw(name, sweeps.curves(sweep, result), text, table=sweeps.values_csv(sweep, result))
            if sweeps.has_map(sweep):
                text = sweeps.caption(sweep, result, is_map=True)
                maps += draw(f"{name}_map", sweeps.colour_map(sweep, result), text)
    return others + maps
