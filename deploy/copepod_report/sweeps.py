"""Results over the swept keys: curves, and a map where two keys form a grid."""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.ticker import Formatter, NullLocator

from copepod_report.run_record import RunResult
from copepod_report.style import COLUMN_INCHES, LIGHT, VIOLET_TO_YELLOW, WIDTH_INCHES
from copepod_report.style import colour_bar, legend_above, new_figure
from copepod_run.errors import BadCase
from copepod_run.figures import FIGURES, MOST_TABLES, Figure, csv_text, figures_by_name, number_text, prefix_of
from copepod_run.figures import flow_means, swarm_rows
from copepod_run.names import quantity_of, short_keys

_TAKES_PREFIX = ("m", "s", "N", "Pa", "W", "J", "Hz")
_MOST_LABELS = 9
_MARKERS = "os^Dv"  # of the curves, each on top smaller than those below: curves that coincide are seen
_ABOUT_OTHERS = ("change_percent", "u_along_mean_um_per_s", "u_along_spread_um_per_s")  # figures without a plot
Draw = Callable[..., list[str]]
_PERIODIC_PERCENT = 0.1  # by which the velocity may change in the last cycle


class _OneNotation(Formatter):
    """Of all ticks, without a power of ten beside the axis, where the legend is."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        largest = np.abs(self.locs).max(initial=0.0)
        if abs(x) < 1e-9 * largest or 1e-3 <= largest < 1e6:
            return self.fix_minus(f"{np.round(x, 12):.6g}")
        return self.fix_minus(re.sub(r"\.?0+e", "e", f"{x:.3e}"))


@dataclass(frozen=True)
class Axis:
    """A swept key: where its values are drawn, and what is written beside them."""

    key: str
    label: str
    is_range: bool  # of constant ratios
    places: np.ndarray  # shape (runs,), NaN where a run has none; of words their number
    words: Sequence[str]  # empty for numbers
    heading: str  # the key without its unit
    unit: str

    def values(self) -> np.ndarray:
        """Distinct ones in rising order."""
        return np.unique(self.places)

    @property
    def is_logarithmic(self) -> bool:
        """Whether the values are positive and closer to constant ratios than to constant steps."""
        values = self.values()
        if self.words or values[0] <= 0 or self.is_range:
            return self.is_range and bool(values[0] > 0)
        steps, ratios = np.diff(values), np.diff(np.log(values))
        is_wide = len(steps) > 1 and values[-1] >= 4 * values[0]
        return is_wide and bool(np.ptp(ratios) / ratios.mean() < 0.5 * np.ptp(steps) / steps.mean())

    def number(self, place: float) -> str:
        """As it stands below the label: «2»."""
        if math.isnan(place) or self.words:
            return "" if math.isnan(place) else self.words[int(place)]
        return number_text(int(place) if float(place).is_integer() else float(place))

    def quantity(self, place: float) -> str:
        """«2 µN»."""
        return f"{self.number(place)}{'' if self.unit == '°' else ' '}{self.unit}".strip()

    def text(self, place: float) -> str:
        """«amplitude 2 µN»."""
        return f"{self.heading} {self.quantity(place)}"

    def is_called(self, name: str) -> bool:
        return f".{self.key}".endswith(f".{name}")


@dataclass(frozen=True)
class Result:
    """A figure of every run of a sweep."""

    key: str
    heading: str  # with its unit
    values: np.ndarray  # shape (runs,), NaN where a run has none
    changes: np.ndarray  # of the velocity in the last cycle [%]; NaN where they are unknown

    @property
    def still_changes(self) -> np.ndarray:
        """Mask of the runs that are not periodic yet."""
        return self.changes > _PERIODIC_PERCENT

    def is_called(self, name: str) -> bool:
        return name in (self.key, self.heading, self.heading.partition(" [")[0])


@dataclass(frozen=True)
class SweepRecord:
    """The runs of one sweep. Its figures are over the first axis, and the first result is the answer."""

    name: str
    runs: Sequence[str]
    axes: list[Axis]
    results: list[Result]


def axes_of(runs: Sequence[RunResult]) -> dict[str, Axis]:
    """All swept keys of the runs, each with one name and one unit for every table and figure."""
    heads = short_keys(list(dict.fromkeys(key for run in runs for key in run.sweep.values)))
    scales = {key: scale for run in runs for key, scale in run.sweep.scales.items()}
    axes = {}
    for key, head in heads.items():
        values = [run.sweep.values.get(key, math.nan) for run in runs]
        heading, unit = quantity_of(head)
        if all(isinstance(value, (int, float)) for value in values):
            numbers = np.array(values, float)
            factor, unit = with_prefix(numbers, unit)
            label, is_range = f"{heading} [{unit}]" if unit else heading, scales.get(key) == "logarithmic"
            axes[key] = Axis(key, label, is_range, np.round(numbers * factor, 12), [], heading, unit)
            continue
        texts = [
            "" if value is math.nan else value if isinstance(value, str) else number_text(value) for value in values
        ]
        words = [text for text in dict.fromkeys(texts) if text]
        places = np.array([words.index(text) if text else math.nan for text in texts], float)
        axes[key] = Axis(key, head.replace("_", " "), False, places, words, heading, "")
    return axes


def sweeps_of(runs: Sequence[RunResult], x: str = "", y: str = "") -> list[SweepRecord]:
    """Sweeps with two finished runs or more. Raises Stop(2) if none of them has what is chosen.

    @param x  key for the first axis, or how it ends; empty: the one with most values
    @param y  figure to be the first result, by its column in the table or its file without the name of the sweep;
              empty: the speed
    """
    groups: dict[tuple[str, str], list[int]] = {}
    for number, run in enumerate(runs):
        if run.sweep.values and run.status.is_finished:
            groups.setdefault((str(run.directory.parent), run.sweep.name), []).append(number)
    all_keys, found = list(axes_of(runs).values()), []
    for (_, name), members in groups.items():
        axes = [replace(axis, places=axis.places[members]) for axis in all_keys]
        axes = [axis for axis in axes if not np.isnan(axis.places).any() and len(axis.values()) > 1]
        if len(members) > 1:
            chosen = [runs[number] for number in members]
            found.append(SweepRecord(name, [run.name for run in chosen], axes, _results(chosen)))
    all_axes, all_results = ([item for sweep in found for item in getattr(sweep, of)] for of in ("axes", "results"))
    for option, wanted, items in (("--x", x, all_axes), ("--y", y, all_results)):
        if wanted and not any(item.is_called(wanted) for item in items):
            names = ", ".join(dict.fromkeys(item.key for item in items))
            raise BadCase(f"{option} {wanted} does not vary in these runs. What does: {names or 'nothing'}.")
    for sweep in found:
        sweep.axes.sort(key=lambda axis: (not axis.is_called(x), bool(axis.words), -len(axis.values())))
        sweep.results.sort(key=lambda result: not result.is_called(y))
    return found


def with_prefix(numbers: np.ndarray, unit: str) -> tuple[float, str]:
    """What to multiply numbers in an SI unit by for the largest to read well, and the unit then: (1e6, «µm»)."""
    largest = np.nanmax(np.abs(numbers), initial=0.0)
    first = unit.split("/")[0].split(" ")[0]
    if not largest or not math.isfinite(largest) or first not in _TAKES_PREFIX or 1e-2 <= largest < 1e4:
        return 1.0, unit
    power, prefix = prefix_of(largest, -12, 9)
    return 10.0**-power, prefix + unit


def _results(runs: Sequence[RunResult]) -> list[Result]:
    """Figures that differ among the runs, of every swimmer and group, and of a swarm together."""
    tables = [_figures_of(run) for run in runs]
    results = []
    for key, heading in {key: heading for table in tables for key, (heading, *_) in table.items()}.items():
        none = ("", math.nan, math.nan)
        values, changes = (np.array([table.get(key, none)[n] for table in tables], float) for n in (1, 2))
        if np.isfinite(values).any() and np.nanmax(values) - np.nanmin(values) > 1e-9 * np.nanmax(np.abs(values)):
            results.append(Result(key, heading, values, changes))
    return results


def _figures_of(run: RunResult) -> dict[str, tuple[str, float, float]]:
    """Heading and value of each figure and the change of the velocity, by a key that may name a file."""
    found = {}
    entries = figures_by_name(run.summary)
    for swimmer, figures in entries if len(entries) <= MOST_TABLES else []:
        change, *_ = (figures.pop(key, Figure(None)).ours for key in _ABOUT_OTHERS)
        for key, figure in figures.items():
            name, heading = key.removeprefix("kinematics."), FIGURES[key]
            if len(entries) > 1:
                name, heading = f"{swimmer}_{name}", f"{swimmer}: {heading}"
            if figure.ours is not None:
                found[name] = (heading, float(figure.ours), math.nan if change is None else change)
    for name, unit, value in swarm_rows(run.summary):
        found[f"swarm_{name}"] = (f"{name} [{unit}]" if unit else name, float(value), math.nan)
    for name, of_column in flow_means(run.summary).items():
        found[f"flow_{name}"] = (f"mean {name}", float(of_column["mean"]), math.nan)
    return found


def _others(sweep: SweepRecord) -> Sequence[Axis]:
    """The axes of which each combination of values is a curve; none for paired lists."""
    return [] if len(sweep.axes[0].values()) == len(sweep.runs) else sweep.axes[1:]


def curves(sweep: SweepRecord, result: Result, width_inches: float = COLUMN_INCHES) -> Any:
    """A result over one key, a curve for each combination of the others' values; hollow where it still changes."""
    over, others = sweep.axes[0], _others(sweep)
    figure, axes = new_figure(1.4 + 0.3 * width_inches, width_inches)
    rows = list(zip(*(axis.places for axis in others))) or [()] * len(sweep.runs)
    combinations, size = sorted(set(rows)), 0.5 + width_inches / 14
    for number, combination in enumerate(combinations):
        chosen = np.flatnonzero([row == combination for row in rows])
        chosen = chosen[np.argsort(over.places[chosen])]
        part = number / max(1, len(combinations) - 1)
        colour = VIOLET_TO_YELLOW(part) if len(combinations) > 1 else LIGHT.beads[0]
        look = {"color": colour, "marker": _MARKERS[number % len(_MARKERS)], "markersize": (7 - 3 * part) * size}
        label = ", ".join(axis.text(place) for axis, place in zip(others, combination))
        axes.plot(over.places[chosen], result.values[chosen], linewidth=1.4, label=label, **look)
        hollow = chosen[result.still_changes[chosen]]
        if len(hollow):
            axes.plot(over.places[hollow], result.values[hollow], " ", markerfacecolor=LIGHT.paper, **look)
    _dress(axes.xaxis, over)
    axes.yaxis.set_major_formatter(_OneNotation())
    axes.set_ylabel(result.heading)
    if np.nanmin(result.values) < 0 < np.nanmax(result.values):
        axes.axhline(0, color=LIGHT.faint, linewidth=1)
    if 1 < len(combinations) <= _MOST_LABELS:
        legend_above(axes, columns=_MOST_LABELS)
    elif len(combinations) > 1:  # too many lines for a legend: the first and the last are named
        bar = colour_bar(figure, ScalarMappable(cmap=VIOLET_TO_YELLOW), ax=axes, ticks=[0, 1])
        ends = ([axis.text(place) for axis, place in zip(others, combinations[end])] for end in (0, -1))
        bar.ax.set_yticklabels(map("\n".join, ends), fontsize=8)
        bar.outline.set_visible(False)
    return figure


