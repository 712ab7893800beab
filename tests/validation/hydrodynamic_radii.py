"""Radii of beads as the fluid feels them, measured by drag runs, and the theory's speed with them.

    deploy/copepod campaign configs/paper/campaign.yaml
    deploy/copepod python tests/validation/hydrodynamic_radii.py runs/paper
"""

import sys

import copepod
import numpy as np
from copepod_swimmers.theory import geometrical_factor


def is_drag_case(case):
    """Whether it has one fixed body and no swimmer."""
    bodies = case.get("bodies") or []
    return not case.get("swimmers") and len(bodies) == 1 and bodies[0]["motion"] == "fixed"


def radii_of(drags):
    """{(radius [m], distance of its centres [m], orientation): hydrodynamic radius [m]} of every capsule, from pairs of
    a body and the drag [N] on it in one and the same channel; empty without spheres to compare with.

    A capsule's radius is that of the sphere with the same drag there, interpolated between the spheres: what the
    channel adds to the drag is the same for both, to first order in radius over width.
    """
    spheres = sorted((drag, body["radius_m"]) for body, drag in drags if body["shape"] == "sphere")
    if len(spheres) < 2:
        return {}
    known, radii = np.transpose(spheres)
    # Drag over radius varies slowly with the radius, so that interpolating it loses no accuracy.
    coefficients = np.polyfit(known, radii / known, min(2, len(spheres) - 1))
    return {
        (body["radius_m"], body["length_m"], orientation(body)): float(drag * np.polyval(coefficients, drag))
        for body, drag in drags
        if body["shape"] != "sphere"
    }


def orientation(body):
    """Of a capsule to the flow along z, as a swimmer's bead would call it."""
    _, x, y, _ = body["orientation_wxyz"]
    return "parallel" if abs(1 - 2 * (x * x + y * y)) > 0.5 else "perpendicular"


def predicted(beads, figures, cell_m, radii):
    """Radii of the beads [cells] and u_GA with them, from a swimmer's figures; None if the radius of one is unknown."""
    found = [
        bead["radius_m"]
        if bead["shape"] == "sphere"
        else radii.get((bead["radius_m"], bead["length_m"], bead["orientation"]))
        for bead in beads
    ]
    if figures.get("u_GA_lattice") is None or None in found:
        return None
    cells = [radius / cell_m for radius in found]
    scale = geometrical_factor(cells, figures["mean_arm_cells"]) / figures["K"]
    return cells, figures["u_GA_lattice"] * scale


def error_percent(u_GA, u_swim):
    """Of the theory's speed."""
    return 100 * abs(u_GA - u_swim) / abs(u_GA)


def main(directory):
    runs = list(copepod.load(directory))
    drags = []
    for run in runs:
        if is_drag_case(run.case):
            body = run.case["bodies"][0]
            drags.append((body, abs(run.trajectory.loc[body["name"]]["fz_N"].iloc[-1])))
    radii = radii_of(drags)
    print("| capsule | as a sphere of radius [µm] |\n|---|---|")
    for (radius, length, kind), value in radii.items():
        print(f"| {kind}, radius {1e6 * radius:g} µm, {1e6 * length:g} µm | {1e6 * value:.2f} |")
    print(
        "\n| run | radii [cells] | u_swim | u_GA, paper's radii | off [%] | measured radii | off [%] |\n"
        + "|---" * 7
        + "|"
    )
    for run in runs:
        if run.case["fluid"]["solver"] == "vacuum" or run.status != "finished":
            continue
        for section, figures in zip(run.case.get("swimmers") or [], run.summary.get("swimmers") or [], strict=True):
            found = predicted(section["beads"], figures, run.summary["cell_size_m"], radii)
            if found is None:
                continue
            u_swim, theory = figures["u_swim_lattice"], (figures["u_GA_lattice"], found[1])
            errors = " | ".join(f"{u_GA:.4g} | {error_percent(u_GA, u_swim):.1f}" for u_GA in theory)
            cells = " ".join(f"{radius:.2f}" for radius in found[0])
            print(f"| {run.summary['case']} | {cells} | {u_swim:.4g} | {errors} |")


if __name__ == "__main__":
    main(*sys.argv[1:])
