"""fields.h5: the flow at a step or as a mean over steps. The only place where a report reads this file."""

from pathlib import Path
from typing import Any

import h5py
import numpy as np

MEAN = "mean"
_SNAPSHOT = "step_"
_VELOCITY = "velocity_m_per_s"
_COARSE = 24  # points along each axis of a look at the whole domain
_MOST_VALUES = 8_000_000  # of a component of the velocity that is read whole


def times_in(path: Path) -> tuple[list[int], bool]:
    """What the velocity is recorded of: the steps of snapshots, and whether there is a mean; nothing without a file.

    Raises OSError if it is damaged, or being written.
    """
    if not path.exists():
        return [], False
    with _opened(path) as file:
        groups = [name for name in file if _VELOCITY in file[name]]
        steps = sorted(int(name.removeprefix(_SNAPSHOT)) for name in groups if name.startswith(_SNAPSHOT))
        return steps, MEAN in groups


def read_layer(
    path: Path, time: str | int, normal: int, coordinate_cells: float
) -> tuple[np.ndarray, list[int], float]:
    """The plane normal to an axis (0, 1, 2) nearest to a coordinate; `time`: «mean» or the step of a snapshot.

    On a face between two layers of cells it is their mean.

    @return velocity [m/s], shape (rows, columns, 3), the later axis of the plane first; first cell of the recorded box
            along x, y, z; coordinate of the plane along its normal [cells]
    """
    with _opened(path) as file:
        velocity = _velocity_in(file, time)
        first = [int(velocity.parent.attrs.get(f"first_cell_{axis}", 0)) for axis in "xyz"]  # of a part of the domain
        inside = coordinate_cells - first[normal]
        cells, face = velocity.shape[2 - normal], round(inside)
        is_on_face = abs(inside - face) < 1e-6 and 0 < face < cells
        layers = [face - 1, face] if is_on_face else [min(max(int(inside), 0), cells - 1)]
        before = (slice(None),) * (2 - normal)
        mean = np.mean([velocity[(*before, layer)] for layer in layers], axis=0)
        return mean, first, first[normal] + float(np.mean(layers)) + 0.5


def read_coarse(path: Path, time: str | int) -> np.ndarray:
    """Velocity [m/s] at some points all over the recorded box, shape (nz, ny, nx, 3)."""
    with _opened(path) as file:
        velocity = _velocity_in(file, time)
        strides = [max(1, cells // _COARSE) for cells in velocity.shape[:3]]
        layers = range(strides[0] // 2, velocity.shape[0], strides[0])
        rows, columns = (slice(stride // 2, None, stride) for stride in strides[1:])
        return np.array([velocity[layer][rows, columns] for layer in layers])


def read_components(path: Path, step: int) -> tuple[list[np.ndarray], int]:
    """u_x, u_y, u_z [m/s] of the recorded box, shape (nz, ny, nx) each, and how many cells long each of its values is.

    More than a few million cells are averaged over blocks.
    """
    with _opened(path) as file:
        velocity = _velocity_in(file, step)
        cells = velocity.shape[:3]
        block = 1
        while np.prod([max(1, count // block) for count in cells]) > _MOST_VALUES:
            block += 1
        blocks = [min(block, count) for count in cells]
        kept = [count // length for count, length in zip(cells, blocks)]
        rows, columns = (count * length for count, length in zip(kept[1:], blocks[1:]))
        result = np.empty((*kept, 3))
        for layer in range(kept[0]):
            part = velocity[layer * blocks[0] : (layer + 1) * blocks[0], :rows, :columns]
            result[layer] = part.reshape(-1, kept[1], blocks[1], kept[2], blocks[2], 3).mean(axis=(0, 2, 4))
        return [result[..., axis] for axis in range(3)], block


def _opened(path: Path) -> Any:
    return h5py.File(path, "r", locking=False)  # the run that writes it must not fail because of a reader


def _velocity_in(file: Any, time: str | int) -> Any:
    return file[MEAN if time == MEAN else f"{_SNAPSHOT}{time:09d}"][_VELOCITY]
