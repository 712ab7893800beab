#!/usr/bin/env python3
"""Random flow without divergence, as the start of decaying turbulence (docs/flows.md):

    deploy/copepod python examples/python/solenoidal_flow.py flow.h5 --cells 64 64 64 --length 0.0628 --speed 0.05

and in the case, which has three periodic axes and the same cells:

    initial_flow: {kind: file, file: flow.h5}

The energy of the waves of wave number k is  E(k) ∝ k⁴ exp(−2 (k/k₀)²),  largest at k₀; their phases and directions are
drawn. Divergence is zero for derivatives by Fourier series, and the pressure is the one that keeps it zero:
    ∇²p = −ρ Σ_ij ∂u_i/∂x_j ∂u_j/∂x_i
"""

import argparse

import h5py
import numpy as np


def wave_numbers(cells, cell_m):
    """k of each wave of a real Fourier series [1/m], shape (3, z, y, x/2 + 1), and 1/k² [m²]. Both are 0 for the mean
    and for the shortest waves along an axis, whose derivative has no sign."""
    along = [2 * np.pi * np.fft.fftfreq(n, cell_m) for n in cells]
    along[0] = along[0][: cells[0] // 2 + 1]
    z, y, x = np.meshgrid(along[2], along[1], along[0], indexing="ij")
    k = np.stack([x, y, z])
    k[:, (np.abs(k) > 0.9999 * np.pi / cell_m).any(axis=0)] = 0.0
    square = (k**2).sum(axis=0)
    return k, np.divide(1.0, square, out=np.zeros_like(square), where=square > 0.0)


def spectrum(k, peak):
    """Shape of E(k)."""
    return k**4 * np.exp(-2 * (k / peak) ** 2)


def solenoidal(cells, cell_m, peak, seed=1):
    """Velocity, shape (3, z, y, x), with the root mean square 1 of each component.

    @param peak  k₀ [1/m]
    """
    shape = tuple(reversed(cells))
    k, inverse_square = wave_numbers(cells, cell_m)
    waves = np.fft.rfftn(np.random.default_rng(seed).standard_normal((3, *shape)), axes=(1, 2, 3))
    waves -= k * (k * waves).sum(axis=0) * inverse_square
    of_shell = spectrum(np.sqrt((k**2).sum(axis=0)), peak) * inverse_square  # E(k) is spread over 4πk²
    waves *= np.sqrt(of_shell / (np.abs(waves) ** 2).sum(axis=0))
    velocity = np.fft.irfftn(waves, shape, axes=(1, 2, 3))
    return velocity / np.sqrt((velocity**2).mean())


def gradient(velocity, cell_m):
    """∂u_i/∂x_j by Fourier series, shape (3, 3, z, y, x)."""
    shape = velocity.shape[1:]
    k, _ = wave_numbers(shape[::-1], cell_m)
    waves = np.fft.rfftn(velocity, axes=(1, 2, 3))
    return np.fft.irfftn(1j * waves[:, None] * k, shape, axes=(2, 3, 4))


def pressure(velocity, cell_m, density):
    """Of the flow without divergence, relative to its mean [Pa]."""
    shape = velocity.shape[1:]
    of_velocity = gradient(velocity, cell_m)
    source = -density * np.einsum("ijzyx,jizyx->zyx", of_velocity, of_velocity)
    _, inverse_square = wave_numbers(shape[::-1], cell_m)
    return np.fft.irfftn(-np.fft.rfftn(source) * inverse_square, shape, axes=(0, 1, 2))


def write(file, velocity, pressure_pa, cell_m):
    """As output.fields writes a step, so that a case can begin with it and pictures show it."""
    with h5py.File(file, "w") as h5:
        group = h5.create_group("step_000000000")
        group.attrs["cell_size_m"] = cell_m
        group["velocity_m_per_s"] = np.moveaxis(velocity, 0, -1)
        group["pressure_Pa"] = pressure_pa


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file")
    parser.add_argument("--cells", type=int, nargs=3, required=True, help="along x, y and z")
    parser.add_argument("--length", type=float, required=True, help="of the domain along x [m]")
    parser.add_argument("--speed", type=float, required=True, help="root mean square of a component [m/s]")
    parser.add_argument("--density", type=float, default=1000.0, help="of the fluid [kg/m³] (default: 1000)")
    parser.add_argument("--waves", type=float, default=4.0, help="k₀: so many along x (default: 4)")
    parser.add_argument("--seed", type=int, default=1, help="another one for another flow (default: 1)")
    options = parser.parse_args()
    cell_m = options.length / options.cells[0]
    peak = 2 * np.pi * options.waves / options.length
    velocity = options.speed * solenoidal(options.cells, cell_m, peak, options.seed)
    write(options.file, velocity, pressure(velocity, cell_m, options.density), cell_m)


if __name__ == "__main__":
    main()
