"""Draws the figures and tables of docs/results/swimmers.md:

    PYTHONPATH=deploy /usr/bin/python3 -m copepod_swimmers runs/swimmers docs/results
"""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from copepod_report.style import LIGHT, Theme, png_of
from copepod_swimmers import three_spheres
from copepod_swimmers.runs import members


def main(campaign: Path, folder: Path) -> None:
    """Writes PNG files into `folder` and prints the tables."""

    def draw(name: str, figure: Callable[[Theme], Any]) -> None:
        (folder / f"{name}.png").write_bytes(png_of(figure(LIGHT)))

    def speeds(*names: str) -> list[three_spheres.Speed]:
        return [three_spheres.speed_of(run) for name in names for run in members(campaign, name)]

    stokes, lattice = speeds("stokes_lag"), speeds("lattice_lag")
    draw("swimmers_lag", lambda theme: three_spheres.over_lag(stokes, lattice, theme))
    print(three_spheres.table(stokes, "lag, Stokes [steps]", 1), "", sep="\n")
    print(three_spheres.table(lattice, "lag, lattice [steps]", 1), "", sep="\n")
    stokes, lattice = speeds("stokes_amplitude"), speeds("lattice_amplitude")
    draw("swimmers_amplitude", lambda theme: three_spheres.over_amplitude(stokes, lattice, theme))
    print(three_spheres.table(stokes, "force, Stokes [µN]", 1e6), "", sep="\n")
    print(three_spheres.table(lattice, "force, lattice [µN]", 1e6), "", sep="\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
