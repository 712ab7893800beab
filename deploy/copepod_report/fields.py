"""The mean flow of fields.h5 in a plane."""

from dataclasses import dataclass

import h5py
import numpy as np


@dataclass(frozen=True)
class FlowPlane:
    """A plane that contains the axis `along`; arrays have shape (cells across, cells along).

    Where a body was for a part of the time, its own velocity is in the mean.
    """

    along: int
    across: int
    velocity_along_m_per_s: np.ndarray
    velocity_across_m_per_s: np.ndarray


def mean_flow(path, point_cells, along, across):
    """FlowPlane of the group /mean through a point, spanned by two of the axes 0, 1, 2; None if there is no mean flow."""
    if not path.exists():
        return None
    (normal,) = {0, 1, 2} - {along, across}
    with h5py.File(path, "r") as file:
        if "mean" not in file:
            return None
        layers = _layers_at(point_cells[normal])
        velocity = np.mean([_plane(file["mean/velocity_m_per_s"], normal, layer) for layer in layers], axis=0)
    if across > along:  # arrays come with the slower axis first: (z, y, x) without the normal
        return FlowPlane(along, across, velocity[..., along], velocity[..., across])
    return FlowPlane(along, across, velocity[..., along].T, velocity[..., across].T)


def _layers_at(coordinate_cells):
    """The layer of cells that holds a coordinate, or the two beside it if it lies on their faces."""
    nearest_face = round(coordinate_cells)
    if abs(coordinate_cells - nearest_face) < 1e-6:
        return [nearest_face - 1, nearest_face]
    return [int(coordinate_cells)]


def _plane(dataset, normal, number):
    """One layer of a dataset with shape (nz, ny, nx, …)."""
    index = [slice(None)] * 3
    index[2 - normal] = number
    return dataset[tuple(index)]
