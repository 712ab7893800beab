"""The result table of a campaign as Markdown, CSV and JSON, rewritten after every case that ends."""

import csv
import io
import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from copepod_campaign.entry import Entry, State
from copepod_run.figures import FIGURES, Figure, compared, number_text, percent_text


def write(folder: Path, name: str, entries: Sequence[Entry]) -> None:
    """results.md, results.csv and results.json in `folder`; each replaced in one go."""
    _replace(folder / "results.md", f"# {name}\n\n{markdown(entries)}\n")
    _replace(folder / "results.csv", _csv(entries))
    _replace(folder / "results.json", json.dumps(records(name, entries), indent=1) + "\n")


def records(name: str, entries: Sequence[Entry]) -> dict[str, Any]:
    """The content of results.json."""
    return {"campaign": name, "cases": [_record(entry) for entry in entries]}


def markdown(entries: Sequence[Entry]) -> str:
    """A row per swimmer; a cell holds our figure, and in brackets the published one and our deviation from it."""
    rows = list(_rows(entries))
    keys = [key for key in FIGURES if any(key in figures for _, _, figures in rows)]
    lines = ["| case | state | " + " | ".join(FIGURES[key] for key in keys) + " |", "|---" * (len(keys) + 2) + "|"]
    for label, entry, figures in rows:
        cells = [_cell(figures.get(key)) for key in keys]
        lines.append(f"| {label} | {_state_text(entry)} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def text(entries: Sequence[Entry]) -> str:
    """The table for the terminal: state, wall time, speed of every case."""
    width = max(len(label) for label, _, _ in _rows(entries)) + 2
    lines = []
    for label, entry, figures in _rows(entries):
        speeds = [key for key in ("u_swim_lattice", "kinematics.u_along_um_per_s") if key in figures]
        shown = " ".join(f"{FIGURES[key]} {_cell(figures[key])}" for key in speeds)
        lines.append(f"  {label:<{width}}{_state_text(entry):<24}{shown}".rstrip())
    return "\n".join(lines)


def _rows(entries: Sequence[Entry]) -> Iterator[tuple[str, Entry, dict[str, Figure]]]:
    """(label, entry, {key: Figure}) of every swimmer; an entry without swimmers has one row without figures."""
    for entry in entries:
        swimmers = (entry.summary or {}).get("swimmers") or [] if entry.state is State.DONE else []
        if not swimmers:
            yield entry.label, entry, {}
        for number, swimmer in enumerate(swimmers):
            label = entry.label if len(swimmers) == 1 else f"{entry.label}, {swimmer['name']}"
            yield label, entry, compared({**swimmer, "published": _published(entry, number)})


def _published(entry: Entry, number: int) -> Any:
    """Published figures as the case has them now; a finished run may be older than they are."""
    swimmers = entry.plan.case.get("swimmers", [])
    return swimmers[number].get("published") if number < len(swimmers) else None


def _cell(figure: Figure | None) -> str:
    if figure is None or figure.ours is None:
        return ""
    if figure.published is None:
        return number_text(figure.ours)
    return f"{number_text(figure.ours)} ({number_text(figure.published)}, {percent_text(figure.deviation_percent)})"


def _state_text(entry: Entry) -> str:
    return "done, another build" if entry.of_another_build else entry.state.value


def _csv(entries: Sequence[Entry]) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    rows = []
    for label, entry, figures in _rows(entries):
        summary = entry.summary or {}
        known = [entry.state.value, " ".join(entry.builds), summary.get("wall_s"), summary.get("digest")]
        values = {}
        for key, figure in figures.items():
            values[key] = figure.ours
            values[f"{key}_published"] = figure.published
            values[f"{key}_deviation_percent"] = figure.deviation_percent
        rows.append(([label, *known], values))
    columns = [f"{key}{suffix}" for key in FIGURES for suffix in ("", "_published", "_deviation_percent")]
    filled = [column for column in columns if any(values.get(column) is not None for _, values in rows)]
    writer.writerow(["case", "state", "builds", "wall_s", "digest", *filled])
    writer.writerows([*known, *(values.get(column) for column in filled)] for known, values in rows)
    return stream.getvalue()


def _record(entry: Entry) -> dict[str, Any]:
    return {
        "name": entry.name,
        "label": entry.label,
        "state": entry.state.value,
        "builds": entry.builds,
        "of_another_build": entry.of_another_build,
        "remark": entry.remark,
        "summary": entry.summary,
    }


def _replace(path: Path, content: str) -> None:
    fresh = path.with_name(path.name + ".new")
    fresh.write_text(content)
    fresh.replace(path)
