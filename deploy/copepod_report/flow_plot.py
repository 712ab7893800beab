"""The mean flow in the plane of the swimmers, with the bodies drawn where they were on average."""

import numpy as np
from matplotlib import patches
from matplotlib.colors import PowerNorm

from copepod_report.style import WIDTH_INCHES, new_figure

_AXES = "xyz"


def plane_of(run):
    """(point in cells, along, across): the plane that holds the first swimmer's axis and, if they stand in a row, the others.

    Without swimmers: the middle plane normal to x, with z along.
    """
    swimmers = run.swimmers()
    if not swimmers:
        return [cells / 2 for cells in run.case["fluid"]["domain_cells"]], 2, 1
    centers = np.array([swimmer.center_m for swimmer in swimmers]) / run.cell_size_m
    along = int(abs(swimmers[0].axis).argmax())
    others = [axis for axis in (0, 1, 2) if axis != along]
    spread = np.ptp(centers, axis=0)
    across = others[0] if spread[others[0]] > spread[others[1]] else others[1]
    return centers[0], along, across


def mean_flow(run, plane, theme):
    """Speed as colour, direction as stream lines; lengths in cells."""
    speed = np.hypot(plane.velocity_along_m_per_s, plane.velocity_across_m_per_s)
    rows, columns = speed.shape
    figure, axes = new_figure(theme, min((WIDTH_INCHES - 1.9) * rows / columns + 0.7, 7.5))
    axes.grid(False)
    image = axes.imshow(
        speed,
        origin="lower",
        extent=(0, columns, 0, rows),
        cmap=theme.flow,
        interpolation="bilinear",
        norm=PowerNorm(0.5, vmin=0, vmax=max(np.quantile(speed, 0.998), 1e-300)),
    )
    axes.streamplot(
        np.arange(columns) + 0.5,
        np.arange(rows) + 0.5,
        plane.velocity_along_m_per_s,
        plane.velocity_across_m_per_s,
        color=theme.stream,
        linewidth=0.5,
        arrowsize=0.7,
        density=1.6,
    )
    _draw_beads(axes, run, plane, theme)
    axes.set_xlim(0, columns)
    axes.set_ylim(0, rows)
    axes.set_xlabel(f"{_AXES[plane.along]} [cells]")
    axes.set_ylabel(f"{_AXES[plane.across]} [cells]")
    bar = figure.colorbar(
        image,
        cax=axes.inset_axes([1.02, 0, 0.022, 1]),
        format="%.1e",
        ticks=np.linspace(0, 1, 6) ** 2 * image.norm.vmax,
    )
    bar.set_label("mean speed in the plane [m/s]", color=theme.ink)
    bar.outline.set_edgecolor(theme.faint)
    bar.ax.tick_params(colors=theme.ink)
    return figure


def _draw_beads(axes, run, plane, theme):
    """Outlines of the beads, and of their images behind planes of symmetry, at their mean position during the averaging."""
    window = run.case["output"]["fields"]["mean_over_steps"]
    cell = run.cell_size_m
    shown = [plane.along, plane.across]
    for swimmer in run.swimmers():
        for bead, center_m, colour in zip(swimmer.beads, swimmer.mean_positions_m(*window), theme.beads):
            looks = {"facecolor": colour, "edgecolor": theme.paper, "linewidth": 1, "zorder": 5}
            for center in _with_image(run, center_m / cell, plane.across):
                axes.add_patch(_outline(bead, center[shown], swimmer.axis[shown], cell, **looks))


def _with_image(run, center, across):
    """A centre in cells, and its mirror image if a plane of symmetry cuts the picture beside it."""
    planes = run.case["fluid"].get("symmetry_planes") or []
    image = np.array(center)
    image[across] = run.case["fluid"]["domain_cells"][across] - center[across]
    has_image = _AXES[across] in planes and abs(image[across] - center[across]) > 1e-6
    return [center, image] if has_image else [center]


def _outline(bead, center, axis, cell, **looks):
    """A circle, or a capsule as a box with round ends; lengths in cells."""
    radius = bead["radius_m"] / cell
    if bead["shape"] == "sphere":
        return patches.Circle(center, radius, **looks)
    half = 0.5 * bead["length_m"] / cell
    direction = axis if bead["orientation"] == "parallel" else np.array([-axis[1], axis[0]])
    angle = np.arctan2(direction[1], direction[0])
    arc = np.linspace(-np.pi / 2, np.pi / 2, 24)
    end = np.column_stack([half + radius * np.cos(arc), radius * np.sin(arc)])
    outline = np.vstack([end, -end])
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return patches.Polygon(outline @ turn.T + center, closed=True, **looks)
