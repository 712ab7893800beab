"""The mean flow of fields.h5 in the plane of the swimmers, with the bodies drawn at their mean positions."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from matplotlib import patches
from matplotlib.colors import PowerNorm

from copepod_report.run_record import RunRecord
from copepod_report.style import WIDTH_INCHES, Theme, new_figure

_AXES = "xyz"


@dataclass(frozen=True)
class FlowPlane:
    """A plane that contains the axis `along`; arrays have shape (cells across, cells along).

    Where a body was for a part of the time, its own velocity is in the mean.
    """

    along: int
    across: int
    velocity_along_m_per_s: np.ndarray
    velocity_across_m_per_s: np.ndarray


def read_mean_flow(path: Path, point_cells: Sequence[float], along: int, across: int) -> FlowPlane | None:
    """The group /mean in a plane through a point, spanned by two of the axes 0, 1, 2; None if there is no mean flow."""
    if not path.exists():
        return None
    (normal,) = {0, 1, 2} - {along, across}
    with h5py.File(path, "r", locking=False) as file:
        if "mean" not in file:
            return None
        layers = _layers_at(point_cells[normal])
        velocity = np.mean([_plane(file["mean/velocity_m_per_s"], normal, layer) for layer in layers], axis=0)
    if across > along:  # arrays come with the slower axis first: (z, y, x) without the normal
        return FlowPlane(along, across, velocity[..., along], velocity[..., across])
    return FlowPlane(along, across, velocity[..., along].T, velocity[..., across].T)


def _layers_at(coordinate_cells: float) -> list[int]:
    """The layer of cells that holds a coordinate, or the two beside it if it lies on their faces."""
    nearest_face = round(coordinate_cells)
    if abs(coordinate_cells - nearest_face) < 1e-6:
        return [nearest_face - 1, nearest_face]
    return [int(coordinate_cells)]


def _plane(dataset: Any, normal: int, number: int) -> np.ndarray:
    """One layer of a dataset with shape (nz, ny, nx, …)."""
    index: list[slice | int] = [slice(None)] * 3
    index[2 - normal] = number
    return dataset[tuple(index)]


def plane_of(run: RunRecord) -> tuple[Sequence[float], int, int]:
    """(point in cells, along, across): a plane with the first swimmer's axis and, if they stand in a row, the others.

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


def draw_mean_flow(run: RunRecord, plane: FlowPlane, theme: Theme) -> Any:
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


def _draw_beads(axes: Any, run: RunRecord, plane: FlowPlane, theme: Theme) -> None:
    """Outlines of the beads, and of their images behind symmetry planes, at their mean positions."""
    window = run.case["output"]["fields"]["mean_over_steps"]
    cell = run.cell_size_m
    shown = [plane.along, plane.across]
    for swimmer in run.swimmers() if len(run.trajectory) else []:
        beads = zip(
            swimmer.beads, swimmer.mean_positions_m(*window), swimmer.directions(), itertools.cycle(theme.beads)
        )
        for bead, center_m, direction, colour in beads:
            looks = {"facecolor": colour, "edgecolor": theme.paper, "linewidth": 1, "zorder": 5}
            for center in _with_image(run, center_m / cell, plane.across):
                axes.add_patch(_outline(bead, center[shown], direction[shown], cell, **looks))


def _with_image(run: RunRecord, center: np.ndarray, across: int) -> list[np.ndarray]:
    """A centre in cells, and its mirror image if a plane of symmetry cuts the picture beside it."""
    planes = run.case["fluid"].get("symmetry_planes") or []
    image = np.array(center)
    image[across] = run.case["fluid"]["domain_cells"][across] - center[across]
    has_image = _AXES[across] in planes and abs(image[across] - center[across]) > 1e-6
    return [center, image] if has_image else [center]


def _outline(bead: Mapping[str, Any], center: np.ndarray, direction: np.ndarray, cell: float, **looks: Any) -> Any:
    """A circle, or a capsule as a box with round ends, as seen along the normal of the plane; lengths in cells."""
    radius = bead["radius_m"] / cell
    if bead["shape"] == "sphere":
        return patches.Circle(center, radius, **looks)
    half = 0.5 * bead["length_m"] / cell * float(np.hypot(*direction))
    angle = np.arctan2(direction[1], direction[0])
    arc = np.linspace(-np.pi / 2, np.pi / 2, 24)
    end = np.column_stack([half + radius * np.cos(arc), radius * np.sin(arc)])
    outline = np.vstack([end, -end])
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return patches.Polygon(outline @ turn.T + center, closed=True, **looks)
