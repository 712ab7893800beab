"""`copepod report`: reads run directories, writes report.html and the plots as files."""

import subprocess
from argparse import Namespace
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from copepod_report import cycles, flow, motion_plots, page, sweeps, view
from copepod_report.fields import times_in
from copepod_report.run_record import DAMAGE, ReadCase, RunRecord, RunResult
from copepod_report.run_record import collect, name_apart, read_file
from copepod_report.page import PAGE, Canvas
from copepod_report.style import picture_of
from copepod_report.swarm import Swarm
from copepod_report.sweeps import axes_of, sweeps_of
from copepod_run import packages
from copepod_run.errors import BY_SIGNAL, BadCase, ExitCode, Stop, StorageFailed
from copepod_run.figures import MOST_TABLES, quantity_text
from copepod_run.names import distinct_words
from copepod_run.plan import drawn_case
from copepod_run.run_directory import make_folder

_MOST_DRAWN = 12  # runs of a sweep whose own figures are drawn
_SHOWN_FOR_S = 10  # at 2 to 25 pictures a second
_SCALED_BY = 20  # pictures whose speeds determine the scale of colours
_X264 = "-c:v libx264 -preset medium -crf 20 -pix_fmt yuv420p -vf pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white -f mp4"
_FRAGMENTS = "-movflags frag_keyframe+empty_moov+default_base_moof"  # ffmpeg writes to a pipe, where it cannot go back


def write_report(options: Namespace, out: str) -> Path:
    """Writes the report of the runs that the command line names into the folder `out`; returns the path of the page.

    Raises Stop(2) for folders without a run and a view of the flow that does not suit them, Stop(73) for damaged ones.
    """
    directories, names = options.directories, ", ".join(Path(directory).name for directory in options.directories)
    flow_view = flow.View(options.plane, options.at, options.time, options.zoom, options.margin, options.frame)
    try:
        collected = [run for directory in directories for run in collect(directory, drawn_case)]
        name_apart(collected)
        if flow_view != flow.View() and not any((run.directory / "fields.h5").exists() for run in collected):
            raise BadCase("there is no flow to draw (no run recorded one). Set output.fields in the case.")
        of_several = names if len(directories) < 4 else f"{len(collected)} runs"
        folder, title = Path(out), f"Copepod: {collected[0].name if len(collected) == 1 else of_several}"
        make_folder(folder)
        canvas = Canvas(folder, options.format)
        films = {run.name: film_of(run, flow_view) for run in collected} if options.video else {}
        canvas.write(PAGE, page.page(title, []).encode())  # from here on the folder is that of a report
        for name, content in films.items():
            canvas.write(f"{name}_flow.mp4", content)
        sections = _sections(collected, canvas, flow_view, options.x, options.y)
        return canvas.write(PAGE, page.page(title, sections).encode())
    except DAMAGE as problem:
        raise _damaged(names, problem) from None


def page_of(directory: str | Path, read_case: ReadCase) -> str:
    """The page of one run directory as it is now, whether the run continues or has ended; writes nothing.

    Raises Stop(2) for a folder without a case.yaml, Stop(73) for damaged files, not for half-written ones.
    """
    run = RunRecord(directory, read_case)
    try:
        figures = [view.of_run(run), *_figures_of(run, Canvas(None), run.name, flow.View())]
        return page.page(f"Copepod: {run.name}", [page.run_section(run, "run", figures), view.scripts()])
    except DAMAGE as problem:
        raise _damaged(str(directory), problem) from None


def opening_figures(runs: Sequence[RunResult], canvas: Canvas, x: str = "", y: str = "") -> list[str]:
    """HTML of the figures that a page of several runs begins with; `x`, `y`: as for `sweeps_of`."""
    first = sweeps.first_figures(sweeps_of(runs, x, y), canvas.draw)
    return first or canvas.draw("speeds", motion_plots.speeds(runs), "Swimming speeds of all runs.")


def _damaged(names: str, problem: Exception) -> Stop:
    return StorageFailed(
        f"{names} cannot be evaluated (a file is damaged: {type(problem).__name__}: {problem}). Run the case again."
    )


def _sections(runs: Sequence[RunRecord], canvas: Canvas, flow_view: flow.View, x: str, y: str) -> list[str]:
    """HTML of all sections of the page; writes the plots."""
    anchors = distinct_words([run.name for run in runs])
    sections = []
    others = sweeps.other_figures(sweeps_of(runs, x, y), canvas.draw)
    if len(runs) > 1:
        sections.append(page.comparison_section(runs, anchors, opening_figures(runs, canvas, x, y), others))
    axes = axes_of(runs)
    for number, (run, anchor) in enumerate(zip(runs, anchors)):
        is_drawn = len(runs) <= _MOST_DRAWN or not run.sweep.values  # others on request
        figures = [view.of_run(run, len(runs)), *_figures_of(run, canvas, anchor, flow_view)] if is_drawn else []
        swept = [(axes[key].heading, axes[key].quantity(axes[key].places[number])) for key in run.sweep.values]
        sections.append(page.run_section(run, anchor, figures, swept, folded=len(runs) > 3))
    return [*sections, view.scripts()]