def has_map(sweep: SweepRecord) -> bool:
    """Whether the members fill most of a grid of two keys."""
    sizes = [len(axis.values()) for axis in sweep.axes]
    members = list(zip(*(axis.places for axis in sweep.axes)))
    is_grid = len(sizes) == 2 and max(sizes) < len(members) == len(set(members))
    return is_grid and len(members) > math.prod(sizes) / 2


def colour_map(sweep: SweepRecord, result: Result) -> Any:
    """A result over both keys of a grid, a rectangle for each run; where it has both signs, zero is in the middle."""
    across, upwards = sweep.axes
    columns, rows = (np.searchsorted(axis.values(), axis.places) for axis in (across, upwards))
    values = np.full((len(upwards.values()), len(across.values())), math.nan)
    values[rows, columns] = result.values
    figure, axes = new_figure(2.4, COLUMN_INCHES)
    axes.grid(False)
    largest = np.nanmax(np.abs(values))
    both_signs = np.nanmin(values) < -1e-9 * largest and np.nanmax(values) > 1e-9 * largest
    look = {"cmap": "RdBu_r", "vmin": -largest, "vmax": largest} if both_signs else {"cmap": VIOLET_TO_YELLOW}
    drawn = axes.pcolormesh(_edges(across), _edges(upwards), values, **look)
    axes.plot(*(axis.places[result.still_changes] for axis in sweep.axes), "o", ms=4, mfc="none", mec=LIGHT.paper)
    _dress(axes.xaxis, across)
    _dress(axes.yaxis, upwards)
    colour_bar(figure, drawn, result.heading, ax=axes, format=_OneNotation()).outline.set_visible(False)
    return figure


