"""The HTML page: everything inline, so that the one file can be mailed and opened without a network."""

import base64
import mimetypes
import shlex
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup

from copepod_report.comparison import cell_texts, comparison_columns, comparison_rows
from copepod_report.run_record import RunRecord
from copepod_report.sweeps import axes_of
from copepod_run.checkout import called_as
from copepod_run.figures import MOST_TABLES, measured, number_text, reason_without_rows
from copepod_run.figures import run_rows, swarm_rows, swimmer_rows

_MOST_ROWS = 500  # of a table of swimmers
_STYLE = Path(__file__).with_name("page.css").read_text()


def templates(path: Path) -> Any:
    """The macros of a file of templates; each returns HTML. What they are given is escaped."""
    found = jinja2.Environment(
        loader=jinja2.FileSystemLoader(path.parent),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    found.policies["json.dumps_kwargs"] = {"separators": (",", ":")}
    return found.get_template(path.name).module


HTML = templates(Path(__file__).with_name("page.html"))


def page(title: str, sections: Sequence[str]) -> str:
    """A complete document from the HTML of its sections."""
    return str(HTML.page(title, _STYLE, sections)).lstrip()


def figure(svg: str, caption: str, wide: bool = False, narrow: str = "", files: Mapping[str, Path] = {}) -> str:
    """A plot, `narrow` for narrow windows, and what can be saved from it, by what it is called."""
    pictures = [base64.b64encode(text.encode()).decode() for text in (svg, narrow)]
    saved = [
        (label, path.name, mimetypes.guess_type(path)[0], base64.b64encode(path.read_bytes()).decode())
        for label, path in files.items()
    ]
    return str(HTML.figure(*pictures, caption, wide, saved))


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A plain table."""
    return str(HTML.table(heads, rows))


def run_section(
    run: RunRecord, anchor: str, figures: Sequence[str], swept: Sequence[tuple[str, str]] = (), folded: bool = False
) -> str:
    """One run: what was `swept`, its key figures, its swimmers' tables, its plots; `folded`: closed at first."""
    rows = [*swept, *run_rows(run.summary)]
    own_figures = f"{called_as()} report {shlex.quote(str(run.directory))}" if run.sweep.values and not figures else ""
    entries = measured(run.summary)
    tables = [_swimmer_table(entry) for entry in entries] if len(entries) <= MOST_TABLES else []
    if swarm := [(name, number_text(value), unit) for name, unit, value in swarm_rows(run.summary)]:
        tables.append((f"{len(run.swimmers)} swimmers", ("in their last full cycles", "", ""), swarm))
    every = _table_of_all(run) if len(entries) > MOST_TABLES else None
    return str(HTML.run_section(run, anchor, rows, own_figures, tables, every, figures, folded))


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
        values = [cell_texts(cells[key]) if key in cells else "" for key, _ in columns]
        texts.append([label, *parameters, *values])
    return str(HTML.comparison_section([*heads, *(name for _, name in columns)], texts, first, others))


def _table_of_all(run: RunRecord) -> Any:
    """(title, headings, rows) of many swimmers, a row each; None if none was analysed."""
    swimmers = comparison_rows([run])
    rows = swimmers[:_MOST_ROWS]
    columns = comparison_columns(rows)
    if not columns:
        return None
    texts = [
        [name, *(number_text(figures[key].ours) if key in figures else "" for key, _ in columns)]
        for _, name, figures in rows
    ]
    title = "Every swimmer" if len(rows) == len(swimmers) else f"The first {len(rows)} of {len(swimmers)} swimmers"
    return title, ["swimmer", *(heading for _, heading in columns)], texts


def _swimmer_table(swimmer: Mapping[str, Any]) -> Any:
    """(name, headings, rows) of a swimmer's figures; without any (name, none, why)."""
    rows = swimmer_rows(swimmer)
    if not rows:
        reason = reason_without_rows(swimmer)
        return swimmer["name"], (), f"{reason[0].upper()}{reason[1:]}."
    texts = [
        (label, *("" if item is None else number_text(item) for item in (value, *others.values())), unit)
        for label, unit, value, others in rows
    ]
    return swimmer["name"], ["", "this run", *rows[0][3], ""], texts
