"""State diagrams of Mermaid as SVG, by Graphviz: what forges draw themselves, without a script in the page."""

import re
import subprocess
from html import escape

_EDGE = re.compile(r"^\s*(\S+) --> (\S+): (.*)$")
_NAME = re.compile(r'^\s*state "(.*)" as (\w+)$')
_END = "[*]"


def svg(text):
    """Inline SVG of a `stateDiagram-v2`, whose colours are those of the page (site.css).

    Raises ValueError for a line that this cannot draw, and OSError without Graphviz.
    """
    names, edges = {}, []
    for line in text.strip().splitlines():
        if match := _NAME.match(line):
            names[match[2]] = match[1]
        elif match := _EDGE.match(line):
            edges.append(match.groups())
        elif line.strip() != "stateDiagram-v2":
            raise ValueError(f"{line!r} is not an edge or name of a state diagram (diagrams.py draws no others).")
    states = list(dict.fromkeys(state for edge in edges for state in edge[:2]))
    return _drawn([*map(_node, states, (names.get(state, state) for state in states)), *map(_arrow, edges)])


def _node(state, name):
    if state == _END:
        return f'"{state}" [shape=point, width=0.15]'
    return f'"{state}" [label="{name}", shape=box, style=rounded]'


def _arrow(edge):
    start, end, text = edge
    lines = "".join(f"{part.strip()}\\l" for part in text.split(","))
    return f'"{start}" -> "{end}" [label="{lines}"]'


def _drawn(statements):
    font = 'fontname="DejaVu Sans", fontsize=11'
    graph = f"digraph {{ bgcolor=transparent; node [{font}]; edge [{font}]; {'; '.join(statements)} }}"
    drawn = subprocess.run(["dot", "-Tsvg"], input=graph, capture_output=True, text=True, check=True).stdout
    drawn = re.sub(r'(fill|stroke)="black"', r'\1="currentColor"', drawn[drawn.index("<svg") :])
    drawn = re.sub(r"<text ", '<text fill="currentColor" ', drawn)
    return f'<div class="diagram" role="img" aria-label="{escape("state diagram")}">{drawn}</div>'
