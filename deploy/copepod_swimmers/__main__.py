"""Draws the figures and tables of docs/results/swimmers.md:

    PYTHONPATH=deploy /usr/bin/python3 -m copepod_swimmers runs/swimmers docs/results
"""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from copepod_report.style import LIGHT, Theme, png_of
from copepod_swimmers import pair, three_spheres, triangle, wall
from copepod_swimmers.runs import members


def main(campaign: Path, folder: Path) -> None:
    """Writes PNG files into `folder` and prints the tables."""

    def draw(name: str, figure: Callable[[Theme], Any]) -> None:
        (folder / f"{name}.png").write_bytes(png_of(figure(LIGHT)))

    def speeds(head: str, scale: float, *names: str) -> list[three_spheres.Speed]:
        found = [three_spheres.speed_of(run) for name in names for run in members(campaign, name)]
        rows = names if len(names) > 1 else [f"{scale * speed.value:.5g}" for speed in found]
        print(three_spheres.table(head, rows, found), "", sep="\n")
        return found

    stokes = speeds("lag, Stokes [steps]", 1, "stokes_lag")
    lattice = speeds("lag, lattice [steps]", 1, "lattice_lag")
    draw("swimmers_lag", lambda theme: three_spheres.over_lag(stokes, lattice, theme))
    stokes_forces = speeds("force, Stokes [µN]", 1e6, "stokes_amplitude")
    lattice_forces = speeds("force, lattice [µN]", 1e6, "lattice_amplitude")
    draw("swimmers_amplitude", lambda theme: three_spheres.over_amplitude(stokes_forces, lattice_forces, theme))
    speeds("Stokes", 1, "stokes_unequal_arms", "stokes_unequal_radii")

    forces, phases = (
        [triangle.turn_of(run) for run in members(campaign, f"triangle_{of}")] for of in ("force", "phase")
    )
    draw("swimmers_triangle", lambda theme: triangle.rotation(forces, phases, theme))
    print(triangle.table(forces), "", triangle.table(phases), "", sep="\n")

    alone = pair.alone_of(members(campaign, "wall_alone")[0])
    over_phase, together, opposed = (
        [pair.pair_of(run) for run in members(campaign, f"pair_{name}")] for name in ("phase", "together", "opposed")
    )
    draw("swimmers_pair", lambda theme: pair.interaction(over_phase, together, opposed, alone, theme))
    print(pair.table([*over_phase, *together, *opposed], alone), "", sep="\n")

    bulk = alone.bulk
    ways = zip(members(campaign, "wall_towards"), members(campaign, "wall_away"))
    turnings = [wall.turning_of(towards, away, bulk) for towards, away in ways]
    paths = [(name, members(campaign, f"wall_{name}")[0]) for name in ("pusher", "puller")]
    draw("swimmers_wall", lambda theme: wall.approach(turnings, paths, bulk, theme))
    print(f"p/(η u L²) = {bulk.relative_dipole:.3f}, L = {1e6 * bulk.length_m:.1f} cells", "", sep="\n")
    print(wall.table(turnings, bulk), "", sep="\n")

    oblique = {name: members(campaign, f"lattice_{name}")[0] for name in ("001", "111", "123")}
    print(three_spheres.directions(oblique))


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
