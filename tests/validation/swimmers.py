"""Draws the figures and tables of docs/results/swimmers.md:

    deploy/copepod python tests/validation/swimmers.py runs/swimmers docs/results
"""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas

from copepod_report.style import picture_of
from copepod_swimmers import three_spheres, triangle
from copepod_swimmers.runs import members


def main(campaign: Path, folder: Path) -> None:
    """Writes PNG files into `folder` and prints the tables."""

    def draw(name: str, figure: Any) -> None:
        (folder / f"swimmers_{name}.png").write_bytes(picture_of(figure))

    def found(of: Callable[..., dict[str, float]], *names: str) -> Any:
        return pandas.DataFrame([of(run) for name in names for run in members(campaign, name)])

    for varied, unit, key, drawn in (
        ("lag", "steps", "lag", three_spheres.over_lag),
        ("force", "µN", "amplitude", three_spheres.over_amplitude),
    ):
        stokes, lattice = (found(three_spheres.speed_of, f"{flow}_{key}") for flow in ("stokes", "lattice"))
        draw(key, drawn(stokes, lattice))
        for flow, speeds in (("Stokes", stokes), ("lattice", lattice)):
            rows = map("{:.5g}".format, speeds[varied])
            print(three_spheres.table(f"{varied}, {flow} [{unit}]", rows, speeds), "", sep="\n")
    names = ("stokes_unequal_arms", "stokes_unequal_radii")
    print(three_spheres.table("Stokes", names, found(three_spheres.speed_of, *names)), "", sep="\n")

    forces, phases = (found(triangle.turn_of, f"triangle_{of}") for of in ("force", "phase"))
    draw("triangle", triangle.rotation(forces, phases))
    print(triangle.table(forces), "", triangle.table(phases), "", sep="\n")

    alone = three_spheres.Alone.of(members(campaign, "wall_alone")[0])
    phases, together, opposed = (
        found(three_spheres.pair_of, f"pair_{name}") for name in ("phase", "together", "opposed")
    )
    draw("pair", three_spheres.interaction(phases, together, opposed, alone))
    print(three_spheres.pair_table(pandas.concat([phases, together, opposed]), alone), "", sep="\n")

    ways = zip(members(campaign, "wall_towards"), members(campaign, "wall_away"))
    turnings = pandas.DataFrame([three_spheres.turning_of(towards, away, alone) for towards, away in ways])
    paths = {name: members(campaign, f"wall_{name}")[0] for name in ("pusher", "puller")}
    draw("wall", three_spheres.approach(turnings, paths, alone.length_m))
    print(alone, "", three_spheres.wall_table(turnings, alone.length_m), "", sep="\n")

    print(three_spheres.directions({name: members(campaign, f"lattice_{name}")[0] for name in ("001", "111", "123")}))


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
