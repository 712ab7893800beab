"""How likely a swimmer has another one at a distance, compared with points spread evenly over the same box."""

import numpy as np
from numpy.typing import ArrayLike

_DIRECTIONS = 500
_MOST_PAIRS = 2_000_000  # of all samples together
_MOST_POINTS = 1000  # of a sample


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
    points_m = points_m[:, :: max(1, -(-points_m.shape[1] // _MOST_POINTS))]
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
