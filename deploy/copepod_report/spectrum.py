"""How the kinetic energy of a flow is spread over wave numbers."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike


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
    is_periodic = np.asarray(periodic, bool)
    k = np.empty(0)
    densities = []
    for component in components_m_per_s:
        shape = component.shape
        axes = [axis for axis in range(3) if shape[axis] > 1]
        if not axes:
            break
        modes = np.asarray(component, float)
        for axis in (axis for axis in axes if not is_periodic[axis]):
            modes = _cosine_modes(modes, axis)
        around = [axis for axis in axes if is_periodic[axis]]
        modes = np.fft.fftn(modes, axes=around, norm="ortho") if around else modes
        energy = 0.5 * np.abs(modes) ** 2 / modes.size
        spacings = [(2 if is_periodic[axis] else 1) * np.pi / (shape[axis] * cell_m) for axis in axes]
        width = max(spacings)
        square = np.zeros(())
        for axis, spacing in zip(axes, spacings):
            n = np.arange(shape[axis])
            n = np.minimum(n, shape[axis] - n) if is_periodic[axis] else n
            square = np.add.outer(square, (spacing * n) ** 2)
        shell = np.maximum(np.rint(np.sqrt(square) / width).astype(int).ravel(), 1)
        shell[0] = 0  # what is uniform
        shells = np.bincount(shell, energy.ravel())
        k = width * np.arange(1, len(shells))
        densities.append(shells[1:] / width)
    return k, np.sum(densities, axis=0) if densities else k


def _cosine_modes(values: np.ndarray, axis: int) -> np.ndarray:
    """DCT-II with the same sum of squares, by a Fourier transform of the same length [Makhoul 1980]."""
    values = np.moveaxis(values, axis, -1)
    count = values.shape[-1]
    folded = np.fft.fft(np.concatenate([values[..., ::2], values[..., 1::2][..., ::-1]], axis=-1))
    modes = (folded * np.exp(-0.5j * np.pi * np.arange(count) / count)).real * np.sqrt(2.0 / count)
    modes[..., 0] *= np.sqrt(0.5)
    return np.moveaxis(modes, -1, axis)
