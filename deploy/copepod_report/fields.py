"""The mean flow of fields.h5 in a plane through the middle of the domain."""

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


def mean_flow(path, domain_cells, along):
    """FlowPlane of the group /mean with the axis `along` (0, 1, 2 for x, y, z), or None if there is no mean flow."""
    if not path.exists():
        return None
    with h5py.File(path, "r") as file:
        if "mean" not in file:
            return None
        normal, across = [axis for axis in (0, 1, 2) if axis != along]
        planes = _middle_planes(domain_cells[normal])
        velocity = np.mean([_plane(file["mean/velocity_m_per_s"], normal, number) for number in planes], axis=0)
    if across > along:  # arrays come with the slower axis first: (z, y, x) without the normal
        return FlowPlane(along, across, velocity[..., along], velocity[..., across])
    return FlowPlane(along, across, velocity[..., along].T, velocity[..., across].T)


def _middle_planes(cells):
    """The cell layer in the middle, or the two layers beside a middle that lies on cell faces."""
    return [cells // 2] if cells % 2 else [cells // 2 - 1, cells // 2]


def _plane(dataset, normal, number):
    """One layer of a dataset with shape (nz, ny, nx, …)."""
    index = [slice(None)] * 3
    index[2 - normal] = number
    return dataset[tuple(index)]
