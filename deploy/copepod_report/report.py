"""`copepod report`: reads run directories, writes report.html and the plots as files."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from copepod_report import comparison, cycles, film, flow, motion_plots, page, view
from copepod_report.run_record import DAMAGE, ReadCase, RunRecord, RunResult, SwimmerRecord, collect, name_apart
from copepod_report.style import LIGHT, Theme, picture_of, svg_of
from copepod_report.swarm import Swarm
from copepod_report.sweeps import Choice, axes_of
from copepod_run.destinations import make_folder
from copepod_run.errors import BY_SIGNAL, BadCase, ExitCode, Stop, StorageFailed
from copepod_run.figures import MOST_TABLES
from copepod_run.names import distinct_words

_MOST_DRAWN = 12  # runs of a sweep whose own figures are drawn


PAGE = "report.html"


class Canvas:
    """Where plots are written: files in a folder, and HTML; without a folder only HTML."""

    def __init__(self, folder: Path | None, formats: Sequence[str] = ("png",)) -> None:
        """`formats`: of the files, any of png, svg and pdf."""
        self.folder = folder
        self._formats = formats
        own = folder / PAGE if folder else None
        self._replaces = own is not None and own.is_file() and b"<title>Copepod: " in own.read_bytes()[:1000]
        self._written: set[Path] = set()

    def draw(
        self, name: str, drawn: Any, caption: str, wide: bool = False, narrow: Any = None, table: str = ""
    ) -> list[str]:
        """A plot as a list of one HTML figure, empty without a plot; also written as NAME.png, …

        `drawn`: a figure, None, or a function that makes one in the colours it is given. `narrow`: the same for a
        column of a journal, NAME_column.png, …; with it, both are also written as PDF. `table`: its values as CSV.
        """
        figure = drawn(LIGHT) if callable(drawn) else drawn
        if figure is None:
            return []
        files = {"CSV": self.write(f"{name}.csv", table.encode())} if table and self.folder else {}
        pictures = {name: figure} if narrow is None else {name: figure, f"{name}_column": narrow}
        for each, picture in pictures.items() if self.folder else ():
            for kind in self._formats if narrow is None else dict.fromkeys((*self._formats, "pdf")):
                path = self.write(f"{each}.{kind}", picture_of(picture, kind, caption))
                if narrow is not None and kind != "png":
                    files[f"{kind.upper()} {2.54 * picture.get_figwidth():.1f} cm"] = path
        return [page.figure(svg_of(figure), caption, wide, svg_of(narrow) if narrow else "", files)]

    def write(self, name: str, content: bytes) -> Path:
        """A new file in the folder, whatever the name: neither it nor a link of this name leads elsewhere.

        It replaces that of an earlier report. Raises Stop(2) where another file is in the way.
        """
        assert self.folder
        path = self.folder / re.sub(r"[^\w.+=-]+", "_", name)
        if self._replaces or path in self._written:
            path.unlink(missing_ok=True)
        try:
            with open(path, "xb") as file:
                file.write(content)
        except FileExistsError:
            raise BadCase(
                f"{path} is in the way (not written by a report). Move it away, or choose another --out."
            ) from None
        self._written.add(path)
        return path


class Additions:
    """What a report adds for runs of a special kind; this class adds nothing."""

    def chapters(self, runs: Sequence[RunRecord], canvas: Canvas) -> tuple[list[RunRecord], list[str]]:
        """The runs that remain for sections of their own, and the HTML of sections about the others."""
        return list(runs), []

    def comparison(self, runs: Sequence[RunResult], canvas: Canvas) -> list[str]:
        """HTML of figures that replace the plot of all swimming speeds; empty to keep that."""
        return []

    def positions(self, axes: Any, swimmer: SwimmerRecord, theme: Theme) -> None:
        """Draws over the plot of a swimmer's positions."""


def write_report(
    directories: Sequence[str],
    out: str,
    read_case: ReadCase,
    additions: Additions,
    flow_view: flow.View = flow.View(),
    formats: Sequence[str] = ("png",),
    choice: Choice = Choice(),
    video: bool = False,
) -> Path:
    """Writes the report of the runs into the folder `out`; returns the path of the page.

    Raises Stop(2) for folders without a run and a flow_view that does not suit them, Stop(73) for damaged ones.
    """
    try:
        collected = [run for directory in directories for run in collect(directory, read_case)]
        name_apart(collected)
        if flow_view != flow.View() and not any((run.directory / "fields.h5").exists() for run in collected):
            raise BadCase("there is no flow to draw (no run recorded one). Set output.fields in the case.")
        folder, title = Path(out), f"Copepod: {_title(directories, collected)}"
        make_folder(folder)
        canvas = Canvas(folder, formats)
        films = {run.name: film.film_of(run, flow_view) for run in collected} if video else {}
        canvas.write(PAGE, page.page(title, []).encode())  # from here on the folder is that of a report
        for name, content in films.items():
            canvas.write(f"{name}_flow.mp4", content)
        return canvas.write(PAGE, page.page(title, _sections(collected, canvas, additions, flow_view, choice)).encode())
    except DAMAGE as problem:
        raise _damaged(_names(directories), problem) from None


