"""Energy and dissipation of the Taylor-Green vortex that breaks down, from the samples of a run, and their picture:

    deploy/copepod run configs/validation/taylor_green_3d.yaml
    deploy/copepod python tests/validation/taylor_green_3d.py runs/taylor_green_3d docs/taylor_green_3d.png
"""

import sys

import copepod
import matplotlib.pyplot as plt
import numpy as np
from scipy.interpolate import CubicSpline

PEAK, PEAK_TIME, ENERGY = 0.01286, 8.97, 0.0745  # of 512³ modes [van Rees et al. 2011]


def main(directory, picture):
    run = copepod.load(directory)
    fluid = run.case["fluid"]
    speed = fluid["initial_flow"]["speed_m_per_s"]
    length = fluid["cell_size_m"] * fluid["domain_cells"][0] / (2 * np.pi)
    velocity, samples = run.fields["velocity_m_per_s"], run.flow
    mass = fluid["density_kg_per_m3"] * (2 * np.pi * length) ** 3
    time = samples["time_s"].values * speed / length
    energy = samples["kinetic_energy_J"].values / (mass * speed**2)
    spline, fine = CubicSpline(time, energy), np.linspace(0, time[-1], 4001)
    dissipation = -spline(fine, 1)
    late = fine > 5  # a spline of the first samples overshoots
    peak = np.argmax(np.where(late, dissipation, 0))
    print("| | found | published | deviation [%] |\n|---|---|---|---|")
    for name, found, published in (
        ("largest dissipation [U³/L]", dissipation[peak], PEAK),
        ("at time [L/U]", fine[peak], PEAK_TIME),
        ("kinetic energy at 10 [U²]", float(spline(10.0)), ENERGY),
    ):
        print(f"| {name} | {found:.5f} | {published} | {100 * (found / published - 1):+.1f} |")
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.4))
    left.plot(fine, dissipation, label="−dE/dt")
    left.plot(time, samples["dissipation_W"] * length / (mass * speed**3), ":", label="2 ν S:S")
    left.plot(PEAK_TIME, PEAK, "o", label="largest, van Rees et al. 2011")
    left.set(xlabel="t U/L", ylabel="dissipation [U³/L]", ylim=(0, None))
    left.legend()
    seen = np.argmin(abs(velocity["time"].values * speed / length - fine[peak]))
    u = velocity.values[seen][:, 0] / speed  # beside the mirror at y = 0: (z, x, 3)
    cell = fluid["cell_size_m"] / length
    vorticity = np.gradient(u[..., 0], cell, axis=0) - np.gradient(u[..., 2], cell, axis=1)
    edge = u.shape[0] * cell
    image = right.imshow(abs(vorticity), origin="lower", extent=(0, edge, 0, edge), vmax=30, cmap="magma")
    right.set(xlabel="x/L", ylabel="z/L", title=f"|ω_y| beside y = 0 at t U/L = {fine[peak]:.1f} [U/L]")
    figure.colorbar(image)
    figure.tight_layout()
    figure.savefig(picture, dpi=110)


if __name__ == "__main__":
    main(*sys.argv[1:])
