"""Results over the swept keys: curves, and a map where two keys form a grid."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.cm import ScalarMappable

from copepod_report.run_record import RunRecord
from copepod_report.style import LIGHT, VIOLET_TO_YELLOW, colour_bar, legend_above, new_figure
from copepod_run.figures import FIGURES, MOST_TABLES, figures_by_name, number_text, prefix_of, swarm_rows
from copepod_run.names import quantity_of, short_keys

_TAKES_PREFIX = ("m", "s", "N", "Pa", "W", "J", "Hz")
_MOST_LABELS = 9


@dataclass(frozen=True)
class Axis:
    """A swept key: where its values are drawn, and what is written beside them."""

    label: str
    is_logarithmic: bool
    places: np.ndarray  # shape (runs,); of words their number
    words: Sequence[str]  # tick labels at 0, 1, …; empty for numbers
    heading: str  # the key without its unit
    unit: str

    def values(self) -> np.ndarray:
        """Distinct ones in rising order."""
        return np.unique(self.places)

    def text(self, place: float) -> str:
        """«amplitude 2 µN»."""
        value = self.words[int(place)] if self.words else number_text(float(place))
        return f"{self.heading} {value}{'' if self.unit == '°' else ' '}{self.unit}".strip()


@dataclass(frozen=True)
class Result:
    """A figure of every run of a sweep."""

    key: str
    heading: str  # with its unit
    values: np.ndarray  # shape (runs,), NaN where a run has none


@dataclass(frozen=True)
class SweepRecord:
    """The runs of one sweep."""

    name: str
    axes: Sequence[Axis]
    results: Sequence[Result]


def sweeps_of(runs: Sequence[RunRecord]) -> list[SweepRecord]:
    """Sweeps with two finished runs or more."""
    groups: dict[tuple[str, str], list[RunRecord]] = {}
    for run in runs:
        if run.sweep.values and run.status.is_finished:
            groups.setdefault((str(run.directory.parent), run.sweep.name), []).append(run)
    return [_read(name, members) for (_, name), members in groups.items() if len(members) > 1]


def _read(name: str, runs: Sequence[RunRecord]) -> SweepRecord:
    heads = short_keys(list(runs[0].sweep.values))
    axes = [
        _axis(head, runs[0].sweep.scales.get(key) == "logarithmic", [run.sweep.values.get(key) for run in runs])
        for key, head in heads.items()
    ]
    return SweepRecord(name, [axis for axis in axes if len(axis.values()) > 1], _results(runs))


def _axis(head: str, is_logarithmic: bool, values: Sequence[Any]) -> Axis:
    heading, unit = quantity_of(head)
    if all(isinstance(value, (int, float)) for value in values):
        numbers = np.array(values, float)
        factor, unit = with_prefix(numbers, unit)
        label = f"{heading} [{unit}]" if unit else heading
        return Axis(label, is_logarithmic, np.round(numbers * factor, 12), [], heading, unit)
    texts = [value if isinstance(value, str) else number_text(value) for value in values]
    words = list(dict.fromkeys(texts))
    return Axis(
        head.replace("_", " "), False, np.array([words.index(text) for text in texts], float), words, heading, ""
    )


def with_prefix(numbers: np.ndarray, unit: str) -> tuple[float, str]:
    """What to multiply numbers in an SI unit by for the largest to read well, and the unit then: (1e6, «µm»)."""
    largest = np.abs(numbers).max(initial=0.0)
    first = unit.split("/")[0].split(" ")[0]
    if not largest or not math.isfinite(largest) or first not in _TAKES_PREFIX or 1e-2 <= largest < 1e4:
        return 1.0, unit
    power, prefix = prefix_of(largest, -12, 9)
    return 10.0**-power, prefix + unit


def _results(runs: Sequence[RunRecord]) -> list[Result]:
    """Figures that differ among the runs, of every swimmer and group, and of a swarm together."""
    tables = [_figures_of(run) for run in runs]
    results = []
    for key, heading in {key: heading for table in tables for key, (heading, _) in table.items()}.items():
        values = np.array([table.get(key, ("", math.nan))[1] for table in tables], float)
        if np.isfinite(values).any() and np.nanmax(values) - np.nanmin(values) > 1e-9 * np.nanmax(np.abs(values)):
            results.append(Result(key, heading, values))
    return results


def _figures_of(run: RunRecord) -> dict[str, tuple[str, float]]:
    """Heading and value of each figure, by a key that may name a file."""
    found = {}
    entries = figures_by_name(run.summary)
    for swimmer, figures in entries if len(entries) <= MOST_TABLES else []:
        for key, figure in figures.items():
            heading = FIGURES[key] + (" [cells/step]" if key.endswith("_lattice") else "")
            name = key.removeprefix("kinematics.")
            if len(entries) > 1:
                name, heading = f"{swimmer}_{name}", f"{swimmer}: {heading}"
            if figure.ours is not None and key != "change_percent":  # it is about the others
                found[name] = (heading, float(figure.ours))
    for name, unit, value in swarm_rows(run.summary):
        found[f"swarm_{name}"] = (f"{name} [{unit}]" if unit else name, float(value))
    return found


def main_axes(sweep: SweepRecord) -> tuple[Axis, Sequence[Axis]]:
    """The axis that results are drawn over, numbers and many values first, and the others."""
    chosen = max(sweep.axes, key=lambda axis: (not axis.words, len(axis.values())))
    return chosen, [axis for axis in sweep.axes if axis is not chosen]


def curves(sweep: SweepRecord, result: Result) -> Any:
    """A result over one key, a curve for each combination of the others' values."""
    over, others = main_axes(sweep)
    if len(over.values()) == len(result.values):  # paired lists, or a single key
        others = []
    figure, axes = new_figure(LIGHT, 3.8)
    rows = list(zip(*(axis.places for axis in others))) or [()] * len(result.values)
    combinations = sorted(set(rows))
    for number, combination in enumerate(combinations):
        chosen = np.array([row == combination for row in rows])
        order = np.argsort(over.places[chosen])
        label = ", ".join(axis.text(place) for axis, place in zip(others, combination))
        colour = VIOLET_TO_YELLOW(number / (len(combinations) - 1)) if len(combinations) > 1 else LIGHT.beads[0]
        places, values = over.places[chosen][order], result.values[chosen][order]
        axes.plot(places, values, "o-", color=colour, linewidth=1.6, markersize=4.5, label=label)
    _dress(axes.xaxis, over)
    axes.set_ylabel(result.heading)
    if np.nanmin(result.values) < 0 < np.nanmax(result.values):
        axes.axhline(0, color=LIGHT.faint, linewidth=1)
    if 1 < len(combinations) <= _MOST_LABELS:
        legend_above(axes, LIGHT)
    elif len(combinations) > 1:
        _colour_bar(figure, axes, others, combinations)
    return figure


