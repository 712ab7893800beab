"""How plots look: each is drawn once, in light colours. On a page these are CSS variables that a dark page changes."""

import io
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from matplotlib import colormaps, cycler, rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.colors import LinearSegmentedColormap, ListedColormap
from matplotlib.figure import Figure  # not pyplot, which would choose the backend of a notebook


@dataclass(frozen=True)
class Theme:
    """Colours of a page; the three bead colours stay apart for colour-blind readers too."""

    paper: str
    ink: str
    faint: str
    beads: tuple[str, str, str]  # trailing, middle, leading

    def colours(self) -> tuple[str, ...]:
        return (self.paper, self.ink, self.faint, *self.beads)


LIGHT = Theme("#ffffff", "#1d2733", "#c9d1d9", ("#0072b2", "#d55e00", "#009e73"))
_DARK = Theme("#12181f", "#dfe6ec", "#3a4652", ("#56b4e9", "#ff9a5c", "#35d0a0"))
# Maps of colours that suit both: stream lines show on the first, from slow (the paper) to fast; from violet to yellow
# without the ends that one of the papers would swallow.
FLOW = LinearSegmentedColormap.from_list("flow", ["#2f80c400", "#2a84b488", "#23878a"])
VIOLET_TO_YELLOW = ListedColormap(colormaps["viridis"]([0.25 + 0.63 * step / 255 for step in range(256)]))
WIDTH_INCHES, COLUMN_INCHES = 17.8 / 2.54, 8.6 / 2.54  # a page and a column of a journal
RESOLUTION = 130


def new_figure(height_inches: float, width_inches: float = WIDTH_INCHES, **subplots: Any) -> tuple[Any, Any]:
    """Figure and axes; a light grid helps to read values."""
    settings = {
        "font.size": 10 if width_inches > COLUMN_INCHES else 8,
        "font.family": "DejaVu Sans",
        "text.parse_math": False,  # names may hold dollar signs
        **dict.fromkeys(("text.color", "axes.labelcolor", "xtick.color", "ytick.color"), LIGHT.ink),
        **dict.fromkeys(("axes.edgecolor", "grid.color"), LIGHT.faint),
        **dict.fromkeys(("axes.facecolor", "figure.facecolor"), LIGHT.paper),
        **dict.fromkeys(("axes.spines.top", "axes.spines.right"), False),
        "axes.prop_cycle": cycler(color=LIGHT.beads),
    }
    with rc_context(settings):
        figure = Figure(figsize=(width_inches, height_inches), layout="constrained")
        axes = figure.subplots(**subplots)
    for axis in figure.axes:
        axis.grid(True, linewidth=0.5, alpha=0.6)
        axis.set_axisbelow(True)
    return figure, axes


def many_lines(*colours: str) -> Any:
    """Property cycle of lines that outnumber the colours."""
    return cycler(linestyle=["-", "--", ":"]) * cycler(color=colours)


def legend_above(axes: Any, columns: int = 3) -> None:
    """In as many columns as there is room for, at most `columns`."""
    size = 9.0 if axes.figure.get_figwidth() > COLUMN_INCHES else 7.5
    longest = max((len(label) for label in axes.get_legend_handles_labels()[1]), default=0)
    columns = min(columns, max(1, int(65 * axes.figure.get_figwidth() / (size * (0.6 * longest + 4)))))
    look = {"fontsize": size, "labelcolor": LIGHT.ink, "frameon": False}
    room = {"borderaxespad": 0.2, "columnspacing": 1.0, "handletextpad": 0.5}
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=columns, **look, **room)


def describe(axes: Any, title: str = "", legend: Mapping[str, Any] | None = None, **properties: Any) -> None:
    """Title, labels and other properties of a panel; a small legend, if its place is given."""
    axes.set(**properties)
    if title:
        axes.set_title(title, fontsize=10)
    if legend is not None:
        axes.legend(fontsize=8, labelcolor=LIGHT.ink, frameon=False, **legend)


def colour_bar(figure: Any, drawn: Any, label: str = "", **place: Any) -> Any:
    """A bar of the colours of `drawn` in the colours of the page."""
    bar = figure.colorbar(drawn, **place)
    size = 10 if figure.get_figwidth() > COLUMN_INCHES else 8
    bar.set_label(label, color=LIGHT.ink, fontsize=size)
    bar.ax.tick_params(colors=LIGHT.ink, labelsize=size)
    bar.outline.set_edgecolor(LIGHT.faint)
    return bar


_CANVASES = {"png": FigureCanvasAgg, "svg": FigureCanvasSVG, "pdf": FigureCanvasPdf}
_DESCRIPTION = {"png": "Description", "svg": "Description", "pdf": "Subject"}  # where each format keeps a caption
_WITHOUT_DATE: dict[str, dict[str, str | None]] = {"png": {}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}
_PRINT_RESOLUTION = 300  # of a map of colours inside a vector figure
_SETTINGS = {"svg.fonttype": "none", "svg.hashsalt": "copepod", "pdf.fonttype": 42}


def picture_of(figure: Any, kind: str = "png", description: str = "") -> bytes:
    """The figure as PNG, SVG or PDF, with its text as text; the same figure gives the same bytes."""
    dpi = RESOLUTION * WIDTH_INCHES / figure.get_figwidth() if kind == "png" else _PRINT_RESOLUTION
    return _printed(figure, kind, dpi, {_DESCRIPTION[kind]: description} if description else {})


def _printed(figure: Any, kind: str, dpi: float, metadata: Mapping[str, str]) -> bytes:
    """Without savefig, which would go through the figure twice."""
    stream = io.BytesIO()
    figure.set_dpi(dpi)
    with rc_context(_SETTINGS):
        getattr(_CANVASES[kind](figure), f"print_{kind}")(stream, metadata={**_WITHOUT_DATE[kind], **metadata})
    return stream.getvalue()


_MOST_BYTES = 1_500_000  # of a figure as vectors


def svg_of(figure: Any) -> str:
    """The figure for a page: an SVG that follows the page from light to dark.

    Lines and areas that would make it very large become pixels, which keep their colours.
    """
    text = _printed(figure, "svg", RESOLUTION, {})
    if len(text) > _MOST_BYTES:
        for artist in (artist for axes in figure.axes for artist in (*axes.lines, *axes.collections)):
            artist.set_rasterized(True)
        text = _printed(figure, "svg", RESOLUTION, {})
    variables = {colour: f"var(--c{number})" for number, colour in enumerate(LIGHT.colours())}
    coloured = r"((?:fill|stroke): )(#\w{6})"
    page = re.sub(coloured, lambda found: found[1] + variables.get(found[2], found[2]), text.decode())
    light, dark = (
        f":root {{ {' '.join(f'--c{number}: {colour};' for number, colour in enumerate(theme.colours()))} }}"
        for theme in (LIGHT, _DARK)
    )
    style = f"{light} @media (prefers-color-scheme: dark) {{ {dark} }}"
    family = "text { font-family: 'DejaVu Sans', Verdana, sans-serif !important }"  # of which one is on every machine
    return page.replace('<style type="text/css">', f'<style type="text/css">{style} {family} ', 1)
