"""Displacements of all bodies, for runs without swimmers."""

from copepod_report.style import new_figure


def displacements(run, theme):
    """x, y and z displacement of every body over time, three panels."""
    figure, axes = new_figure(theme, 4.6, nrows=3, sharex=True)
    unit, unit_name = run.length_unit
    colours = (*theme.beads, theme.ink)
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
        axes[0].legend(
            loc="lower left", bbox_to_anchor=(0, 1), ncols=4, fontsize=9, labelcolor=theme.ink, frameon=False
        )
    return figure
