"""The result table of a campaign as Markdown, CSV and JSON, rewritten after every case that ends."""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from copepod_campaign.cases import Entry, State, swept_keys, value_text
from copepod_run.figures import FIGURES, Figure, compared, csv_text, flow_means, markdown_table, measured


@dataclass(frozen=True)
class Row:
    """A swimmer or group; a case that has none, or is not done, has one row without figures."""

    entry: Entry
    swimmer: str  # empty where there is no other
    figures: dict[str, Figure]  # by key


def write(folder: Path, name: str, entries: Sequence[Entry]) -> None:
    """results.md, results.csv and results.json in `folder`; each replaced in one go."""
    contents = {
        "results.md": f"# {name}\n\n{markdown(entries)}\n",
        "results.csv": _csv(entries),
        "results.json": json.dumps(records(name, entries), indent=1, ensure_ascii=False) + "\n",
    }
    for file, content in contents.items():
        fresh = folder / f"{file}.new"
        fresh.write_text(content, encoding="utf-8")
        fresh.replace(folder / file)


def records(name: str, entries: Sequence[Entry]) -> dict[str, Any]:
    """The content of results.json."""
    scales = {key: scale for entry in entries for key, scale in entry.member.scales.items()}
    heads = swept_keys([entry.member for entry in entries])
    parameters = [{"key": key, "name": head, "scale": scales[key]} for key, head in heads.items()]
    cases = [
        {
            "name": entry.name,
            "member_of": entry.member.item if entry.member.parameters else None,
            "parameters": entry.member.parameters,
            "state": entry.state.value,
            "builds": entry.builds,
            "of_another_build": entry.of_another_build,
            "remark": entry.remark,
            "summary": entry.summary,
        }
        for entry in entries
    ]
    return {"campaign": name, "parameters": parameters, "cases": cases}


def markdown(entries: Sequence[Entry]) -> str:
    """A row per swimmer and group; a cell holds our figure, in brackets the published one and our deviation from it."""
    rows = _rows(entries)
    columns = _known_columns(rows, lambda value: "" if value is None else value_text(value))
    columns["state"] = [_state_text(row.entry) for row in rows]
    for key in FIGURES:
        if any(key in row.figures for row in rows):
            columns[FIGURES[key]] = [_cell(row.figures.get(key)) for row in rows]
    return markdown_table(" | ".join(columns), map(" | ".join, zip(*columns.values())))


def text(entries: Sequence[Entry]) -> str:
    """The table for the terminal: state, wall time, speed of every case."""
    rows = _rows(entries)
    labels = [f"{row.entry.name}, {row.swimmer}" if row.swimmer else row.entry.name for row in rows]
    width = max(map(len, labels)) + 2
    lines = []
    for label, row in zip(labels, rows):
        speeds = [key for key in ("u_swim_lattice", "kinematics.u_along_um_per_s", "drag.mean") if key in row.figures]
        shown = " ".join(f"{FIGURES[key]} {_cell(row.figures[key])}" for key in speeds)
        lines.append(f"  {label:<{width}}{_state_text(row.entry):<24}{shown}".rstrip())
    return "\n".join(lines)


def _rows(entries: Sequence[Entry]) -> list[Row]:
    rows = []
    for entry in entries:
        swimmers = measured(entry.summary or {}) if entry.state is State.DONE else []
        if not swimmers:
            rows.append(Row(entry, "", {}))
        in_case = entry.plan.case.get("swimmers", [])  # with the published figures of now; the run may be older
        for number, swimmer in enumerate(swimmers):
            section = in_case[number] if number < len(in_case) else {}
            name = swimmer["name"] if len(swimmers) > 1 else ""
            rows.append(Row(entry, name, compared({**swimmer, "published": section.get("published")})))
    return rows


def _known_columns(rows: Sequence[Row], cell: Callable[[Any], Any]) -> dict[str, list[Any]]:
    """By heading the cells of what is known before a run: its name, its swept keys, its swimmers if it has several."""
    members = [row.entry.member for row in rows]
    columns: dict[str, list[Any]] = {"case": [member.name for member in members]}
    for key, head in swept_keys(members).items():
        columns[head] = [member.parameters.get(key) for member in members]
    if any(row.swimmer for row in rows):
        columns["swimmer"] = [row.swimmer for row in rows]
    return {head: list(map(cell, values)) for head, values in columns.items()}


def _cell(figure: Figure | None) -> str:
    ours, *others = figure.texts() if figure else ("",)
    return f"{ours} ({', '.join(others)})" if others else ours


def _state_text(entry: Entry) -> str:
    return "done, another build" if entry.of_another_build else entry.state.value


def _csv(entries: Sequence[Entry]) -> str:
    """All columns that have a value anywhere."""
    rows = _rows(entries)
    columns = _known_columns(rows, _plain)
    columns["state"] = [row.entry.state.value for row in rows]
    columns["builds"] = [" ".join(row.entry.builds) for row in rows]
    columns |= {key: [(row.entry.summary or {}).get(key) for row in rows] for key in ("wall_s", "digest")}
    for key in FIGURES:
        figures = [row.figures.get(key, Figure(None)) for row in rows]
        columns[key] = [figure.ours for figure in figures]
        columns[f"{key}_published"] = [figure.published for figure in figures]
        columns[f"{key}_deviation_percent"] = [figure.deviation_percent for figure in figures]
    means = [flow_means(row.entry.summary or {}) for row in rows]
    for name in dict.fromkeys(name for of_run in means for name in of_run):
        columns |= {f"{name}.{key}": [of_run.get(name, {}).get(key) for of_run in means] for key in ("mean", "rms")}
    filled = {head: cells for head, cells in columns.items() if any(cell not in (None, "") for cell in cells)}
    return csv_text(filled)


def _plain(value: Any) -> Any:
    return value if value is None or isinstance(value, (int, float)) else value_text(value)