def _edges(axis: Axis) -> np.ndarray:
    """Of the rectangles around the values: half-way between neighbours, on the axis's scale."""
    values = np.log(axis.values()) if axis.is_logarithmic else axis.values()
    middles = (values[1:] + values[:-1]) / 2
    edges = np.concatenate([[2 * values[0] - middles[0]], middles, [2 * values[-1] - middles[-1]]])
    return np.exp(edges) if axis.is_logarithmic else edges


def _dress(axis_of_plot: Any, axis: Axis) -> None:
    """Label, scale and ticks: at the values where they are words, or evenly spaced on the axis's scale."""
    name, scale = axis_of_plot.axis_name, "log" if axis.is_logarithmic else "linear"
    axis_of_plot.axes.set(**{f"{name}label": axis.label, f"{name}scale": scale})
    values = axis.values()
    is_even = len(values) <= _MOST_LABELS and np.ptp(np.diff(values)) < 1e-6 * np.ptp(values)
    axis_of_plot.set_major_formatter(_OneNotation())
    if axis.words or axis.is_logarithmic or is_even:
        shown = values if axis.words else values[:: math.ceil(len(values) / _MOST_LABELS)]
        axis_of_plot.set_ticks(shown, [axis.number(value) for value in shown])
        axis_of_plot.set_minor_locator(NullLocator())


