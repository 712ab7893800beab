"""docs/results/accuracy.md: what to choose, an overview, and a section per case."""

import datetime
import platform
import re
import textwrap
from collections.abc import Mapping
from pathlib import Path

from copepod_run.figures import markdown_table
from copepod_validation.experiment import SCHEMES, Section
from copepod_validation.matrix import CASES

_HEAD = """# Accuracy of moving boundaries

Errors of the lattice Boltzmann fluid with bodies, for every scheme, against theory, experiments, or the scheme itself.

```sh
{command}
```

This command wrote the page on {date} ({processor}; programs {build}). It holds the cases
{cases} with the schemes {schemes}{part}.

## What to choose

The defaults: `collision: trt`, `moving_boundary: parabolic`, `refill: nonequilibrium`, `lubrication: {{cut_off_cells:
auto}}`, at eight cells per diameter or more. The surface is then where it is, at every relaxation time, and the loads
are the quietest: with eight cells the drag of dilute arrays is within 0.4 %, wherever the centre is between the cells.
`central_linear` has the surface in the right place too, but three times the noise and 1.4 % error at eight cells. For
bodies that move with inertia the two are level: at twelve cells per diameter the settling sphere of Re = 32 is 0.9 and
0.2 % off the finer run; with `bounce_back` 3 %. `bounce_back` makes a staircase of every body: its error depends on
radius and place and decreases slowly with the resolution, and its loads are noisy. With `interpolated` the surface
moves with the relaxation time. `paper` is what published results of this code used; with it the size of bodies depends
on the viscosity. Keep it to reproduce them.

The mean of the loads of two steps, which bodies receive by default (`load_averaging: two_step`), removes the part of
the noise that alternates from step to step. Where surfaces come closer than two cells, lubrication acts: with
`parabolic` and `central_linear` the loads on spheres near walls and each other are right to within 5 % at every gap,
with four cells per radius. Without it the drag of the case `wall` is −6, −57 and −89 % off at gaps of 0.5, 0.24 and
0.08 cells.

## Overview
"""


def write(folder: Path, sections: Mapping[str, Section], command: str, build: str, part: str) -> Path:
    """The page and its figures; returns its path. `part`: what of the matrix it leaves out, or nothing."""
    overview: dict[str, dict[str, str]] = {}
    for section in sections.values():
        for scheme, figures in section.overview.items():
            overview.setdefault(scheme, {}).update(figures)
        for name, content in section.figures.items():
            (folder / name).write_bytes(content)
    heads = list(dict.fromkeys(head for figures in overview.values() for head in figures))
    rows = [["keys", *map(_keys, overview)]]
    rows += [[head, *(figures.get(head, "–") for figures in overview.values())] for head in heads]
    schemes = ["", *(f"`{scheme}`" for scheme in overview)]
    head = _HEAD.format(
        command=command,
        date=datetime.date.today().isoformat(),
        processor=processor(),
        build=build,
        cases=", ".join(sections),
        schemes=", ".join(overview),
        part=part,
    )
    parts = [*_wrapped(head), markdown_table(" | ".join(schemes), map(" | ".join, rows))]
    for case, section in sections.items():
        parts += [
            f"## {case.replace('_', ' ').capitalize()}",
            *_wrapped(CASES[case].REFERENCE),
            *_wrapped(section.markdown),
        ]
    path = folder / "accuracy.md"
    path.write_text("\n\n".join(part.strip() for part in parts) + "\n")
    return path


def _wrapped(markdown: str) -> list[str]:
    """Paragraphs of Markdown; prose in lines of 120 columns."""
    paragraphs = markdown.strip().split("\n\n")
    return [part if part[0] in "#|`!" else textwrap.fill(part, 120, break_on_hyphens=False) for part in paragraphs]


def _keys(scheme: str) -> str:
    return ", ".join(f"`{value}`" for value in SCHEMES[scheme].values())


def processor() -> str:
    """As in lscpu."""
    try:
        found = re.search(r"model name\s*:\s*(.+)", Path("/proc/cpuinfo").read_text())
    except OSError:
        found = None
    return found[1] if found else platform.machine()
