"""Figures of many swimmers together: a picture, speeds, power, orientations, distances, displacement, spectrum."""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from matplotlib.collections import LineCollection
from numpy.typing import ArrayLike

from copepod_report.cycles import centroids_m
from copepod_report.fields import read_components, times_in
from copepod_report.run_record import RunRecord, read_file
from copepod_report.style import LIGHT, VIOLET_TO_YELLOW, colour_bar, legend_above, new_figure
from copepod_report.sweeps import with_prefix
from copepod_run.figures import quantity_text

_MOST_POINTS = 200  # of a path in the picture
_MOST_LAGS = 40
_DIRECTIONS = 500
_MOST_PAIRS = 2_000_000  # of all samples together
_MOST_IN_PAIRS = 1000  # points of a sample

_Figure = tuple[Any, str] | None  # with its caption; None if there is nothing to draw


class Swarm:
    """Centroids and axes of all swimmers over time, from the trajectory; speeds by cycle, from the cycles.

    centroids_m   shape (samples, swimmers, 3)
    axes          unit vectors from the first to the last bead, shape (samples, swimmers, 3)
    along         velocity along the own axis [m/s], shape (cycles, swimmers)
    power_W       that the drives give to all swimmers, shape (samples,); power_by_cycle_W: its mean, shape (cycles,)
    periodic_length_m   of the domain, shape (3,); 0: not periodic along this axis
    """

    def __init__(self, run: RunRecord) -> None:
        self.run = run
        self.count = f"{len(run.swimmers)} swimmers"
        number = {body: place for place, body in enumerate(run.trajectory.bodies)}
        beads = [[number[f"{s.name}.{bead}"] for bead in s.bead_names] for s in run.swimmers]
        places = run.trajectory.all_of("position_m")
        self.time_s = run.trajectory.time_s
        self.centroids_m = np.stack([places[:, group].mean(axis=1) for group in beads], axis=1)
        self.has_axes = all(len(group) > 1 for group in beads)
        ends = places[:, [group[-1] for group in beads]] - places[:, [group[0] for group in beads]]
        self.axes = ends / np.maximum(np.linalg.norm(ends, axis=2, keepdims=True), 1e-300)
        driven = run.trajectory.all_of("driving_N") * run.trajectory.all_of("velocity_m_per_s")
        self.power_W = driven[:, [body for group in beads for body in group]].sum(axis=(1, 2))
        self.periodic_length_m = np.where(run.is_periodic, run.domain_m, 0.0)
        has_all = all(s.name in run.cycles for s in run.swimmers)  # of their first cycle, in a run that continues
        measured = [run.cycles[s.name] for s in run.swimmers] if has_all else []
        cycles = min((len(each["cycle"]) for each in measured), default=0)
        self.along = np.array([each["u_along_m_per_s"][:cycles] for each in measured]).reshape(len(measured), cycles).T
        self.period_s = float(np.diff(measured[0]["start_s"][:2])[0]) if cycles > 1 else 0.0
        powers = np.array([each["power_W"][:cycles] for each in measured])
        self.power_by_cycle_W = powers.sum(axis=0) if np.isfinite(powers).all() else np.empty(0)
        self.snapshots, _ = read_file(run.directory / "fields.h5", times_in)
        self.moved_m = [centroids_m(each)[: cycles + 1] for each in measured] if cycles > 3 else []

    def figures(self) -> Iterator[tuple[str, Any, str]]:
        """(name, figure, caption) of every figure for which there is something to draw."""
        for name in ("swarm", "speeds", "power", "orientations", "pairs", "spreading", "spectrum"):
            if found := getattr(self, f"_{name}")():
                yield name, found[0], found[1]

    def _swarm(self) -> _Figure:
        last = self.centroids_m[-1]
        extent = np.ptp(self.centroids_m, axis=(0, 1))
        first, second = sorted(np.argsort(-extent, kind="stable")[:2])
        ratio = extent[second] / extent[first] if extent[first] > 0 else 1.0
        figure, axes = new_figure(1.0 + 5.6 * min(max(ratio, 0.4), 1.2))
        every = max(1, len(self.time_s) // _MOST_POINTS)
        paths = 1e6 * self.centroids_m[::every][:, :, [first, second]].swapaxes(0, 1)
        axes.add_collection(LineCollection(list(paths), colors=LIGHT.faint, linewidths=1.0))
        length = 0.7e6 * max(extent[first], extent[second]) / np.sqrt(len(last))
        speeds = 1e6 * self.along[-1] if len(self.along) else np.zeros(len(last))
        middles, arrows_um = 1e6 * last[:, [first, second]].T, length * self.axes[-1][:, [first, second]].T
        look = {"cmap": VIOLET_TO_YELLOW, "angles": "xy", "scale_units": "xy", "scale": 1, "pivot": "mid"}
        arrows = axes.quiver(*middles, *arrows_um, speeds, width=0.005, **look)
        axes.set_aspect("equal", adjustable="datalim")
        axes.margins(0.08)
        axes.set(xlabel=f"{'xyz'[first]} [µm]", ylabel=f"{'xyz'[second]} [µm]")
        if len(self.along):
            colour_bar(figure, arrows, "velocity along the own axis [µm/s]", ax=axes, shrink=0.8)
        return figure, (
            f"{self.count} from the side on which they are spread most: an arrow from tail to head of each, in the "
            "colour of its velocity in the last cycle, and its path since the start."
        )

    def _speeds(self) -> _Figure:
        if not len(self.along):
            return None
        along = 1e6 * self.along
        figure, (by_cycle, distribution) = new_figure(3.2, ncols=2, width_ratios=(3, 2))
        cycles = np.arange(len(along))
        by_cycle.fill_between(cycles, *np.quantile(along, (0.1, 0.9), axis=1), color=LIGHT.beads[0], alpha=0.25)
        by_cycle.plot(cycles, along.mean(axis=1), "o-", color=LIGHT.beads[0], markersize=4)
        by_cycle.set(xlabel="cycle", ylabel="velocity along the own axis [µm/s]")
        by_cycle.xaxis.get_major_locator().set_params(integer=True)
        distribution.hist(along[-1], bins="auto", histtype="stepfilled", color=LIGHT.beads[0], alpha=0.8)
        distribution.set(xlabel=f"in cycle {len(along) - 1} [µm/s]", ylabel="swimmers")
        distribution.yaxis.get_major_locator().set_params(integer=True)
        distribution.locator_params(axis="x", nbins=5)
        text = f"Velocities of {self.count} along their own axes: mean and middle 80 % by cycle; all in the last cycle."
        return figure, text

    def _power(self) -> _Figure:
        if not self.power_W.any():
            return None
        unit, name = with_prefix(np.abs(self.power_W), "W")
        figure, axes = new_figure(3.0)
        axes.plot(1e6 * self.time_s, unit * self.power_W, color=LIGHT.beads[0], linewidth=0.8, label="sampled")
        mean = ""
        if self.period_s > 0 and len(self.power_by_cycle_W) > 0:
            edges = 1e6 * self.period_s * np.arange(len(self.power_by_cycle_W) + 1)
            look = {"color": LIGHT.beads[1], "linewidth": 2, "label": "cycle mean"}
            axes.stairs(unit * self.power_by_cycle_W, edges, baseline=None, **look)
            mean = f" (in the last: {quantity_text(self.power_by_cycle_W[-1], 'W')})"
        axes.axhline(0, color=LIGHT.faint, linewidth=1)
        axes.set(xlabel="time [µs]", ylabel=f"power of all drives [{name}]")
        legend_above(axes)
        return figure, f"Power that the drives give to {self.count} together, and its mean over each cycle{mean}."

    def _pairs(self) -> _Figure:
        distances_m, ratio = pair_distribution(self.centroids_m[len(self.time_s) // 2 :], self.periodic_length_m)
        if len(distances_m) == 0:
            return None
        figure, axes = new_figure(3.0)
        axes.axhline(1, color=LIGHT.ink, linewidth=1, linestyle=":")
        axes.plot(1e6 * distances_m, ratio, "-", color=LIGHT.beads[0], linewidth=1.6)
        axes.set(xlim=(0, None), ylim=(0, None), xlabel="distance of centroids [µm]", ylabel="pair distribution")
        return figure, (
            f"Pair distribution of the centroids of {self.count} in the second half of the samples: number of pairs at "
            "a distance, relative to points spread evenly over the same box."
        )

    def polar_order(self) -> np.ndarray:
        """Length of the mean axis, shape (samples,)."""
        return np.linalg.norm(self.axes.mean(axis=1), axis=1)

    def nematic_order(self) -> np.ndarray:
        """Largest eigenvalue of the mean of (3 e eᵀ − 1)/2, shape (samples,)."""
        squares = np.einsum("tsi,tsj->tij", self.axes, self.axes) / self.axes.shape[1]
        return np.linalg.eigvalsh(1.5 * squares - 0.5 * np.eye(3))[:, -1]

    def _orientations(self) -> _Figure:
        if not self.has_axes:
            return None
        figure, (order, distribution) = new_figure(3.2, ncols=2, width_ratios=(3, 2))
        order.plot(1e6 * self.time_s, self.polar_order(), color=LIGHT.beads[0], linewidth=1.4, label="polar")
        order.plot(1e6 * self.time_s, self.nematic_order(), color=LIGHT.beads[1], linewidth=1.4, label="nematic")
        order.set(ylim=(0, 1.02), xlabel="time [µs]", ylabel="order")
        legend_above(order)
        mean = self.axes[-1].mean(axis=0)
        cosines = self.axes[-1] @ mean / max(float(np.linalg.norm(mean)), 1e-300)
        angles = np.degrees(np.arccos(np.clip(cosines, -1, 1)))
        distribution.hist(angles, bins=18, range=(0, 180), histtype="stepfilled", color=LIGHT.beads[0])
        distribution.set(xlabel="angle to the mean axis [degrees]", ylabel="swimmers")
        distribution.set_xticks([0, 45, 90, 135, 180])
        distribution.yaxis.get_major_locator().set_params(integer=True)
        return figure, (
            f"Order of {self.count}: polar (length of the mean axis, 1 if all point one way) and nematic (heads and "
            "tails alike); angles between the axes at the end and their mean."
        )

    def mean_square_displacement(self) -> tuple[np.ndarray, np.ndarray]:
        """(lags [s], mean over swimmers and starts [m²]); from cycle to cycle once there are some, else by sample."""
        if self.moved_m:
            places, step_s = np.stack(self.moved_m, axis=1), self.period_s
        else:
            every = max(1, len(self.time_s) // _MOST_POINTS)
            places, step_s = self.centroids_m[::every], float(self.time_s[every] - self.time_s[0])
        lags = np.unique(np.geomspace(1, len(places) - 1, _MOST_LAGS).astype(int))
        squares = [((places[lag:] - places[:-lag]) ** 2).sum(axis=2).mean() for lag in lags]
        return lags * step_s, np.array(squares)

    def _spreading(self) -> _Figure:
        if len(self.time_s) < 3:
            return None
        lags_s, squares_m2 = self.mean_square_displacement()
        if not squares_m2.all():  # nothing has moved
            return None
        figure, axes = new_figure(3.4)
        axes.loglog(1e6 * lags_s, 1e12 * squares_m2, "o-", color=LIGHT.beads[0], markersize=3, linewidth=1.2)
        for slope, label in ((2, "ballistic"), (1, "diffusive")):
            line = squares_m2[0] * (lags_s / lags_s[0]) ** slope
            axes.loglog(1e6 * lags_s, 1e12 * line, ":", color=LIGHT.ink, linewidth=1)
            end = (1e6 * lags_s[-1], 1e12 * line[-1])
            axes.annotate(label, end, color=LIGHT.ink, fontsize=8, ha="right", va="bottom")
        axes.set(xlabel="time between two samples [µs]", ylabel="mean-square displacement [µm²]")
        return figure, f"Mean-square displacement of the centroids of {self.count}; dotted: ballistic and diffusive."

    def _spectrum(self) -> _Figure:
        """None for a flow that is at rest or uniform, too."""
        if not self.snapshots:
            return None
        step = self.snapshots[-1]
        components, cells = read_file(self.run.directory / "fields.h5", lambda path: read_components(path, step))
        domain = self.run.case["fluid"]["domain_cells"]
        whole = np.multiply(components[0].shape[::-1], cells) > np.array(domain) - cells  # else only a part is recorded
        periodic = np.logical_and(self.run.is_periodic, whole)
        k, density = energy_spectrum(components, cells * self.run.cell_size_m, periodic[::-1])
        if not density.any():
            return None
        figure, axes = new_figure(3.4)
        axes.loglog(1e-6 * k, 1e18 * density, "o-", color=LIGHT.beads[0], markersize=3, linewidth=1.2)
        axes.set(xlabel="wave number [1/µm]", ylabel="E(k) [µm³/s²]")
        return figure, (
            f"Energy spectrum of the flow at step {step}: kinetic energy per mass and wave number in the recorded box, "
            "bodies included."
        )


def pair_distribution(
    points_m: np.ndarray, periodic_length_m: ArrayLike, bins: int = 40
) -> tuple[np.ndarray, np.ndarray]:
    """(distances r [m], g(r)): number of pairs at a distance over that of points spread evenly over the box.

    The box is as long as the domain along periodic axes, and as long as the points are apart along others; axes along
    which it is flat do not count. Evenly spread points have N² S(r) γ(r)/(2 V) dr pairs at r, with the surface S of a
    sphere and the share γ of the box that overlaps with the box moved by r, averaged over directions.

    @param points_m           shape (samples, points, 3)
    @param periodic_length_m  of the domain; 0: not periodic along this axis
    @return empty arrays where all points coincide, or there is one only
    """
    points_m = points_m[:, :: max(1, -(-points_m.shape[1] // _MOST_IN_PAIRS))]
    count = points_m.shape[1]
    pairs = count * (count - 1) // 2
    periods = np.array(periodic_length_m, float)
    lengths = np.where(periods > 0, periods, np.ptp(points_m, axis=(0, 1)))
    axes = np.flatnonzero(lengths > 1e-3 * lengths.max())
    if pairs == 0 or len(axes) == 0:
        return np.empty(0), np.empty(0)
    lengths, periods = lengths[axes], periods[axes]
    reach = 0.5 * min([lengths.max(), *periods[periods > 0]])
    points_m = points_m[:: max(1, -(-pairs * len(points_m) // _MOST_PAIRS))][..., axes]
    edges = np.linspace(0.0, reach, bins + 1)
    first, second = np.triu_indices(count, 1)
    found = np.zeros(bins)
    for sample in points_m:
        apart = sample[second] - sample[first]
        apart -= periods * np.round(apart / np.where(periods > 0, periods, 1.0))
        found += np.histogram(np.linalg.norm(apart, axis=1), edges)[0]
    middle = 0.5 * (edges[:-1] + edges[1:])
    volume = np.diff(edges ** len(axes)) * (2.0, np.pi, 4 / 3 * np.pi)[len(axes) - 1]  # of a shell
    overlap = 1 - middle[:, None, None] * np.abs(_directions(len(axes))) / np.where(periods > 0, np.inf, lengths)
    evenly = pairs * len(points_m) * volume * np.clip(overlap, 0, 1).prod(axis=2).mean(axis=1) / lengths.prod()
    return middle, found / evenly


def _directions(dimensions: int) -> np.ndarray:
    """Unit vectors in every direction, shape (directions, dimensions)."""
    angle = np.pi * (1 + np.sqrt(5)) * (np.arange(_DIRECTIONS) + 0.5)  # a spiral in three dimensions
    if dimensions == 1:
        return np.ones((1, 1))
    if dimensions == 2:
        angle = 2 * np.pi * (np.arange(_DIRECTIONS) + 0.5) / _DIRECTIONS
        return np.column_stack([np.cos(angle), np.sin(angle)])
    z = 1 - 2 * (np.arange(_DIRECTIONS) + 0.5) / _DIRECTIONS
    radius = np.sqrt(1 - z * z)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), z])


def energy_spectrum(
    components_m_per_s: Iterable[np.ndarray], cell_m: float, periodic: ArrayLike
) -> tuple[np.ndarray, np.ndarray]:
    """(wave numbers k [1/m], E(k) [m³/s²]): ∫ E dk is the mean of u²/2, but for what is uniform in the box.

    E(k) dk sums |û|²/2 over the modes of a shell of thickness dk [Pope 2000, section 6.5]. Modes are exp(2πi n x/L)
    along periodic axes and cos(πn x/L) along others, where the flow beyond a face is its mirror image. dk is
    the widest distance of two modes along an axis.

    @param components_m_per_s  u_x, u_y, u_z of the box, shape (cells along axis 0, 1, 2) each
    @param periodic            by axis of these arrays
    @return empty arrays for a box of one cell
    """
    import scipy.fft  # most reports need none

    is_periodic = np.asarray(periodic, bool)
    energy = np.zeros(())
    for component in components_m_per_s:
        modes = scipy.fft.dctn(np.asarray(component, float), axes=np.flatnonzero(~is_periodic), norm="ortho")
        modes = scipy.fft.fftn(modes, axes=np.flatnonzero(is_periodic), norm="ortho")
        energy = energy + 0.5 * np.abs(modes) ** 2 / modes.size
    if energy.size == 1:
        return np.empty(0), np.empty(0)
    spacings = np.where(is_periodic, 2, 1) * np.pi / np.multiply(energy.shape, cell_m)
    width = spacings[np.greater(energy.shape, 1)].max()
    square = np.zeros(())
    for count, spacing, around in zip(energy.shape, spacings, is_periodic):
        n = np.arange(count)
        square = np.add.outer(square, (spacing * (np.minimum(n, count - n) if around else n)) ** 2)
    shell = np.maximum(np.rint(np.sqrt(square) / width).astype(int).ravel(), 1)
    shell[0] = 0  # what is uniform
    shells = np.bincount(shell, energy.ravel())
    return width * np.arange(1, len(shells)), shells[1:] / width
