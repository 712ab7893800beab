"""Plots of motion: positions, forces, last cycle and arms of three beads; any body's path; speeds of runs."""

import csv
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from copepod_report.run_record import RunRecord, RunResult, SwimmerRecord, fit_arm
from copepod_report.style import LIGHT, legend_above, many_lines, new_figure
from copepod_run.figures import figures_by_name

LABELS = ("B2, trailing", "B1, middle", "B3, leading")


def of_swimmer(swimmer: SwimmerRecord) -> Iterator[tuple[str, Any, str]]:
    """(name, figure, caption) of every plot of three beads in a row."""
    periods, (unit_m, unit) = swimmer.run.trajectory.steps / swimmer.period, swimmer.run.length_unit
    start_m = np.dot(swimmer.section["center_m"], swimmer.axis)
    places = (swimmer.along_axis("position_m") - start_m) / unit_m
    forces = 1e6 * swimmer.along_axis("driving_N")  # [paper, eqs. (19)-(21)]

    def plotted(height: float, samples: Any, lines: np.ndarray, width: float, label: str) -> Any:
        figure, axes = new_figure(height)
        axes.plot(periods[samples], lines.T, linewidth=width, label=LABELS)
        axes.set(xlabel="time / period", ylabel=label)
        return figure

    figure = plotted(3.4, slice(None), places, 1.3, f"position along the axis [{unit}]")
    (axes,) = figure.axes
    look: dict[str, Any] = {"textcoords": "offset points"}
    for end, colour, label in zip(places[:, -1], LIGHT.beads, LABELS):
        axes.annotate(label, (periods[-1], end), xytext=(4, 0), color=colour, va="center", fontsize=9, **look)
    if periods[-1] > swimmer.cycles:
        axes.axvline(swimmer.cycles, color=LIGHT.ink, linewidth=0.8, linestyle=":")
        look |= {"xycoords": ("data", "axes fraction"), "xytext": (4, -2), "va": "top"}
        axes.annotate("drive off", (swimmer.cycles, 1), color=LIGHT.ink, fontsize=8, **look)
    yield "positions", figure, "Positions of the three beads, from the middle bead's start."
    mask = swimmer.last_period()
    if mask.any():
        last = places[:, mask]
        label = f"displacement in the last cycle [{unit}]"
        figure = plotted(3.0, mask, last - last[:, :1], 1.6, label)
        figure.axes[0].axhline(0, color=LIGHT.faint, linewidth=1)
        legend_above(figure.axes[0])
        yield "cycle", figure, "Displacements over the last full period of the drive."
        text = "Arms over the last full period of the drive, and the fits that d1, d2 and the phases come from."
        yield "arms", _arms(periods[mask], np.diff(last, axis=0), unit), text
    figure = plotted(2.8, slice(None), forces, 1.3, "driving force [µN]")
    legend_above(figure.axes[0])
    yield "forces", figure, "Driving forces along the axis."


