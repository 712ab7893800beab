"""Pictures of the flow in a plane: what they show is chosen by the user, or from flow and bodies; and the drawing."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import PowerNorm

from copepod_report.fields import MEAN, read_coarse, read_layer, times_in
from copepod_report.run_record import Body, RunRecord, read_file, rotated
from copepod_report.scene import surfaces_of
from copepod_report.style import FLOW, LIGHT, WIDTH_INCHES, colour_bar, new_figure
from copepod_run.errors import BadCase, Stop
from copepod_run.figures import prefix_of, quantity_text

_AXES = "xyz"
_ALIKE = 0.05  # shares of the motion that differ by less are taken as equal


@dataclass(frozen=True)
class View:
    """What to show of a flow; the default follows the bodies and the flow itself."""

    plane: str = "auto"  # or two of x, y, z, the horizontal one first
    at_m: float | None = None  # where the plane is along its normal
    time: str = "auto"  # "mean", "last" or the step of a snapshot
    zoom: str = ""  # name of a swimmer or body
    margin_m: float | None = None  # around it
    frame: str = ""  # name of a swimmer or body whose velocity is subtracted


@dataclass(frozen=True)
class FlowPicture:
    """Velocity in a plane, relative to the frame; arrays have shape (cells across, cells along)."""

    along: int  # axis 0, 1, 2, horizontal
    across: int
    at_m: float
    velocity_along_m_per_s: np.ndarray
    velocity_across_m_per_s: np.ndarray
    corner_cells: tuple[int, int]  # lower left, along and across
    window: tuple[int, int]  # first step and the step after the last of a mean, twice the step of a snapshot
    frame: str
    shown_m: tuple[float, float, float, float] | None  # low and high along, low and high across

    @property
    def normal(self) -> int:
        return 3 - self.along - self.across

    @property
    def speed_m_per_s(self) -> np.ndarray:
        """In the plane."""
        return np.hypot(self.velocity_along_m_per_s, self.velocity_across_m_per_s)

    @property
    def plane(self) -> str:
        return _AXES[self.along] + _AXES[self.across]

    @property
    def is_mean(self) -> bool:
        return self.window[1] > self.window[0]

    def caption(self, run: RunRecord) -> str:
        plane = f"{_AXES[self.along]}–{_AXES[self.across]} plane at {_AXES[self.normal]} = {1e6 * self.at_m:.4g} µm"
        step_s = run.summary.get("step_s") or 0.0
        times = [quantity_text(step * step_s, "s") for step in self.window]
        frame = f"relative to the velocity of {self.frame}" if self.frame else "in the laboratory frame"
        when, notes = f"step {self.window[0]} ({times[0]})", []
        if self.is_mean:
            when = f"mean over steps {self.window[0]} to {self.window[1]} ({times[0]} to {times[1]})"
            notes = [
                "bodies at their mean positions; where one was for a part of the time, its velocity is in the mean"
            ]
        if not all(_is_cut(run, body, self) for body in run.bodies if len(run.trajectory)):
            notes.append("dashed: outside the plane")
        return "; ".join([f"Flow in the {plane}, {when}, {frame}", *notes]) + "."


def choose(run: RunRecord, view: View) -> FlowPicture | None:
    """The picture of a run; None if it recorded no velocity.

    Raises Stop(2) if the run lacks what the view names, Stop(73) if its file is damaged.
    """
    path = run.directory / "fields.h5"
    if (time := _time_of(run, view, *read_file(path, times_in))) is None:
        return None
    window = tuple(run.case["output"]["fields"]["mean_over_steps"]) if time == MEAN else (int(time), int(time))
    zoomed, followed = _bodies_named(run, view.zoom, "--zoom"), _bodies_named(run, view.frame, "--frame")
    along, across = _plane_of(run, view, time)
    normal = 3 - along - across
    at_m = view.at_m if view.at_m is not None else _middle_of(run, zoomed or followed, window, normal)
    length_m = run.domain_m[normal]
    if not 0 <= at_m <= length_m:
        raise _unusable(f"--at {at_m:g}", run, f"its domain ends at {_AXES[normal]} = {length_m:g} m", "Choose less")
    layer = partial(read_layer, time=time, normal=normal, coordinate_cells=at_m / run.cell_size_m)
    velocity, first_cell, at_cells = read_file(path, layer)
    velocity = velocity - _velocity_of(run, followed, window)
    if across < along:  # the later axis comes first
        velocity = velocity.swapaxes(0, 1)
    if min(velocity.shape[:2]) < 2:
        raise _unusable(f"--plane {_AXES[along]}{_AXES[across]}", run, "its field is one cell thick there", "Use auto")
    components, corner = (velocity[..., along], velocity[..., across]), (first_cell[along], first_cell[across])
    shown = _shown(run, zoomed, window, (along, across), view.margin_m) if zoomed else None
    place_m, times = at_cells * run.cell_size_m, (window[0], window[1])
    return FlowPicture(along, across, place_m, *components, corner, times, view.frame, shown)


def _unusable(option: str, run: RunRecord, reason: str, advice: str) -> Stop:
    return BadCase(f"{option} does not suit {run.name} ({reason}). {advice}.")


def _time_of(run: RunRecord, view: View, snapshots: list[int], has_mean: bool) -> str | int | None:
    """The mean if there is one, else the last snapshot, unless the view names another."""
    steps = f"steps {', '.join(map(str, snapshots[-8:]))}" if snapshots else "none"
    if view.time in ("auto", "mean") and has_mean:
        return MEAN
    if view.time in ("auto", "last"):
        return snapshots[-1] if snapshots else None
    if view.time == "mean":
        raise _unusable("--time mean", run, f"it has no mean; snapshots: {steps}", "Use last, or one of them")
    if int(view.time) not in snapshots:
        raise _unusable(f"--time {view.time}", run, f"snapshots: {steps}", "Use one of them, last or mean")
    return int(view.time)


def _bodies_named(run: RunRecord, name: str, option: str) -> list[Body]:
    """The bodies of a swimmer, or a body by its name, with that of its swimmer or without it."""
    word = re.escape(name)
    for pattern in (word, rf"{word}\..*", rf".*\.{word}"):
        if found := [body for body in run.bodies if name and re.fullmatch(pattern, body.name)]:
            return found
    if name:
        known = [*dict.fromkeys(body.name.split(".")[0] for body in run.bodies), *(b.name for b in run.bodies)]
        raise _unusable(f"{option} {name}", run, f"it has {', '.join(dict.fromkeys(known[:12]))}", "Use one of them")
    return []


def _plane_of(run: RunRecord, view: View, time: str | int) -> tuple[int, int]:
    """The plane that contains the motion, unless the view names one."""
    if view.plane != "auto":
        return _AXES.index(view.plane[0]), _AXES.index(view.plane[1])
    velocity = read_file(run.directory / "fields.h5", lambda path: read_coarse(path, time))
    places = run.trajectory.all_of("position_m").reshape(-1, 3)
    return strongest_plane(velocity, np.ptp(places, axis=0) if len(places) else np.zeros(3))


def strongest_plane(velocity: np.ndarray, extent_of_bodies: np.ndarray) -> tuple[int, int]:
    """Two axes, the one with more of the motion first; where axes are alike, the plane normal to the first of them.

    An axis has a share in the energy of the flow, in its gradients, and in the extent of where the bodies go.

    @param velocity  shape (nz, ny, nx, 3)
    """
    shape = velocity.shape[2::-1]
    energy = (velocity**2).mean(axis=(0, 1, 2))
    gradients = [
        (np.gradient(velocity, axis=2 - axis) ** 2).sum(axis=-1).mean() if shape[axis] > 1 else 0.0 for axis in range(3)
    ]
    shares = sum(np.array(part) / (np.sum(part) or 1.0) for part in (energy, gradients, extent_of_bodies))
    shares = np.where(np.array(shape) > 1, shares, -1.0)  # a field that is one cell thick can be seen from one side
    normal = next(axis for axis in range(3) if shares[axis] <= shares.min() + _ALIKE)
    first, second = (axis for axis in range(3) if axis != normal)
    return (second, first) if shares[second] > shares[first] + _ALIKE else (first, second)


def _samples(run: RunRecord, window: Sequence[int]) -> np.ndarray:
    """Numbers of the samples in a window of steps, or of the one nearest to it."""
    steps = run.trajectory.steps
    inside = np.flatnonzero((steps >= window[0]) & (steps <= window[1]))
    return inside if len(inside) else np.array([abs(steps - window[0]).argmin()])


def _place_m(run: RunRecord, body: Body, window: Sequence[int]) -> np.ndarray:
    """Mean position in a window of steps, in the domain also where it is periodic."""
    samples = _samples(run, window)
    place = run.trajectory.of(body.name)["position_m"][samples[: max(1, len(samples) - 1)]].mean(axis=0)
    return np.where(run.is_periodic, np.mod(place, run.domain_m), place)


def _velocity_of(run: RunRecord, bodies: Sequence[Body], window: Sequence[int]) -> np.ndarray:
    """Of a frame that moves with the bodies [m/s]: over a window their drift; zero without bodies."""
    if not (motions := [run.trajectory.of(body.name) for body in bodies]):
        return np.zeros(3)
    ends = _samples(run, window)[[0, -1]]
    if ends[0] == ends[1]:
        return np.mean([motion["velocity_m_per_s"][ends[0]] for motion in motions], axis=0)
    time_s = np.diff(run.trajectory.time_s[ends])
    return np.mean([np.diff(motion["position_m"][ends], axis=0)[0] / time_s for motion in motions], axis=0)


def _middle_of(run: RunRecord, bodies: Sequence[Body], window: Sequence[int], normal: int) -> float:
    """Of the bodies, else of the first swimmer or body, else of the domain [m]."""
    known = run.bodies if len(run.trajectory) else []
    first = [body for body in known if body.name.split(".")[0] == known[0].name.split(".")[0]]
    places = [_place_m(run, body, window)[normal] for body in bodies or first]
    return float(np.mean(places)) if places else run.domain_m[normal] / 2


def _shown(
    run: RunRecord, bodies: Sequence[Body], window: Sequence[int], axes: tuple[int, int], margin_m: float | None
) -> tuple[float, float, float, float]:
    """The box around bodies with a margin, by default as wide as half the box is long, inside the domain."""
    places = np.array([_place_m(run, body, window) for body in bodies])
    reach = np.array([body.surface.reach_m for body in bodies])[:, None]
    low, high = (places - reach).min(axis=0), (places + reach).max(axis=0)
    margin = margin_m if margin_m is not None else 0.5 * float((high - low)[list(axes)].max())
    low, high = np.maximum(low - margin, 0.0), np.minimum(high + margin, run.domain_m)
    return low[axes[0]], high[axes[0]], low[axes[1]], high[axes[1]]


def _layout(
    run: RunRecord, picture: FlowPicture
) -> tuple[np.ndarray, np.ndarray, Sequence[float], Sequence[float], tuple[slice, slice]]:
    """Centres of the cells along and across, edges of the picture and of what is seen of it [µm], and the cells that
    are seen, across and along."""
    cell = 1e6 * run.cell_size_m
    rows, columns = picture.speed_m_per_s.shape
    left, bottom = (cell * first for first in picture.corner_cells)
    along, across = left + cell * (np.arange(columns) + 0.5), bottom + cell * (np.arange(rows) + 0.5)
    box = [left, left + cell * columns, bottom, bottom + cell * rows]
    shown = [1e6 * edge for edge in picture.shown_m] if picture.shown_m else box
    return along, across, box, shown, (_inside(across, shown[2:]), _inside(along, shown[:2]))


def top_speed_m_per_s(run: RunRecord, picture: FlowPicture) -> float:
    """Where the scale of colours ends: all but the fastest five hundredth of what is seen is slower."""
    return float(np.quantile(picture.speed_m_per_s[_layout(run, picture)[-1]], 0.998))


def draw(run: RunRecord, picture: FlowPicture, top_m_per_s: float | None = None) -> Any:
    """Speed in the plane as colour, direction as stream lines; lengths in micrometres.

    `top_m_per_s`: end of the scale of colours, by default that of this picture.
    """
    along, across, box, shown, part = _layout(run, picture)
    height = (WIDTH_INCHES - 1.9) * (shown[3] - shown[2]) / (shown[1] - shown[0]) + 0.7
    figure, axes = new_figure(min(max(height, 1.8), 7.5))
    axes.grid(False)
    top = top_speed_m_per_s(run, picture) if top_m_per_s is None else top_m_per_s
    power, prefix = prefix_of(top, -6)
    unit = 10.0**power
    scale = PowerNorm(0.5, vmin=0, vmax=max(top / unit, 1e-30))
    look: dict[str, Any] = {"origin": "lower", "extent": box, "cmap": FLOW, "interpolation": "bilinear"}
    image = axes.imshow(picture.speed_m_per_s / unit, norm=scale, **look)
    if top > 0:
        velocity = picture.velocity_along_m_per_s[part], picture.velocity_across_m_per_s[part]
        look = {"color": LIGHT.ink, "linewidth": 0.5, "arrowsize": 0.7, "density": 1.6}
        axes.streamplot(along[part[1]], across[part[0]], *velocity, **look)
    _draw_bodies(axes, run, picture)
    axes.set(xlim=shown[:2], ylim=shown[2:])
    axes.set(xlabel=f"{_AXES[picture.along]} [µm]", ylabel=f"{_AXES[picture.across]} [µm]")
    kind = "mean speed" if picture.is_mean else "speed"
    relative = f"\nrelative to {picture.frame}" if picture.frame else ""
    label = f"{kind} in the plane [{prefix}m/s]{relative}"
    place, ticks = axes.inset_axes([1.02, 0, 0.022, 1]), _round_ticks(top / unit)
    bar = colour_bar(figure, image, label, cax=place, ticks=ticks, format="%g")
    bar.minorticks_off()
    return figure


def _inside(centres: np.ndarray, edges: Sequence[float]) -> slice:
    """The cells between two edges, and one more on each side for the interpolation; at least two."""
    low = max(int(np.searchsorted(centres, edges[0])) - 1, 0)
    return slice(low, max(int(np.searchsorted(centres, edges[1])) + 1, low + 2))


def _round_ticks(top: float) -> list[float]:
    """Zero, and the largest five of 1, 2, 5, 10, … up to `top`; about even on a square-root scale."""
    if top <= 0:
        return [0.0]
    decade = int(np.floor(np.log10(top)))
    steps = [factor * 10.0**power for power in (decade - 2, decade - 1, decade) for factor in (1, 2, 5)]
    return [0.0, *[step for step in steps if step <= 1.0001 * top][-5:]]


def _draw_bodies(axes: Any, run: RunRecord, picture: FlowPicture) -> None:
    """Bodies as seen along the normal, and their images behind symmetry planes: only their outlines if they are outside
    the plane, and of obstacles where they cut it."""
    shown = [picture.along, picture.across]
    for body in run.bodies if len(run.trajectory) else []:
        triangles = body.surface.triangles
        colour = LIGHT.beads[body.place % len(LIGHT.beads)]
        for points in _with_images(run, _points_m(run, body, picture.window), shown):
            if _is_cut(run, body, picture):
                seen = 1e6 * points[triangles][:, :, shown]
                axes.add_collection(PolyCollection(seen, color=colour, linewidths=0.3, zorder=5))
                looks = {"colors": LIGHT.paper}
            else:
                looks = {"colors": colour, "linestyles": "--"}
            edges = 1e6 * points[_outline(points, triangles, picture.normal)][:, :, shown]
            axes.add_collection(LineCollection(edges, linewidths=1, zorder=5, **looks))
    surfaces = surfaces_of(run.case)
    for obstacle in run.case["surfaces"]["obstacles"]:
        surface = surfaces[obstacle["surface"]]
        points = obstacle["position_m"] + rotated(surface.points_m, obstacle["orientation_wxyz"])
        cut = 1e6 * _section(points[surface.triangles], picture.normal, picture.at_m)[:, :, shown]
        axes.add_collection(LineCollection(cut, linewidths=1.5, colors=LIGHT.ink, zorder=4))


def _points_m(run: RunRecord, body: Body, window: Sequence[int]) -> np.ndarray:
    """Of its surface, turned as in the middle of a window of steps."""
    samples = _samples(run, window)
    turn = run.trajectory.of(body.name)["orientation_wxyz"][samples[len(samples) // 2]]
    return _place_m(run, body, window) + rotated(body.surface.points_m, turn)


def _is_cut(run: RunRecord, body: Body, picture: FlowPicture) -> bool:
    """Whether the plane of the picture goes through a body."""
    heights = _points_m(run, body, picture.window)[:, picture.normal]
    return bool(heights.min() <= picture.at_m <= heights.max())


def _with_images(run: RunRecord, points: np.ndarray, axes: Sequence[int]) -> list[np.ndarray]:
    """Points of a surface, and their mirror images where planes of symmetry cut the picture."""
    images = [points]
    for axis in axes:
        length = run.domain_m[axis]
        ends = points[:, axis].min(), points[:, axis].max()
        if _AXES[axis] in (run.case["fluid"].get("symmetry_planes") or []) and abs(sum(ends) - length) > 1e-3 * length:
            mirror = np.where(np.arange(3) == axis, -1.0, 1.0)
            images += [mirror * image + np.where(mirror < 0, length, 0.0) for image in images]
    return images


def _outline(points: np.ndarray, triangles: np.ndarray, normal: int) -> np.ndarray:
    """Edges between triangles that are seen along an axis from the front and from the back, shape (edges, 2)."""
    first, second, third = points[triangles].swapaxes(0, 1)
    is_front = np.cross(second - first, third - first)[:, normal] > 0
    edges = np.sort(np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    edges, place, count = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    fronts = np.bincount(place.ravel(), np.tile(is_front, 3))
    return edges[(fronts > 0) & (fronts < count)]


def _section(corners: np.ndarray, normal: int, at_m: float) -> np.ndarray:
    """Where triangles, shape (triangles, 3, 3), meet a plane normal to an axis: shape (pieces, 2, 3)."""
    others = corners[:, [1, 2, 0]]
    crossed = (corners[..., normal] > at_m) != (others[..., normal] > at_m)  # two edges of a triangle, or none
    start, edge = corners[crossed], (others - corners)[crossed]
    share = (at_m - start[:, normal]) / edge[:, normal]
    return (start + share[:, None] * edge).reshape(-1, 2, 3)