def page_of(directory: str | Path, read_case: ReadCase, additions: Additions = Additions()) -> str:
    """The page of one run directory as it is now, whether the run continues or has ended; writes nothing.

    Raises Stop(2) for a folder without a case.yaml, Stop(73) for damaged files, not for half-written ones.
    """
    run = RunRecord(directory, read_case)
    try:
        figures = [view.of_run(run), *_figures_of(run, Canvas(None), run.name, additions, flow.View())]
        return page.page(f"Copepod: {run.name}", [page.run_section(run, "run", figures), view.scripts()])
    except DAMAGE as problem:
        raise _damaged(str(directory), problem) from None


def opening_figures(
    runs: Sequence[RunResult], canvas: Canvas, additions: Additions, choice: Choice = Choice()
) -> list[str]:
    """HTML of the figures that a page of several runs begins with."""
    first = additions.comparison(runs, canvas) + comparison.first_figures(runs, canvas.draw, choice)
    return first or canvas.draw("speeds", comparison.speeds(runs), "Swimming speeds of all runs.")


def _damaged(names: str, problem: Exception) -> Stop:
    return StorageFailed(
        f"{names} cannot be evaluated (a file is damaged: {type(problem).__name__}: {problem}). Run the case again."
    )


def _sections(
    collected: Sequence[RunRecord], canvas: Canvas, additions: Additions, flow_view: flow.View, choice: Choice
) -> list[str]:
    """HTML of all sections of the page; writes the plots."""
    left, chapters = additions.chapters([run for run in collected if run.status.is_finished], canvas)
    runs = [run for run in collected if run in left or not run.status.is_finished]
    anchors = distinct_words([run.name for run in runs])
    sections = []
    others = comparison.other_figures(runs, canvas.draw, choice)
    if len(runs) > 1:
        first = opening_figures(runs, canvas, additions, choice)
        sections.append(page.comparison_section(runs, anchors, first, others))
    sections += chapters
    axes = axes_of(runs)
    for number, (run, anchor) in enumerate(zip(runs, anchors)):
        is_one_of_many = len(runs) > _MOST_DRAWN and run.sweep.values  # whose figures are drawn on request
        figures = []
        if not is_one_of_many:
            figures = [view.of_run(run, len(runs)), *_figures_of(run, canvas, anchor, additions, flow_view)]
        swept = [(axes[key].heading, axes[key].quantity(axes[key].places[number])) for key in run.sweep.values]
        sections.append(page.run_section(run, anchor, figures, swept, folded=len(runs) > 3))
    sections.append(view.scripts())
    return sections


def _title(directories: Sequence[str], runs: Sequence[RunRecord]) -> str:
    if len(runs) == 1:
        return runs[0].name
    return _names(directories) if len(directories) < 4 else f"{len(runs)} runs"


def _names(directories: Sequence[str]) -> str:
    return ", ".join(Path(directory).name for directory in directories)


def _figures_of(run: RunRecord, canvas: Canvas, prefix: str, additions: Additions, flow_view: flow.View) -> list[str]:
    """HTML of all plots of a run; each is also written as files."""
    figures = []
    few = len(run.swimmers) <= MOST_TABLES
    has_motion = len(run.trajectory) > 1
    for swimmer in run.swimmers if few else []:
        if swimmer.is_three_beads and has_motion:
            figures += _figures_of_swimmer(swimmer, canvas, f"{prefix}_{swimmer.name}", additions)
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
    return figures + _flow_figure(run, canvas, prefix, flow_view)


def _figures_of_swimmer(swimmer: SwimmerRecord, canvas: Canvas, prefix: str, additions: Additions) -> list[str]:
    positions, axes = motion_plots.positions(swimmer)
    additions.positions(axes, swimmer, LIGHT)
    fits = "Arms over the last full period of the drive, and the fits that d1, d2 and the phases come from."
    plots: dict[str, tuple[Any, str]] = {
        "positions": (positions, "Positions of the three beads, from the middle bead's start."),
        "cycle": (motion_plots.one_cycle(swimmer), "Displacements over the last full period of the drive."),
        "arms": (motion_plots.arms(swimmer), fits),
        "forces": (motion_plots.driving_forces(swimmer), "Driving forces along the axis."),
    }
    return [
        html
        for kind, (figure, text) in plots.items()
        for html in canvas.draw(f"{prefix}_{kind}", figure, f"{swimmer.name}: {text}")
    ]


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
