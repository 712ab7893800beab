"""`copepod report`: reads run directories, writes report.html and the plots as PNG."""

import re
from pathlib import Path

from copepod_run.destinations import make_folder
from copepod_report import (
    body_plot,
    collection,
    comparison,
    families,
    fields,
    flow_plot,
    hydrodynamic_radii,
    page,
    resonance,
    swimmer_plots,
)
from copepod_report.style import DARK, LIGHT, png_of


def write_report(directories, out, read_case):
    """Writes the report of the runs into the folder `out`; returns the path of the page.

    `read_case`: function from the path of a case file to the resolved case. Raises Stop(2) for folders without a run.
    """
    collected = [collection.collect(directory, read_case) for directory in directories]
    drags = [run for found in collected for run in found.runs if hydrodynamic_radii.is_drag_run(run)]
    radii = hydrodynamic_radii.measure(drags)
    runs = [run for found in collected for run in found.runs if radii is None or run not in drags]
    out = Path(out)
    make_folder(out)
    anchors = _anchors(runs)
    sections = []
    if len(runs) > 1:
        sections.append(page.comparison_section(runs, anchors, _figures_of_all(runs, out)))
    if radii:
        sections.append(
            page.radii_section(radii, [row for run in runs for row in hydrodynamic_radii.predict(run, radii)])
        )
    sections += [_resonance_section(sweep, out) for found in collected for sweep in found.sweeps]
    for run, anchor in zip(runs, anchors):
        sections.append(page.run_section(run, anchor, _figures_of(run, out, anchor), folded=len(runs) > 3))
    path = out / "report.html"
    path.write_text(page.page(f"Copepod: {_title(directories, runs)}", sections), encoding="utf-8")
    return path


def _title(directories, runs):
    if len(runs) == 1:
        return runs[0].name
    return ", ".join(Path(directory).name for directory in directories) if len(directories) < 4 else f"{len(runs)} runs"


def _figures_of_all(runs, out):
    by_family = _draw(
        out,
        "speeds_by_family",
        lambda theme: families.speeds_by_family(runs, theme),
        "Swimming speed of the paper's designs, by family; (a) belongs to three of them.",
        wide=True,
    )
    return by_family or _draw(
        out, "speeds", lambda theme: comparison.speeds(runs, theme), "Swimming speeds of all runs."
    )


def _resonance_section(sweep, out):
    points = resonance.points_of(sweep.runs)
    (out / f"{sweep.name}.md").write_text(resonance.table(points) + "\n", encoding="utf-8")
    drawn = _draw(
        out,
        sweep.name,
        lambda theme: resonance.curve(points, theme),
        "Amplitude of the trailing bead in vacuum over its natural frequency.",
        wide=True,
    )
    return page.resonance_section(sweep.name, points, drawn)


def _anchors(runs):
    """A distinct word for every run, for links and file names."""
    anchors = []
    for run in runs:
        word = re.sub(r"[^A-Za-z0-9_-]+", "_", run.name).strip("_")
        anchors.append(word if word not in anchors else f"{word}_{len(anchors) + 1}")
    return anchors


def _figures_of(run, out, prefix):
    """HTML of all plots of a run; each is also written as a PNG file."""
    figures = []
    for swimmer in run.swimmers():
        name = f"{prefix}_{swimmer.name}"
        for kind, draw, caption in (
            ("positions", swimmer_plots.positions, "Positions of the three beads, from the middle bead's start."),
            ("cycle", swimmer_plots.one_cycle, "Displacements over the last driven period."),
            (
                "arms",
                swimmer_plots.arms,
                "Arms over the last driven period, and the fits that d1, d2 and the phases come from.",
            ),
            ("forces", swimmer_plots.driving_forces, "Driving forces along the axis."),
        ):
            figures += _draw(out, f"{name}_{kind}", lambda theme: draw(swimmer, theme), f"{swimmer.name}: {caption}")
    if not run.swimmers():
        figures += _draw(
            out, f"{prefix}_bodies", lambda theme: body_plot.displacements(run, theme), "Displacements of all bodies."
        )
    return figures + _flow_figure(run, out, prefix)


def _flow_figure(run, out, prefix):
    """The mean flow, where the run recorded one, in the plane that holds the swimmers."""
    if not run.cell_size_m:  # no lattice, no fields
        return []
    plane = fields.mean_flow(run.directory / "fields.h5", *flow_plot.plane_of(run))
    if plane is None:
        return []
    place = "swimmers" if run.swimmers() else "middle"
    start, stop = run.case["output"]["fields"]["mean_over_steps"]
    return _draw(
        out,
        f"{prefix}_mean_flow",
        lambda theme: flow_plot.mean_flow(run, plane, theme),
        f"Flow in a plane through the {place}, mean over steps {start} to {stop}; beads at their mean positions. "
        "Where a bead was for a part of the time, its own velocity is in the mean.",
        wide=True,
    )


def _draw(out, name, draw, caption, wide=False):
    """One plot in both themes as a list of one HTML figure; the light one becomes NAME.png. Empty without a plot."""
    pictures = {}
    for theme in (LIGHT, DARK):
        drawn = draw(theme)
        if drawn is None:
            return []
        pictures[theme.name] = png_of(drawn)
    (out / f"{name}.png").write_bytes(pictures["light"])
    return [page.figure(pictures, caption, wide)]
