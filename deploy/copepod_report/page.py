"""The HTML page: everything inline, so that the one file can be mailed and opened without a network."""

import base64
import shlex
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

from copepod_report.comparison import cell_texts, comparison_columns, comparison_rows
from copepod_report.run_record import RunRecord
from copepod_report.sweeps import parameter_columns
from copepod_run.checkout import called_as
from copepod_run.figures import MOST_TABLES, Figure, compared, measured, number_text, reason_without_rows
from copepod_run.figures import run_rows, swarm_rows, swimmer_rows

_MOST_ROWS = 500  # of a table of swimmers
_STYLE = Path(__file__).with_name("page.css").read_text()


def page(title: str, sections: Sequence[str]) -> str:
    """A complete document from the HTML of its sections."""
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">\n<title>{escape(title)}</title>\n'
        f"<style>\n{_STYLE}</style>\n</head>\n<body>\n<h1>{escape(title)}</h1>\n"
        + "\n".join(sections)
        + "\n</body>\n</html>\n"
    )


def figure(pictures: Mapping[str, bytes], caption: str, wide: bool = False) -> str:
    """A plot that follows the page's colours; `pictures`: PNG bytes by theme name."""
    width = ' class="wide"' if wide else ""
    return (
        f"<figure{width}><picture>"
        f"<source srcset=\"{_data(pictures['dark'])}\" media=\"(prefers-color-scheme: dark)\">"
        f"<img src=\"{_data(pictures['light'])}\" alt=\"{escape(caption)}\"></picture>"
        f"<figcaption>{escape(caption)}</figcaption></figure>"
    )


def run_section(run: RunRecord, anchor: str, figures: Sequence[str], folded: bool = False) -> str:
    """One run: its key figures, its swimmers' tables, its plots; `folded`: closed until the reader opens it."""
    heading = f"<h2>{escape(run.name)}</h2>"
    opening, closing = (f"<details><summary>{heading}</summary>", "</details>") if folded else (heading, "")
    place = f'<p id="{anchor}">{escape(str(run.directory))}</p>'  # inside: a link to it opens what is folded
    parts = [f"<section>{opening}", place]
    parts += [f'<p class="status {run.status.state}">{escape(run.status.sentences())}</p>']
    parts += [f"<p>{escape(run.parameters())}.</p>", "<dl>"]
    rows = [(key, number_text(value)) for key, value in run.sweep.values.items()] + run_rows(run.summary)
    parts += [f"<dt>{escape(name)}</dt><dd>{escape(value)}</dd>" for name, value in rows]
    parts.append("</dl>")
    if run.sweep.values and not figures:
        parts.append(f"<p>Its own figures: {called_as()} report {escape(shlex.quote(str(run.directory)))}</p>")
    entries = measured(run.summary)
    if len(entries) <= MOST_TABLES:
        parts += [_swimmer_table(entry) for entry in entries]
    swarm = [(name, number_text(value), unit) for name, unit, value in swarm_rows(run.summary)]
    if swarm:
        parts.append(f"<h3>{len(run.swimmers)} swimmers</h3>" + table(("in their last full cycles", "", ""), swarm))
    if len(entries) > MOST_TABLES:
        parts.append(_table_of_all(entries))
    return "\n".join([*parts, '<div class="figures">', *figures, f"</div>{closing}</section>"])


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A plain table that scrolls by itself on narrow screens."""
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    head = "".join(f"<th>{escape(text)}</th>" for text in heads)
    return f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>'


def comparison_section(runs: Sequence[RunRecord], anchors: Sequence[str], figures: Sequence[str]) -> str:
    """All swimmers of all runs in one table."""
    rows = comparison_rows(runs)
    columns = comparison_columns(rows)
    swept = parameter_columns(runs)
    head = "".join(f"<th>{escape(name)}</th>" for name in [*swept.values(), *(name for _, name in columns)])
    body = ""
    for number, swimmer_name, cells in rows:
        run = runs[number]
        shown = f"<small>{escape(swimmer_name)}</small>" if len(measured(run.summary)) > 1 else ""
        label = f'<td><a href="#{anchors[number]}">{escape(run.name)}</a>{shown}</td>'
        parameters = [number_text(run.sweep.values[key]) if key in run.sweep.values else "" for key in swept]
        values = "".join(f"<td>{escape(text)}</td>" for text in parameters)
        values += "".join(_compared_cell(cells.get(key)) for key, _ in columns)
        body += f"<tr>{label}{values}</tr>"
    key = (
        "<small>published<br>deviation</small>"
        if any(c.published is not None for _, _, r in rows for c in r.values())
        else ""
    )
    return (
        f'<section><h2>All runs</h2><div class="scroll"><table class="dense"><thead><tr><th>run{key}</th>{head}</tr>'
        f"</thead><tbody>{body}</tbody></table></div><div class=\"figures\">{''.join(figures)}</div></section>"
    )


def _compared_cell(figure: Figure | None) -> str:
    if figure is None:
        return "<td></td>"
    ours, *beside = cell_texts(figure)
    return f"<td>{escape(ours)}{''.join(f'<small>{escape(text)}</small>' for text in beside)}</td>"


def _table_of_all(swimmers: Sequence[Mapping[str, Any]]) -> str:
    """A row for each of many swimmers, closed until the reader opens it; empty if none was analysed."""
    rows = [(0, swimmer["name"], compared(swimmer)) for swimmer in swimmers[:_MOST_ROWS]]
    columns = comparison_columns(rows)
    if not columns:
        return ""
    texts = [
        [name, *(number_text(figures[key].ours) if key in figures else "" for key, _ in columns)]
        for _, name, figures in rows
    ]
    title = "Every swimmer" if len(rows) == len(swimmers) else f"The first {len(rows)} of {len(swimmers)} swimmers"
    content = table(["swimmer", *(heading for _, heading in columns)], texts)
    return f"<div><details><summary>{title}</summary>{content}</details></div>"


def _swimmer_table(swimmer: Mapping[str, Any]) -> str:
    rows = swimmer_rows(swimmer)
    name = escape(swimmer["name"])
    if not rows:
        reason = escape(reason_without_rows(swimmer))
        return f"<h3>{name}</h3><p>{reason[0].upper()}{reason[1:]}.</p>"
    headings = list(rows[0][3])
    head = "".join(f"<th>{escape(heading)}</th>" for heading in ["this run", *headings])
    body = ""
    for label, unit, value, others in rows:
        values = "".join(
            f"<td>{escape(number_text(item)) if item is not None else ''}</td>"
            for item in [value, *(others[heading] for heading in headings)]
        )
        body += f'<tr><td>{escape(label)}</td>{values}<td class="unit">{escape(unit)}</td></tr>'
    return (
        f'<h3>{name}</h3><div class="scroll"><table><thead><tr><th></th>{head}<th></th></tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )


def _data(picture: bytes) -> str:
    return "data:image/png;base64," + base64.b64encode(picture).decode()
