"""Plots of motion: a swimmer's positions, driving forces, last cycle and arms with their fits; any body's path."""

from typing import Any

import numpy as np

from copepod_report.run_record import RunRecord, SwimmerRecord, fit_arm
from copepod_report.style import LIGHT, legend_above, new_figure

LABELS = ("B2, trailing", "B1, middle", "B3, leading")


def positions(swimmer: SwimmerRecord) -> tuple[Any, Any]:
    """Figure and axes: positions of the three beads along the axis over the whole run."""
    figure, axes = new_figure(LIGHT, 3.4)
    for values, colour, label in zip(swimmer.positions(), LIGHT.beads, LABELS):
        axes.plot(swimmer.periods(), values, color=colour, linewidth=1.3)
        axes.annotate(
            label,
            (swimmer.periods()[-1], values[-1]),
            xytext=(4, 0),
            textcoords="offset points",
            color=colour,
            va="center",
            fontsize=9,
        )
    _mark_end_of_drive(axes, swimmer)
    axes.set(xlabel="time / period", ylabel=f"position along the axis [{swimmer.run.length_unit[1]}]")
    return figure, axes


def driving_forces(swimmer: SwimmerRecord) -> Any:
    """Driving forces along the axis [paper, eqs. (19)-(21)]."""
    figure, axes = new_figure(LIGHT, 2.8)
    for values, colour, label in zip(swimmer.driving_N(), LIGHT.beads, LABELS):
        axes.plot(swimmer.periods(), 1e6 * values, color=colour, linewidth=1.3, label=label)
    axes.set(xlabel="time / period", ylabel="driving force [µN]")
    legend_above(axes, LIGHT)
    return figure


def one_cycle(swimmer: SwimmerRecord) -> Any:
    """Displacements of the beads over the last driven period, or None if the run ended before."""
    mask = swimmer.last_period()
    if not mask.any():
        return None
    figure, axes = new_figure(LIGHT, 3.0)
    for values, colour, label in zip(swimmer.positions()[:, mask], LIGHT.beads, LABELS):
        axes.plot(swimmer.periods()[mask], values - values[0], color=colour, linewidth=1.6, label=label)
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
    trailing, middle, leading = swimmer.positions()[:, mask]
    periods = swimmer.periods()[mask]
    unit = swimmer.run.length_unit[1]
    for number, (length, colour) in enumerate(
        ((middle - trailing, LIGHT.beads[0]), (leading - middle, LIGHT.beads[2])), 1
    ):
        mean, amplitude, phase = fit_arm(2 * np.pi * periods, length)
        shown = slice(None, None, max(1, len(periods) // 60))
        axes.plot(periods[shown], length[shown], "o", markersize=3.5, color=colour)
        sign = "+" if phase >= 0 else "−"
        axes.plot(
            periods,
            mean + amplitude * np.cos(2 * np.pi * periods + phase),
            color=colour,
            linewidth=1.2,
            label=f"arm {number} ≈ {mean:.3f} + {amplitude:.3f} cos(ωt {sign} {abs(phase):.3f})",
        )
    axes.set(xlabel="time / period", ylabel=f"arm length [{unit}]")
    legend_above(axes, LIGHT)
    return figure


def _mark_end_of_drive(axes: Any, swimmer: SwimmerRecord) -> None:
    if swimmer.periods()[-1] > swimmer.cycles:
        axes.axvline(swimmer.cycles, color=LIGHT.ink, linewidth=0.8, linestyle=":")
        axes.annotate(
            "drive off",
            (swimmer.cycles, 1),
            xycoords=("data", "axes fraction"),
            xytext=(4, -2),
            textcoords="offset points",
            va="top",
            fontsize=8,
            color=LIGHT.ink,
        )


def displacements(run: RunRecord) -> Any:
    """x, y and z displacement of every body over time, three panels."""
    figure, axes = new_figure(LIGHT, 4.6, nrows=3, sharex=True)
    unit, unit_name = run.length_unit
    colours = (*LIGHT.beads, LIGHT.ink)
    for number, body in enumerate(run.trajectory.bodies):
        moved = run.trajectory.of(body)["position_m"]
        moved = (moved - moved[0]) / unit
        for axis, panel in enumerate(axes):
            panel.plot(
                run.trajectory.steps,
                moved[:, axis],
                color=colours[number % len(colours)],
                linestyle=("-", "--", ":")[number // len(colours) % 3],
                linewidth=1.2,
                label=body,
            )
    for panel, name in zip(axes, "xyz"):
        panel.set_ylabel(f"Δ{name} [{unit_name}]")
    axes[-1].set_xlabel("step")
    if len(run.trajectory.bodies) <= 12:
        legend_above(axes[0], LIGHT, columns=4)
    return figure
