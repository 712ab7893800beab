"""docs/results/accuracy.md: what to choose, an overview, and a section per case."""

import datetime
import platform
import re
import textwrap
from collections.abc import Mapping
from pathlib import Path

from copepod_run.figures import markdown_table
from copepod_validation.experiment import SCHEMES, Section

_TEXT = Path(__file__).with_name("accuracy.md").read_text()  # what it is about, and what each case compares with


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
    head, *texts = _TEXT.split("\n## ")
    text_of = dict(text.split("\n\n", 1) for text in texts)
    written = f"This command wrote the page on {datetime.date.today()} ({processor()}; programs {build}). It holds the "
    written += f"cases {', '.join(sections)} with the schemes {', '.join(overview)}{part}."
    parts = [head.format(command=command), *_wrapped(written), f"## What to choose\n\n{text_of['What to choose']}"]
    parts += ["## Overview", markdown_table(" | ".join(schemes), map(" | ".join, rows))]
    for case, section in sections.items():
        title = case.replace("_", " ").capitalize()
        parts += [f"## {title}", text_of[title], *_wrapped(section.markdown)]
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
    found = re.search(r"model name\s*:\s*(.+)", Path("/proc/cpuinfo").read_text())
    return found[1] if found else platform.machine()
