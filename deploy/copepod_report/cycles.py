"""cycles.csv: what a run measured of every swimmer in each full cycle, and its plots."""

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from copepod_report.style import Theme, legend_above, new_figure

Cycles = dict[str, np.ndarray]  # of one swimmer: column to values, shape (cycles,); empty fields are NaN


def read_cycles(path: Path) -> dict[str, Cycles]:
    """The cycles of every swimmer by name; empty without a file. A row that was cut off is left out.

    Raises ValueError or KeyError if it is not such a table.
    """
    if not path.exists():
        return {}
    with open(path, newline="") as file:
        rows = csv.reader(file)
        header: list[str] = next(rows, [])
        by_swimmer: dict[str, list[list[float]]] = {}
        for row in rows:
            if len(row) == len(header):
                by_swimmer.setdefault(row[0], []).append([float(text) if text else np.nan for text in row[1:]])
    return {name: dict(zip(header[1:], np.array(values).T)) for name, values in by_swimmer.items()}


def centroids_m(cycles: Cycles) -> np.ndarray:
    """Of the beads at the start of every cycle, shape (cycles, 3)."""
    return np.column_stack([cycles[f"{axis}_m"] for axis in "xyz"])


def by_cycle(cycles: Cycles, theme: Theme) -> Any:
    """Velocity along and across the own axis, and means and amplitudes of the arms, cycle by cycle; None for one."""
    if len(cycles["cycle"]) < 2:
        return None
    arms = [name[: -len("_mean_m")] for name in cycles if name.endswith("_mean_m")]
    arms = [arm for arm in arms if np.isfinite(cycles[f"{arm}_mean_m"]).all()]
    of_arms = [(arm, arm.replace("arm", "arm ")) for arm in arms]
    rows = [("u_{}_m_per_s", [("along", "along the own axis"), ("across", "across it")], "velocity [µm/s]")]
    if arms:
        rows += [("{}_mean_m", of_arms, "mean arm [µm]"), ("{}_amplitude_m", of_arms, "amplitude [µm]")]
    figure, panels = new_figure(theme, 1.0 + 1.9 * len(rows), nrows=len(rows), sharex=True, squeeze=False)
    for axes, (column, lines, label) in zip(panels.flat, rows):
        for number, (key, name) in enumerate(lines):
            axes.plot(
                cycles["cycle"],
                1e6 * cycles[column.format(key)],
                marker="o",
                color=theme.beads[number % 3],
                linestyle=("-", "--", ":")[number // 3 % 3],
                markersize=4,
                linewidth=1.3,
                label=name,
            )
        axes.set_ylabel(label)
        if column != "{}_amplitude_m" and len(lines) <= 9:
            legend_above(axes, theme, columns=6)
    axes.set_xlabel("cycle")
    axes.xaxis.get_major_locator().set_params(integer=True)
    return figure


def paths(by_swimmer: Mapping[str, Cycles], theme: Theme) -> Any:
    """Displacements of the centroids in the plane of the axes along which they move most; None without three cycles.

    A dot marks the start of each cycle, an arrow the own axis at the start of the last one.
    """
    moved = {name: 1e6 * centroids_m(cycles) for name, cycles in by_swimmer.items() if len(cycles["cycle"]) > 2}
    tracks = {name: track - track[0] for name, track in moved.items()}
    if not tracks:
        return None
    extent = np.ptp(np.vstack(list(tracks.values())), axis=0)
    across, along = sorted(np.argsort(extent, kind="stable")[1:])
    figure, axes = new_figure(theme, 4.4)
    for number, (name, track) in enumerate(tracks.items()):
        colour = theme.beads[number % 3]
        axes.plot(track[:, across], track[:, along], "o-", color=colour, markersize=3, linewidth=1.2, label=name)
        own = np.array([by_swimmer[name][f"axis_{axis}"][-1] for axis in "xyz"])[[across, along]]
        axes.quiver(*track[-1, [across, along]], *own, color=colour, angles="xy", width=0.004, scale=12)
    shown = np.vstack(list(tracks.values()))[:, [across, along]]
    room = 0.25 * np.ptp(shown, axis=0).max()  # for the arrows
    axes.set_xlim(shown[:, 0].min() - room, shown[:, 0].max() + room)
    axes.set_ylim(shown[:, 1].min() - room, shown[:, 1].max() + room)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(f"Δ{'xyz'[across]} [µm]")
    axes.set_ylabel(f"Δ{'xyz'[along]} [µm]")
    if 1 < len(tracks) <= 8:
        legend_above(axes, theme, columns=4)
    return figure