def _figures_of(run: RunRecord, canvas: Canvas, prefix: str, flow_view: flow.View) -> list[str]:
    """HTML of all plots of a run; each is also written as files."""
    figures = []
    few = len(run.swimmers) <= MOST_TABLES
    has_motion = len(run.trajectory) > 1
    for swimmer in run.swimmers if few else []:
        if swimmer.is_three_beads and has_motion:
            for kind, drawn, text in motion_plots.of_swimmer(swimmer):
                figures += canvas.draw(f"{prefix}_{swimmer.name}_{kind}", drawn, f"{swimmer.name}: {text}")
    for name, measured in run.cycles.items() if few else []:
        text = (
            f"{name}: Velocity along and across the own axis, rotation, means and amplitudes of the arms, cycle by "
            "cycle. A first cycle far from the others is outside the frame."
        )
        figures += canvas.draw(f"{prefix}_{name}_by_cycle", cycles.by_cycle(measured, run.arms_of(name)), text)
    if not few and has_motion:
        for name, drawn, text in Swarm(run).figures():
            figures += canvas.draw(f"{prefix}_{name}", drawn, text, wide=name == "swarm")
    if not run.swimmers and has_motion:
        figures += canvas.draw(f"{prefix}_bodies", motion_plots.displacements(run), "Displacements of all bodies.")
    if few:
        text = (
            "Paths of the centroids from the end of the first cycle on: a dot for each end of a cycle, an arrow for "
            "the own axis at the start of the last."
        )
        figures += canvas.draw(f"{prefix}_paths", cycles.paths(run.cycles), text)
    texts = {"flow": "The flow over time, and at its probes.", "coefficients": "Drag and lift over time."}
    for name, text in texts.items():
        samples = read_file(run.directory / f"{name}.csv", motion_plots.flow_over_time)
        figures += canvas.draw(f"{prefix}_{name}_over_time", samples, text)
    return figures + _flow_figure(run, canvas, prefix, flow_view)


def _flow_figure(run: RunRecord, canvas: Canvas, prefix: str, flow_view: flow.View) -> list[str]:
    """A picture of the flow, where the run recorded one."""
    if not run.cell_size_m:  # no lattice, no fields
        return []
    try:
        picture = flow.choose(run, flow_view)
    except Stop as stop:
        if run.status.is_finished or stop.code in (ExitCode.BAD_CASE, *BY_SIGNAL):
            raise
        return []  # the run is writing the file
    if picture is None:
        return []
    name = f"{prefix}_mean_flow" if picture.is_mean else f"{prefix}_flow"
    return canvas.draw(name, flow.draw(run, picture), f"{picture.caption(run)} {run.parameters()}.", wide=True)


def film_of(run: RunRecord, view: flow.View) -> bytes:
    """The snapshots of a run as MP4, which browsers and presentations play.

    Raises Stop(2) without ffmpeg, with fewer than two snapshots, or if the run lacks what the view names.
    """
    packages.require(("ffmpeg",), "a film needs it, nothing else does")
    steps, _ = read_file(run.directory / "fields.h5", times_in)
    if len(steps) < 2:
        raise BadCase(
            f"{run.name} cannot be filmed (a film needs two snapshots of the flow, the run recorded {len(steps)}). "
            "Set output.fields.every_steps in the case."
        )
    last = _picture(run, view, "last")
    fixed = replace(view, plane=last.plane, at_m=last.at_m)
    chosen = [steps[number * (len(steps) - 1) // (_SCALED_BY - 1)] for number in range(_SCALED_BY)]
    top_m_per_s = max(flow.top_speed_m_per_s(run, _picture(run, fixed, str(step))) for step in set(chosen))
    pictures = []
    for step in steps:
        figure = flow.draw(run, _picture(run, fixed, str(step)), top_m_per_s)
        figure.axes[0].set_title(quantity_text(step * run.summary["step_s"], "s"), loc="left", fontsize=9)
        pictures.append(picture_of(figure))
    rate = min(max(len(steps) / _SHOWN_FOR_S, 2), 25)
    command = f"ffmpeg -loglevel error -f image2pipe -c:v png -framerate {rate:g} -i - {_X264} {_FRAGMENTS} -"
    made = subprocess.run(command.split(), input=b"".join(pictures), capture_output=True)
    if made.returncode != 0:
        said = made.stderr.decode(errors="replace").strip().splitlines() or ["no reason given"]
        raise Stop(ExitCode.FAILED, f"ffmpeg made no film of {run.name} ({said[-1]}). Try another --plane.")
    return made.stdout


def _picture(run: RunRecord, view: flow.View, time: str) -> flow.FlowPicture:
    picture = flow.choose(run, replace(view, time=time))
    assert picture is not None
    return picture
