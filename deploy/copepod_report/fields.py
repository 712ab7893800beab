"""The mean flow of fields.h5 in a plane through the middle of the domain."""

from dataclasses import dataclass

import h5py
import numpy as np


@dataclass(frozen=True)
class FlowPlane:
    """A plane that contains the axis `along`, seen from the axis `normal`; arrays have shape (across, along)."""

    along: int
    across: int
    velocity_along_m_per_s: np.ndarray
    velocity_across_m_per_s: np.ndarray
    solid: np.ndarray              # cells that a body covered


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
        solid = np.any([_plane(file["mean/body"], normal, number) > 0 for number in planes], axis=0) \
            if "body" in file["mean"] else np.zeros(velocity.shape[:2], bool)
    if across > along:   # arrays come with the slower axis first: (z, y, x) without the normal
        return FlowPlane(along, across, velocity[..., along], velocity[..., across], solid)
    return FlowPlane(along, across, velocity[..., along].T, velocity[..., across].T, solid.T)


def _middle_planes(cells):
    """The cell layer in the middle, or the two layers beside a middle that lies on cell faces."""
    return [cells // 2] if cells % 2 else [cells // 2 - 1, cells // 2]


def _plane(dataset, normal, number):
    """One layer of a dataset with shape (nz, ny, nx, …)."""
    index = [slice(None)] * 3
    index[2 - normal] = number
    return dataset[tuple(index)]
