"""Plots of one swimmer: positions, driving forces, one cycle, arms with their fits."""

import numpy as np

from copepod_report.run_record import fit_arm
from copepod_report.style import new_figure
from copepod_report.vacuum_solution import VacuumSwimmer

LABELS = ("B2, trailing", "B1, middle", "B3, leading")


def positions(swimmer, theme):
    """Positions of the three beads along the axis over the whole run (the paper's figures of trajectories)."""
    figure, axes = new_figure(theme, 3.4)
    for values, colour, label in zip(swimmer.positions(), theme.beads, LABELS):
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
    _draw_exact(axes, swimmer, theme)
    _mark_end_of_drive(axes, swimmer, theme)
    axes.set_xlabel("time / period")
    axes.set_ylabel(f"position along the axis [{swimmer.run.length_unit[1]}]")
    return figure


def _draw_exact(axes, swimmer, theme):
    """In vacuum: the exact motion as dots on our lines, and how far they are apart."""
    if swimmer.run.case["fluid"]["solver"] != "vacuum":
        return
    exact = VacuumSwimmer.of_case(swimmer.run.case, swimmer.section)
    rest = swimmer.positions()[:, :1]
    motion = rest + exact.displacements_m(swimmer.run.trajectory.steps) / swimmer.run.length_unit[0]
    shown = slice(None, None, max(1, len(swimmer.periods()) // 70))
    for values in motion:
        axes.plot(swimmer.periods()[shown], values[shown], ".", color=theme.ink, markersize=2.5)
    apart = np.abs(motion - swimmer.positions()).max()
    axes.set_title(
        f"dots: exact solution, at most {apart:.1e} {swimmer.run.length_unit[1]} away",
        fontsize=9,
        loc="left",
        color=theme.ink,
    )


def driving_forces(swimmer, theme):
    """Driving forces along the axis [paper, eqs. (19)-(21)]."""
    figure, axes = new_figure(theme, 2.8)
    for values, colour, label in zip(swimmer.driving_N(), theme.beads, LABELS):
        axes.plot(swimmer.periods(), 1e6 * values, color=colour, linewidth=1.3, label=label)
    axes.set_xlabel("time / period")
    axes.set_ylabel("driving force [µN]")
    _legend_above(axes, theme)
    return figure


def one_cycle(swimmer, theme):
    """Displacements of the beads over the last driven period, or None if the run ended before."""
    mask = swimmer.last_period()
    if not mask.any():
        return None
    figure, axes = new_figure(theme, 3.0)
    for values, colour, label in zip(swimmer.positions()[:, mask], theme.beads, LABELS):
        axes.plot(swimmer.periods()[mask], values - values[0], color=colour, linewidth=1.6, label=label)
    axes.axhline(0, color=theme.faint, linewidth=1)
    axes.set_xlabel("time / period")
    axes.set_ylabel(f"displacement in the last cycle [{swimmer.run.length_unit[1]}]")
    _legend_above(axes, theme)
    return figure


def arms(swimmer, theme):
    """Lengths of the two arms over the last driven period and their fits, or None if the run ended before."""
    mask = swimmer.last_period()
    if not mask.any():
        return None
    figure, axes = new_figure(theme, 3.2)
    trailing, middle, leading = swimmer.positions()[:, mask]
    periods = swimmer.periods()[mask]
    unit = swimmer.run.length_unit[1]
    for number, (length, colour) in enumerate(
        ((middle - trailing, theme.beads[0]), (leading - middle, theme.beads[2])), 1
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
    axes.set_xlabel("time / period")
    axes.set_ylabel(f"arm length [{unit}]")
    _legend_above(axes, theme)
    return figure


def _mark_end_of_drive(axes, swimmer, theme):
    if swimmer.periods()[-1] > swimmer.cycles:
        axes.axvline(swimmer.cycles, color=theme.ink, linewidth=0.8, linestyle=":")
        axes.annotate(
            "drive off",
            (swimmer.cycles, 1),
            xycoords=("data", "axes fraction"),
            xytext=(4, -2),
            textcoords="offset points",
            va="top",
            fontsize=8,
            color=theme.ink,
        )


def _legend_above(axes, theme):
    axes.legend(
        loc="lower left",
        bbox_to_anchor=(0, 1.0),
        ncols=3,
        fontsize=9,
        labelcolor=theme.ink,
        frameon=False,
        borderaxespad=0.2,
    )