def _arms(periods: np.ndarray, lengths: np.ndarray, unit: str) -> Any:
    """Lengths of the two arms over a period and their fits."""
    figure, axes = new_figure(3.2)
    shown = slice(None, None, max(1, len(periods) // 60))
    for number, (length, colour) in enumerate(zip(lengths, LIGHT.beads[::2]), 1):
        mean, amplitude, phase = fit_arm(2 * np.pi * periods, length)
        axes.plot(periods[shown], length[shown], "o", markersize=3.5, color=colour)
        sign = "+" if phase >= 0 else "−"
        label = f"arm {number} ≈ {mean:.3f} + {amplitude:.3f} cos(ωt {sign} {abs(phase):.3f})"
        fit = mean + amplitude * np.cos(2 * np.pi * periods + phase)
        axes.plot(periods, fit, color=colour, linewidth=1.2, label=label)
    axes.set(xlabel="time / period", ylabel=f"arm length [{unit}]")
    legend_above(axes)
    return figure


def displacements(run: RunRecord) -> Any:
    """x, y and z displacement of every body over time, three panels."""
    figure, axes = new_figure(4.6, nrows=3, sharex=True)
    unit, unit_name = run.length_unit
    for panel, name in zip(axes, "xyz"):
        panel.set_prop_cycle(many_lines(*LIGHT.beads, LIGHT.ink))
        panel.set_ylabel(f"Δ{name} [{unit_name}]")
    for body in run.trajectory.bodies:
        moved = run.trajectory.of(body)["position_m"]
        for panel, values in zip(axes, (moved - moved[0]).T / unit):
            panel.plot(run.trajectory.steps, values, linewidth=1.2, label=body)
    axes[-1].set_xlabel("step")
    if len(run.trajectory.bodies) <= 12:
        legend_above(axes[0], columns=4)
    return figure


def flow_over_time(path: Path) -> Any:
    """What flow.csv or coefficients.csv has, or None without samples."""
    text = path.read_text() if path.exists() else ""
    rows = list(csv.reader(text[: text.rfind("\n")].splitlines()))  # the last one may be half written
    if len(rows) < 3:
        return None
    columns = dict(zip(rows[0], np.array(rows[1:], dtype=float).T))
    quantities = {"energy [J]": "kinetic_energy_J", "dissipation [W]": "dissipation_W"}
    quantities |= {"velocity [m/s]": r".*\.v._m_per_s", "pressure [Pa]": r".*\.pressure_Pa"}
    quantities |= {"flow [m³/s]": r".*\.inflow_m3_per_s", "force on faces [N]": r".*\.f._N"}
    quantities |= {"drag coefficient": r".*\.drag", "lift coefficient": r".*\.lift"}
    found = {label: [name for name in columns if re.fullmatch(form, name)] for label, form in quantities.items()}
    shown = {label: names for label, names in found.items() if names}
    figure, panels = new_figure(0.4 + 1.5 * len(shown), nrows=len(shown), sharex=True, squeeze=False)
    for panel, (label, names) in zip(panels.flat, shown.items()):
        panel.set_prop_cycle(many_lines(*LIGHT.beads, LIGHT.ink))
        for name in names:
            panel.plot(columns["time_s"], columns[name], linewidth=1.2, label=name.rpartition("_m_per_s")[0] or name)
        panel.set_ylabel(label)
        if label.endswith("coefficient"):  # a sudden start takes many times as much
            late = np.concatenate([columns[name][len(rows) // 2 :] for name in names])
            margin = max(np.ptp(late) / 2, 0.1 * np.abs(late).max(), 1e-9)
            panel.set_ylim(late.min() - margin, late.max() + margin)
        if 1 < len(names) <= 12:
            legend_above(panel, columns=6)
    panels.flat[-1].set_xlabel("time [s]")
    return figure


def speeds(runs: Sequence[RunResult]) -> Any:
    """Swimming speed of every run, ours and the published one, or None if no run was analysed."""
    found = [(run.name, figures.get("u_swim_lattice")) for run in runs for _, figures in figures_by_name(run.summary)]
    if not (rows := [(name, speed.ours, speed.published) for name, speed in found if speed]):
        return None
    figure, axes = new_figure(1.2 + 0.3 * len(rows))
    places = range(len(rows), 0, -1)
    axes.hlines(places, 0, [ours for _, ours, _ in rows], color=LIGHT.faint, linewidth=2)
    axes.plot([ours for _, ours, _ in rows], places, "o", color=LIGHT.beads[0], markersize=8, label="this run")
    if published := [(value, place) for (_, _, value), place in zip(rows, places) if value is not None]:
        look = {"markerfacecolor": "none", "markeredgecolor": LIGHT.beads[1], "markeredgewidth": 1.6}
        axes.plot(*zip(*published), "o", markersize=11, label="published", **look)
    axes.set_yticks(list(places), [name for name, _, _ in rows])
    axes.grid(axis="y", visible=False)
    axes.set(ylim=(0.4, len(rows) + 0.6), xlabel="u_swim [cells/step]")
    legend_above(axes)
    return figure