def caption(sweep: SweepRecord, result: Result, is_map: bool) -> str:
    """What a figure shows, and which of its values are not final."""
    over, *others = (axis.heading for axis in sweep.axes)
    text = f"{sweep.name}: {result.heading} over {over}"
    if is_map:
        text += f" and {others[0]}"
    elif others and _others(sweep):
        text += f", a curve for each value of {', '.join(others)}"
    elif others:
        text += f", which varies together with {', '.join(others)}"
    if count := int(result.still_changes.sum()):
        text += ". Hollow markers: not periodic yet"
        if result is sweep.results[0] and not is_map:
            text += (
                f"; the velocity changed by more than {_PERIODIC_PERCENT} % in the last cycle of {count} of "
                f"{len(sweep.runs)} runs, at most by {number_text(np.nanmax(result.changes))} %"
            )
    return f"{text}."


def values_csv(sweep: SweepRecord, result: Result) -> str:
    """The values of a figure, a row for each run in the order of the plot."""
    columns = {
        "run": sweep.runs,
        **{axis.label: [axis.words[int(p)] if axis.words else p for p in axis.places.tolist()] for axis in sweep.axes},
        result.heading: result.values.tolist(),
        FIGURES["change_percent"]: ["" if math.isnan(change) else change for change in result.changes.tolist()],
    }
    return csv_text(columns)


def first_figures(sweeps: Sequence[SweepRecord], draw: Draw) -> list[str]:
    """HTML of the figure that answers each sweep. `draw(name, figure, caption, …)` writes a figure."""
    figures = []
    for sweep in sweeps:
        for result in sweep.results[:1] if sweep.axes else []:
            figure, narrow = curves(sweep, result, WIDTH_INCHES), curves(sweep, result)
            text, table = caption(sweep, result, is_map=False), values_csv(sweep, result)
            figures += draw(f"{sweep.name}_{result.key}", figure, text, wide=True, narrow=narrow, table=table)
    return figures


def other_figures(sweeps: Sequence[SweepRecord], draw: Draw) -> list[str]:
    """HTML of every other result that varies over the swept keys, as curves, and of all of them as maps where two keys
    form a grid."""
    others, maps = [], []
    for sweep in sweeps:
        for result in sweep.results if sweep.axes else []:
            name, text = f"{sweep.name}_{result.key}", caption(sweep, result, is_map=False)
            if result is not sweep.results[0]:
                others += draw(name, curves(sweep, result), text, table=values_csv(sweep, result))
            if has_map(sweep):
                text = caption(sweep, result, is_map=True)
                maps += draw(f"{name}_map", colour_map(sweep, result), text)
    return others + maps
