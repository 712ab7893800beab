"""cycles.csv: what a run measured of every swimmer in each full cycle, and its plots."""

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from copepod_report.style import LIGHT, legend_above, many_lines, new_figure

Cycles = dict[str, np.ndarray]  # of one swimmer: column to values, shape (cycles,); empty fields are NaN


def read_cycles(path: Path) -> dict[str, Cycles]:
    """The cycles of every swimmer by name; empty without a file. A row that was cut off is left out.

    Raises ValueError or KeyError if it is not such a table.
    """
    text = path.read_text() if path.exists() else ""
    rows = csv.reader(io.StringIO(text[: text.rfind("\n") + 1]))  # a row may be half written
    header: list[str] = next(rows, [])
    by_swimmer: dict[str, list[list[float]]] = {}
    for row in rows:
        if len(row) == len(header):
            by_swimmer.setdefault(row[0], []).append([float(text) if text else np.nan for text in row[1:]])
    return {name: dict(zip(header[1:], np.array(values).T)) for name, values in by_swimmer.items()}


def kinematics_so_far(cycles: Cycles) -> dict[str, Any]:
    """Keys of a swimmer's `kinematics` in summary.json, of the last full cycle."""
    last = {column: float(values[-1]) for column, values in cycles.items()}
    optional = ("power_W", "dissipation_W", "efficiency", "Re")  # empty in vacuum
    latest = 1e6 * cycles["u_along_m_per_s"][1:][-5:]
    steady = {}
    if len(latest) >= 3:
        steady = {"u_along_mean_um_per_s": float(latest.mean()), "u_along_spread_um_per_s": float(latest.std(ddof=1))}
    return {
        **steady,
        **{key: None if np.isnan(last[key]) else last[key] for key in optional},
        "cycle": int(last["cycle"]),
        "u_along_um_per_s": 1e6 * last["u_along_m_per_s"],
        "u_across_um_per_s": 1e6 * last["u_across_m_per_s"],
        "tilt_rad": last["tilt_rad"],
        "rotation_rad": [last[f"rotation_{axis}_rad"] for axis in "xyz"],
        "arms": [
            {"mean_m": last[f"{arm}_mean_m"], "amplitude_m": last[f"{arm}_amplitude_m"]} for arm in _arms_in(cycles)
        ],
    }


def _arms_in(cycles: Cycles) -> list[str]:
    """Beginnings of the columns of its arms: a table of several swimmers has those of the one with most arms."""
    suffix = "_mean_m"
    return [name.removesuffix(suffix) for name in cycles if name.endswith(suffix) and np.isfinite(cycles[name]).all()]


def centroids_m(cycles: Cycles) -> np.ndarray:
    """Of the beads at the start of every cycle and at the end of the last, shape (cycles + 1, 3); needs two cycles."""
    starts = np.column_stack([cycles[f"{axis}_m"] for axis in "xyz"])
    velocity = np.array([cycles[f"u{axis}_m_per_s"][-1] for axis in "xyz"])
    return np.vstack([starts, starts[-1] + velocity * (cycles["start_s"][1] - cycles["start_s"][0])])


def by_cycle(cycles: Cycles, arm_names: Sequence[str]) -> Any:
    """Velocity along and across the own axis, rotation, means and amplitudes of the arms by cycle; None for one."""
    if len(cycles["cycle"]) < 2:
        return None
    arms = _arms_in(cycles)
    names = arm_names if len(arm_names) == len(arms) else [arm.replace("arm", "arm ") for arm in arms]
    of_arms = list(zip(arms, names))
    turns = np.array([cycles[f"rotation_{axis}_rad"] for axis in "xyz"])
    least = max(1e-9, 1e-6 * np.abs(turns).max())  # below it rounding errors show
    of_turns = [(axis, f"about {axis}") for axis, turn in zip("xyz", turns) if np.abs(turn).max() > least]
    rows = [("u_{}_m_per_s", [("along", "along the own axis"), ("across", "across it")], "velocity [µm/s]", 1e6)]
    if of_turns:
        rows += [("rotation_{}_rad", of_turns, "rotation [degrees]", 180 / np.pi)]
    if arms:
        rows += [("{}_mean_m", of_arms, "mean arm [µm]", 1e6), ("{}_amplitude_m", of_arms, "amplitude [µm]", 1e6)]
    figure, panels = new_figure(1.0 + 1.9 * len(rows), nrows=len(rows), sharex=True, squeeze=False)
    for axes, (column, lines, label, unit) in zip(panels.flat, rows):
        values = unit * np.array([cycles[column.format(key)] for key, _ in lines])
        axes.set_ylim(*_frame(values))
        axes.set_prop_cycle(many_lines(*LIGHT.beads))
        for line, (_, name) in zip(values, lines):
            axes.plot(cycles["cycle"], line, marker="o", markersize=4, linewidth=1.3, label=name)
        axes.set_ylabel(label)
        axes.yaxis.get_major_formatter().set_useOffset(False)
        if column != "{}_amplitude_m" and len(lines) <= 9:
            legend_above(axes, columns=6)
    axes.set_xlabel("cycle")
    axes.xaxis.get_major_locator().set_params(integer=True)
    return figure


def _frame(values: np.ndarray) -> tuple[float, float]:
    """Limits for lines of shape (lines, cycles) that a transient first cycle does not determine."""
    settled = values[:, 1:] if values.shape[1] > 2 else values
    low, high = settled.min(), settled.max()
    span = max(high - low, 2e-2 * np.abs(settled).max(), 1e-12)
    near = values[(values > low - span) & (values < high + span)]
    return min(low, near.min()) - 0.1 * span, max(high, near.max()) + 0.1 * span


def paths(by_swimmer: Mapping[str, Cycles]) -> Any:
    """Displacements of the centroids in the plane of the axes along which they move most; None without three cycles.

    They start at the end of the first cycle, which may be a transient. A dot marks each end of a cycle, an arrow the
    own axis at the start of the last one.
    """
    moved = {name: 1e6 * centroids_m(cycles)[1:] for name, cycles in by_swimmer.items() if len(cycles["cycle"]) > 2}
    if not (tracks := {name: track - track[0] for name, track in moved.items()}):
        return None
    places = np.vstack(list(tracks.values()))
    across, along = sorted(np.argsort(np.ptp(places, axis=0), kind="stable")[1:])
    figure, axes = new_figure(4.4)
    for number, (name, track) in enumerate(tracks.items()):
        colour = LIGHT.beads[number % 3]
        axes.plot(track[:, across], track[:, along], "o-", color=colour, markersize=3, linewidth=1.2, label=name)
        own = np.array([by_swimmer[name][f"axis_{axis}"][-1] for axis in "xyz"])[[across, along]]
        axes.quiver(*track[-2, [across, along]], *own, color=colour, angles="xy", width=0.004, scale=12)
    shown = places[:, [across, along]]
    room = 0.25 * np.ptp(shown, axis=0).max()  # for the arrows
    x_limits, y_limits = zip(shown.min(axis=0) - room, shown.max(axis=0) + room)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlim=x_limits, ylim=y_limits, xlabel=f"Δ{'xyz'[across]} [µm]", ylabel=f"Δ{'xyz'[along]} [µm]")
    if 1 < len(tracks) <= 8:
        legend_above(axes, columns=4)
    return figure
