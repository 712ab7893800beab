"""Pictures of the flow in a plane: what they show is chosen by the user, or from flow and bodies; and the drawing."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib import patches
from matplotlib.colors import PowerNorm
from matplotlib.ticker import NullLocator

from copepod_report.fields import MEAN, FieldTimes, read_coarse, read_layer, times_in
from copepod_report.run_record import Body, RunRecord, read_file, z_axis
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
        if self.is_mean:
            when = f"mean over steps {self.window[0]} to {self.window[1]} ({times[0]} to {times[1]})"
            bodies = "bodies at their mean positions; where one was for a part of the time, its velocity is in the mean"
        else:
            when, bodies = f"step {self.window[0]} ({times[0]})", ""
        frame = f"relative to the velocity of {self.frame}" if self.frame else "in the laboratory frame"
        if not all(_is_cut(run, body, self) for body in run.bodies() if len(run.trajectory)):
            bodies = "; ".join(filter(None, [bodies, "dashed: outside the plane"]))
        return f"{'; '.join(filter(None, [f'Flow in the {plane}, {when}, {frame}', bodies]))}."


def choose(run: RunRecord, view: View) -> FlowPicture | None:
    """The picture of a run; None if it recorded no velocity.

    Raises Stop(2) if the run lacks what the view names, Stop(73) if its file is damaged.
    """
    path = run.directory / "fields.h5"
    times = read_file(path, times_in)
    found = _time_of(run, view, times)
    if found is None:
        return None
    time = found
    window = tuple(run.case["output"]["fields"]["mean_over_steps"]) if time == MEAN else (int(time), int(time))
    zoomed, followed = _bodies_named(run, view.zoom, "--zoom"), _bodies_named(run, view.frame, "--frame")
    along, across = _plane_of(run, view, time)
    normal = 3 - along - across
    at_m = view.at_m if view.at_m is not None else _middle_of(run, zoomed or followed, window, normal)
    length_m = run.domain_m[normal]
    if not 0 <= at_m <= length_m:
        raise _unusable(f"--at {at_m:g}", run, f"its domain ends at {_AXES[normal]} = {length_m:g} m", "Choose less")
    layer = read_file(path, lambda path: read_layer(path, time, normal, at_m / run.cell_size_m))
    velocity = layer.velocity_m_per_s - _velocity_of(run, followed, window)
    if across < along:  # the later axis comes first
        velocity = velocity.swapaxes(0, 1)
    if min(velocity.shape[:2]) < 2:
        raise _unusable(f"--plane {_AXES[along]}{_AXES[across]}", run, "its field is one cell thick there", "Use auto")
    return FlowPicture(
        along,
        across,
        layer.at_cells * run.cell_size_m,
        velocity[..., along],
        velocity[..., across],
        (layer.first_cell[along], layer.first_cell[across]),
        (window[0], window[1]),
        view.frame,
        _shown(run, zoomed, window, (along, across), view.margin_m) if zoomed else None,
    )


def _unusable(option: str, run: RunRecord, reason: str, advice: str) -> Stop:
    return BadCase(f"{option} does not suit {run.name} ({reason}). {advice}.")


def _time_of(run: RunRecord, view: View, times: FieldTimes) -> str | int | None:
    """The mean if there is one, else the last snapshot, unless the view names another."""
    steps = f"steps {', '.join(map(str, times.steps[-8:]))}" if times.steps else "none"
    if view.time in ("auto", "mean") and times.has_mean:
        return MEAN
    if view.time in ("auto", "last"):
        return times.steps[-1] if times.steps else None
    if view.time == "mean":
        raise _unusable("--time mean", run, f"it has no mean; snapshots: {steps}", "Use last, or one of them")
    if int(view.time) not in times.steps:
        raise _unusable(f"--time {view.time}", run, f"snapshots: {steps}", "Use one of them, last or mean")
    return int(view.time)


def _bodies_named(run: RunRecord, name: str, option: str) -> list[Body]:
    """The bodies of a swimmer, or a body by its name, with that of its swimmer or without it."""
    for matches in (
        lambda body: body.name == name,
        lambda body: body.name.startswith(f"{name}."),
        lambda body: body.name.endswith(f".{name}"),
    ):
        found = [body for body in run.bodies() if name and matches(body)]
        if found:
            return found
    if name:
        known = [*dict.fromkeys(body.name.split(".")[0] for body in run.bodies()), *(b.name for b in run.bodies())]
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
    shares = sum(_shares(np.array(part)) for part in (energy, gradients, extent_of_bodies))
    shares = np.where(np.array(shape) > 1, shares, -1.0)  # a field that is one cell thick can be seen from one side
    normal = next(axis for axis in range(3) if shares[axis] <= shares.min() + _ALIKE)
    first, second = (axis for axis in range(3) if axis != normal)
    return (second, first) if shares[second] > shares[first] + _ALIKE else (first, second)


def _shares(parts: np.ndarray) -> np.ndarray:
    return parts / parts.sum() if parts.sum() > 0 else np.zeros(3)


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
    samples = _samples(run, window)
    velocities = []
    for body in bodies:
        motion = run.trajectory.of(body.name)
        if len(samples) > 1:
            first, last = samples[0], samples[-1]
            times = run.trajectory.time_s
            velocities.append((motion["position_m"][last] - motion["position_m"][first]) / (times[last] - times[first]))
        else:
            velocities.append(motion["velocity_m_per_s"][samples[0]])
    return np.mean(velocities, axis=0) if velocities else np.zeros(3)


def _middle_of(run: RunRecord, bodies: Sequence[Body], window: Sequence[int], normal: int) -> float:
    """Of the bodies, else of the first swimmer or body, else of the domain [m]."""
    known = run.bodies() if len(run.trajectory) else []
    first = [body for body in known if body.name.split(".")[0] == known[0].name.split(".")[0]]
    places = [_place_m(run, body, window)[normal] for body in bodies or first]
    return float(np.mean(places)) if places else run.domain_m[normal] / 2


def _shown(
    run: RunRecord, bodies: Sequence[Body], window: Sequence[int], axes: tuple[int, int], margin_m: float | None
) -> tuple[float, float, float, float]:
    """The box around bodies with a margin, by default as wide as half the box is long, inside the domain."""
    places = np.array([_place_m(run, body, window) for body in bodies])
    reach = np.array([body.radius_m + 0.5 * body.length_m for body in bodies])[:, None]
    low, high = (places - reach).min(axis=0), (places + reach).max(axis=0)
    margin = margin_m if margin_m is not None else 0.5 * float((high - low)[list(axes)].max())
    low, high = np.maximum(low - margin, 0.0), np.minimum(high + margin, run.domain_m)
    return low[axes[0]], high[axes[0]], low[axes[1]], high[axes[1]]


@dataclass(frozen=True)
class _Layout:
    """Where the cells of a picture and its edges are [µm]."""

    along: np.ndarray
    across: np.ndarray
    box: Sequence[float]
    shown: Sequence[float]
    part: tuple[slice, slice]  # the cells that are seen, across and along


def _layout(run: RunRecord, picture: FlowPicture) -> _Layout:
    cell = 1e6 * run.cell_size_m
    rows, columns = picture.speed_m_per_s.shape
    left, bottom = (cell * first for first in picture.corner_cells)
    along, across = left + cell * (np.arange(columns) + 0.5), bottom + cell * (np.arange(rows) + 0.5)
    box = [left, left + cell * columns, bottom, bottom + cell * rows]
    shown = [1e6 * edge for edge in picture.shown_m] if picture.shown_m else box
    return _Layout(along, across, box, shown, (_inside(across, shown[2:]), _inside(along, shown[:2])))


def top_speed_m_per_s(run: RunRecord, picture: FlowPicture) -> float:
    """Where the scale of colours ends: all but the fastest five hundredth of what is seen is slower."""
    return float(np.quantile(picture.speed_m_per_s[_layout(run, picture).part], 0.998))


def draw(run: RunRecord, picture: FlowPicture, top_m_per_s: float | None = None) -> Any:
    """Speed in the plane as colour, direction as stream lines; lengths in micrometres.

    `top_m_per_s`: end of the scale of colours, by default that of this picture.
    """
    layout = _layout(run, picture)
    along, across, box, shown, part = layout.along, layout.across, layout.box, layout.shown, layout.part
    rows_shown, columns_shown = part
    height = (WIDTH_INCHES - 1.9) * (shown[3] - shown[2]) / (shown[1] - shown[0]) + 0.7
    figure, axes = new_figure(LIGHT, min(max(height, 1.8), 7.5))
    axes.grid(False)
    top = top_speed_m_per_s(run, picture) if top_m_per_s is None else top_m_per_s
    power, prefix = prefix_of(top, -6)
    unit = 10.0**power
    image = axes.imshow(
        picture.speed_m_per_s / unit,
        origin="lower",
        extent=box,
        cmap=FLOW,
        interpolation="bilinear",
        norm=PowerNorm(0.5, vmin=0, vmax=max(top / unit, 1e-30)),
    )
    if top > 0:
        velocity = picture.velocity_along_m_per_s[part], picture.velocity_across_m_per_s[part]
        look = {"color": LIGHT.ink, "linewidth": 0.5, "arrowsize": 0.7, "density": 1.6}
        axes.streamplot(along[columns_shown], across[rows_shown], *velocity, **look)
    _draw_bodies(axes, run, picture)
    axes.set(xlim=shown[:2], ylim=shown[2:])
    axes.set(xlabel=f"{_AXES[picture.along]} [µm]", ylabel=f"{_AXES[picture.across]} [µm]")
    kind = "mean speed" if picture.is_mean else "speed"
    relative = f"\nrelative to {picture.frame}" if picture.frame else ""
    label = f"{kind} in the plane [{prefix}m/s]{relative}"
    bar = colour_bar(figure, image, label, cax=axes.inset_axes([1.02, 0, 0.022, 1]), ticks=_round_ticks(top / unit))
    bar.ax.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    bar.ax.yaxis.set_minor_locator(NullLocator())
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
    """Outlines of the bodies, and of their images behind symmetry planes; dashed for those outside the plane."""
    shown = [picture.along, picture.across]
    for body in run.bodies() if len(run.trajectory) else []:
        centre, direction = _place_m(run, body, picture.window), _direction(run, body, picture.window)
        colour = LIGHT.beads[body.place % len(LIGHT.beads)]
        looks: dict[str, Any] = {"facecolor": colour, "edgecolor": LIGHT.paper, "linewidth": 1, "zorder": 5}
        if not _is_cut(run, body, picture):
            looks |= {"facecolor": "none", "edgecolor": colour, "linestyle": "--"}
        for place in _with_images(run, centre, shown):
            axes.add_patch(_outline(body, 1e6 * place[shown], direction[shown], **looks))


def _direction(run: RunRecord, body: Body, window: Sequence[int]) -> np.ndarray:
    """Of its z axis, in the middle of a window of steps."""
    samples = _samples(run, window)
    return z_axis(run.trajectory.of(body.name)["orientation_wxyz"][samples[len(samples) // 2]])


def _is_cut(run: RunRecord, body: Body, picture: FlowPicture) -> bool:
    """Whether the plane of the picture goes through a body."""
    reach = body.radius_m + 0.5 * body.length_m * abs(_direction(run, body, picture.window)[picture.normal])
    return bool(abs(_place_m(run, body, picture.window)[picture.normal] - picture.at_m) <= reach)


def _with_images(run: RunRecord, centre: np.ndarray, axes: Sequence[int]) -> list[np.ndarray]:
    """A centre, and its mirror images where planes of symmetry cut the picture."""
    places = [centre]
    for axis in axes:
        if _AXES[axis] in (run.case["fluid"].get("symmetry_planes") or []):
            length = run.domain_m[axis]
            for place in list(places):
                image = place.copy()
                image[axis] = length - place[axis]
                if abs(image[axis] - place[axis]) > 1e-6 * length:
                    places.append(image)
    return places


def _outline(body: Body, centre_um: np.ndarray, direction: np.ndarray, **looks: Any) -> Any:
    """A circle, or a capsule as a box with round ends, as seen along the normal of the plane."""
    radius = 1e6 * body.radius_m
    half = 0.5e6 * body.length_m * float(np.hypot(*direction))
    if half == 0:
        return patches.Circle(tuple(centre_um), radius, **looks)
    angle = np.arctan2(direction[1], direction[0])
    arc = np.linspace(-np.pi / 2, np.pi / 2, 24)
    end = np.column_stack([half + radius * np.cos(arc), radius * np.sin(arc)])
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return patches.Polygon(np.vstack([end, -end]) @ turn.T + centre_um, closed=True, **looks)
