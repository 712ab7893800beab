"""Plots of motion: a swimmer's positions, driving forces, last cycle and arms with their fits; any body's path."""

from typing import Any

import numpy as np

from copepod_report.run_record import RunRecord, SwimmerRecord, fit_arm
from copepod_report.style import LIGHT, legend_above, many_lines, new_figure

LABELS = ("B2, trailing", "B1, middle", "B3, leading")


def positions(swimmer: SwimmerRecord) -> tuple[Any, Any]:
    """Figure and axes: positions of the three beads along the axis over the whole run."""
    figure, axes = new_figure(LIGHT, 3.4)
    places = swimmer.positions()
    axes.plot(swimmer.periods(), places.T, linewidth=1.3)
    for end, colour, label in zip(places[:, -1], LIGHT.beads, LABELS):
        _annotate(axes, label, (swimmer.periods()[-1], end), xytext=(4, 0), color=colour, va="center", fontsize=9)
    if swimmer.periods()[-1] > swimmer.cycles:
        axes.axvline(swimmer.cycles, color=LIGHT.ink, linewidth=0.8, linestyle=":")
        top = {"xycoords": ("data", "axes fraction"), "xytext": (4, -2), "va": "top"}
        _annotate(axes, "drive off", (swimmer.cycles, 1), color=LIGHT.ink, fontsize=8, **top)
    axes.set(xlabel="time / period", ylabel=f"position along the axis [{swimmer.run.length_unit[1]}]")
    return figure, axes


def _annotate(axes: Any, text: str, place: tuple[float, float], **look: Any) -> None:
    axes.annotate(text, place, textcoords="offset points", **look)


def driving_forces(swimmer: SwimmerRecord) -> Any:
    """Driving forces along the axis [paper, eqs. (19)-(21)]."""
    figure, axes = new_figure(LIGHT, 2.8)
    axes.plot(swimmer.periods(), 1e6 * swimmer.driving_N().T, linewidth=1.3, label=LABELS)
    axes.set(xlabel="time / period", ylabel="driving force [µN]")
    legend_above(axes, LIGHT)
    return figure


def one_cycle(swimmer: SwimmerRecord) -> Any:
    """Displacements of the beads over the last driven period, or None if the run ended before."""
    mask = swimmer.last_period()
    if not mask.any():
        return None
    figure, axes = new_figure(LIGHT, 3.0)
    places = swimmer.positions()[:, mask].T
    axes.plot(swimmer.periods()[mask], places - places[0], linewidth=1.6, label=LABELS)
    axes.axhline(0, color=LIGHT.faint, linewidth=1)
    axes.set(xlabel="time / period", ylabel=f"displacement in the last cycle [{swimmer.run.length_unit[1]}]")
    legend_above(axes, LIGHT)
    return figure


def arms(swimmer: SwimmerRecord) -> Any:
    """Lengths of the two arms over the last driven period and their fits, or None if the run ended before."""
    mask = swimmer.last_period()
    if not mask.any():
        return None
    figure, axes = new_figure(LIGHT, 3.2)
    periods = swimmer.periods()[mask]
    shown = slice(None, None, max(1, len(periods) // 60))
    lengths = np.diff(swimmer.positions()[:, mask], axis=0)
    for number, (length, colour) in enumerate(zip(lengths, LIGHT.beads[::2]), 1):
        mean, amplitude, phase = fit_arm(2 * np.pi * periods, length)
        axes.plot(periods[shown], length[shown], "o", markersize=3.5, color=colour)
        sign = "+" if phase >= 0 else "−"
        label = f"arm {number} ≈ {mean:.3f} + {amplitude:.3f} cos(ωt {sign} {abs(phase):.3f})"
        fit = mean + amplitude * np.cos(2 * np.pi * periods + phase)
        axes.plot(periods, fit, color=colour, linewidth=1.2, label=label)
    axes.set(xlabel="time / period", ylabel=f"arm length [{swimmer.run.length_unit[1]}]")
    legend_above(axes, LIGHT)
    return figure


def displacements(run: RunRecord) -> Any:
    """x, y and z displacement of every body over time, three panels."""
    figure, axes = new_figure(LIGHT, 4.6, nrows=3, sharex=True)
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
        legend_above(axes[0], LIGHT, columns=4)
    return figure