def _colour_bar(figure: Any, axes: Any, others: Sequence[Axis], combinations: Sequence[tuple[float, ...]]) -> None:
    """In place of a legend with too many lines: the first and the last curve are named."""
    bar = colour_bar(figure, ScalarMappable(cmap=VIOLET_TO_YELLOW), ax=axes, ticks=[0, 1])
    ends = [
        "\n".join(axis.text(place) for axis, place in zip(others, combination))
        for combination in (combinations[0], combinations[-1])
    ]
    bar.ax.set_yticklabels(ends, fontsize=8)
    bar.outline.set_visible(False)


def has_map(sweep: SweepRecord) -> bool:
    """Whether the members fill most of a grid of two keys."""
    sizes = [len(axis.values()) for axis in sweep.axes]
    members = list(zip(*(axis.places for axis in sweep.axes)))
    is_grid = len(sizes) == 2 and max(sizes) < len(members) == len(set(members))
    return is_grid and len(members) > math.prod(sizes) / 2


def colour_map(sweep: SweepRecord, result: Result) -> Any:
    """A result over both keys of a grid, a rectangle for each run; where it has both signs, zero is in the middle."""
    across, (upwards,) = main_axes(sweep)
    columns, rows = (np.searchsorted(axis.values(), axis.places) for axis in (across, upwards))
    values = np.full((len(upwards.values()), len(across.values())), math.nan)
    values[rows, columns] = result.values
    figure, axes = new_figure(LIGHT, 3.8)
    axes.grid(False)
    largest = np.nanmax(np.abs(values))
    both_signs = np.nanmin(values) < -1e-9 * largest and np.nanmax(values) > 1e-9 * largest
    look = {"cmap": "RdBu_r", "vmin": -largest, "vmax": largest} if both_signs else {"cmap": VIOLET_TO_YELLOW}
    drawn = axes.pcolormesh(_edges(across), _edges(upwards), values, **look)
    _dress(axes.xaxis, across)
    _dress(axes.yaxis, upwards)
    colour_bar(figure, drawn, result.heading, ax=axes).outline.set_visible(False)
    return figure


def _edges(axis: Axis) -> np.ndarray:
    """Of the rectangles around the values: half-way between neighbours, on the axis's scale."""
    values = np.log(axis.values()) if _is_logarithmic(axis) else axis.values()
    middles = (values[1:] + values[:-1]) / 2
    edges = np.concatenate([[2 * values[0] - middles[0]], middles, [2 * values[-1] - middles[-1]]])
    return np.exp(edges) if _is_logarithmic(axis) else edges


def _is_logarithmic(axis: Axis) -> bool:
    return axis.is_logarithmic and bool((axis.places > 0).all())


def _dress(axis_of_plot: Any, axis: Axis) -> None:
    """Label, scale and ticks."""
    name, scale = axis_of_plot.axis_name, "log" if _is_logarithmic(axis) else "linear"
    axis_of_plot.axes.set(**{f"{name}label": axis.label, f"{name}scale": scale})
    values = axis.values()
    if axis.words:
        axis_of_plot.set_ticks(range(len(axis.words)), axis.words)
    elif len(values) <= _MOST_LABELS and np.ptp(np.diff(values)) < 1e-6 * np.ptp(values):
        axis_of_plot.set_ticks(values, [number_text(float(value)) for value in values])


def caption(sweep: SweepRecord, result: Result, is_map: bool) -> str:
    """What a figure shows."""
    over, others = main_axes(sweep)
    if is_map:
        return f"{sweep.name}: {result.heading} over {over.heading} and {others[0].heading}."
    if not others:
        return f"{sweep.name}: {result.heading} over {over.heading}."
    if len(over.values()) == len(result.values):
        along = ", ".join(axis.heading for axis in others)
        return f"{sweep.name}: {result.heading} over {over.heading}, which varies together with {along}."
    curves_of = ", ".join(axis.heading for axis in others)
    return f"{sweep.name}: {result.heading} over {over.heading}, a curve for each value of {curves_of}."


def parameter_columns(runs: Sequence[RunRecord]) -> Mapping[str, str]:
    """Headings of all swept keys of the runs, by key."""
    return short_keys(list(dict.fromkeys(key for run in runs for key in run.sweep.values)))
