"""The HTML page: everything inline, so that the one file can be mailed and opened without a network."""

import base64
import mimetypes
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup

from copepod_report.run_record import RunRecord, RunResult
from copepod_report.style import picture_of, svg_of
from copepod_report.sweeps import axes_of
from copepod_run.checkout import called_as
from copepod_run.errors import BadCase
from copepod_run.figures import FIGURES, MOST_TABLES, Figure, figures_by_name, measured, number_text
from copepod_run.figures import flow_table, reason_without_rows, run_rows, swarm_rows, swimmer_table
from copepod_run.names import as_word

_MOST_ROWS = 500  # of a table of swimmers
PAGE = "report.html"
_STYLE = Path(__file__).with_name("page.css").read_text()

Row = tuple[int, str, dict[str, Figure]]  # number of the run, swimmer name, figures by key


def templates(path: Path) -> Any:
    """The macros of a file of templates; each returns HTML. What they are given is escaped."""
    found = jinja2.Environment(
        loader=jinja2.FileSystemLoader(path.parent),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    found.filters["base64"] = lambda content: base64.b64encode(content).decode()
    found.policies["json.dumps_kwargs"] = {"separators": (",", ":")}
    return found.get_template(path.name).module


HTML = templates(Path(__file__).with_name("page.html"))


def page(title: str, sections: Sequence[str]) -> str:
    """A complete document from the HTML of its sections."""
    return str(HTML.page(title, _STYLE, sections)).lstrip()


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
        self, name: str, figure: Any, caption: str, wide: bool = False, narrow: Any = None, table: str = ""
    ) -> list[str]:
        """A plot as a list of one HTML figure, empty for None; also written as NAME.png, …

        `narrow`: the same for a column of a journal, NAME_column.png, …; with it, both are also written as PDF.
        `table`: its values as CSV.
        """
        if figure is None:
            return []
        files = {"CSV": self.write(f"{name}.csv", table.encode())} if table and self.folder else {}
        pictures = {name: figure} if narrow is None else {name: figure, f"{name}_column": narrow}
        for each, picture in pictures.items() if self.folder else ():
            for kind in self._formats if narrow is None else dict.fromkeys((*self._formats, "pdf")):
                path = self.write(f"{each}.{kind}", picture_of(picture, kind, caption))
                if narrow is not None and kind != "png":
                    files[f"{kind.upper()} {2.54 * picture.get_figwidth():.1f} cm"] = path
        shown = [svg_of(each).encode() if each else b"" for each in (figure, narrow)]
        saved = [(label, at.name, mimetypes.guess_type(at)[0], at.read_bytes()) for label, at in files.items()]
        return [str(HTML.figure(*shown, caption, wide, saved))]

    def write(self, name: str, content: bytes) -> Path:
        """A new file in the folder, whatever the name: neither it nor a link of this name leads elsewhere.

        It replaces that of an earlier report. Raises Stop(2) where another file is in the way.
        """
        assert self.folder
        path = self.folder / as_word(name)
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


def run_section(
    run: RunRecord, anchor: str, figures: Sequence[str], swept: Sequence[tuple[str, str]] = (), folded: bool = False
) -> str:
    """One run: what was `swept`, its key figures, its swimmers' tables, its plots; `folded`: closed at first."""
    rows = [*swept, *run_rows(run.summary)]
    own_figures = f"{called_as()} report {shlex.quote(str(run.directory))}" if run.sweep.values and not figures else ""
    entries = measured(run.summary)
    tables: list[tuple[str, Sequence[str], Any]] = []
    for entry in entries if len(entries) <= MOST_TABLES else []:
        headings, texts = swimmer_table(entry)
        tables.append((entry["name"], ["", *headings, ""], texts or reason_without_rows(entry)))
    if swarm := [(name, number_text(value), unit) for name, unit, value in swarm_rows(run.summary)]:
        tables.append((f"{len(run.swimmers)} swimmers", ("in their last full cycles", "", ""), swarm))
    headings, texts = flow_table(run.summary)
    if texts:
        tables.append(("flow", ["", *headings], texts))
    every = None  # (title, headings, rows) of many swimmers, a row each
    shown = comparison_rows([run])[:_MOST_ROWS] if len(entries) > MOST_TABLES else []
    if columns := comparison_columns(shown):
        title = "Every swimmer" if len(shown) == len(entries) else f"The first {len(shown)} of {len(entries)} swimmers"
        lines = [
            [name, *(number_text(row[key].ours) if key in row else "" for key, _ in columns)] for _, name, row in shown
        ]
        every = (title, ["swimmer", *(heading for _, heading in columns)], lines)
    return str(HTML.run_section(run, anchor, rows, own_figures, tables, every, figures, folded))


def comparison_rows(runs: Sequence[RunResult]) -> list[Row]:
    """A row for every swimmer and group, or one for a run without any."""
    return [
        (number, name, figures)
        for number, run in enumerate(runs)
        for name, figures in figures_by_name(run.summary) or [("", {})]
    ]


def comparison_columns(rows: Sequence[Row]) -> list[tuple[str, str]]:
    """(key, heading) of the columns that any row fills, in the paper's order."""
    return [(key, heading) for key, heading in FIGURES.items() if any(key in cells for _, _, cells in rows)]


def comparison_section(
    runs: Sequence[RunRecord], anchors: Sequence[str], first: Sequence[str], others: Sequence[str]
) -> str:
    """The first figures, all swimmers of all runs in one table, other figures."""
    rows = comparison_rows(runs)
    columns = comparison_columns(rows)
    swept = axes_of(runs).values()
    has_published = any(cell.published is not None for _, _, cells in rows for cell in cells.values())
    heads = [("run", *(["published", "deviation"] if has_published else [])), *(axis.label for axis in swept)]
    texts = []
    for number, swimmer_name, cells in rows:
        run = runs[number]
        link = Markup('<a href="#{}">{}</a>').format(anchors[number], run.name)
        label = (link, swimmer_name) if len(measured(run.summary)) > 1 else link
        parameters = [axis.number(axis.places[number]) for axis in swept]
        texts.append([label, *parameters, *(cells[key].texts() if key in cells else "" for key, _ in columns)])
    return str(HTML.comparison_section([*heads, *(name for _, name in columns)], texts, first, others))
