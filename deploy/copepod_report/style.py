"""How plots look, on light and on dark pages."""

import io
from dataclasses import dataclass
from typing import Any

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure  # not pyplot, which would choose the backend of a notebook
from matplotlib.colors import LinearSegmentedColormap


@dataclass(frozen=True)
class Theme:
    """Colours of a page; the three bead colours stay apart for colour-blind readers too."""

    name: str
    paper: str
    ink: str
    faint: str
    beads: tuple[str, str, str]  # trailing, middle, leading
    flow: str  # colour map from slow to fast, on which stream lines can be seen
    stream: str  # stream lines


_NIGHT = LinearSegmentedColormap.from_list("night", ["#12181f", "#123a5e", "#14607f", "#23878a", "#4aa886"])
matplotlib.colormaps.register(_NIGHT)
LIGHT = Theme("light", "#ffffff", "#1d2733", "#c9d1d9", ("#0072b2", "#d55e00", "#009e73"), "Blues", "#1d2733")
DARK = Theme("dark", "#12181f", "#dfe6ec", "#3a4652", ("#56b4e9", "#ff9a5c", "#35d0a0"), _NIGHT.name, "#dfe6ec")
WIDTH_INCHES = 7.2
RESOLUTION = 130


def new_figure(theme: Theme, height_inches: float, **subplots: Any) -> tuple[Any, Any]:
    """Figure and axes in the theme's colours; a light grid helps to read values."""
    settings = {
        "font.size": 10,
        "font.family": "DejaVu Sans",
        "text.parse_math": False,  # names may hold dollar signs
        "text.color": theme.ink,
        "axes.labelcolor": theme.ink,
        "axes.edgecolor": theme.faint,
        "xtick.color": theme.ink,
        "ytick.color": theme.ink,
        "axes.facecolor": theme.paper,
        "figure.facecolor": theme.paper,
        "grid.color": theme.faint,
        "axes.spines.top": False,
        "axes.spines.right": False,
    }
    with matplotlib.rc_context(settings):
        figure = Figure(figsize=(WIDTH_INCHES, height_inches), layout="constrained")
        axes = figure.subplots(**subplots)
    for axis in getattr(axes, "flat", [axes]):
        axis.grid(True, linewidth=0.5, alpha=0.6)
        axis.set_axisbelow(True)
    return figure, axes


def laid_out_like(figure: Any, drawn: Any) -> Any:
    """The figure with its axes where those of an equal one that has been drawn are: finding room for the text of the
    axes takes as long as drawing them."""
    figure.set_layout_engine("none")
    for axes, equal in zip(figure.axes, drawn.axes):
        axes.set_position(equal.get_position(original=True))
    return figure


def legend_above(axes: Any, theme: Theme, columns: int = 3) -> None:
    look = {"fontsize": 9, "labelcolor": theme.ink, "frameon": False, "borderaxespad": 0.2}
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=columns, **look)


def png_of(figure: Any) -> bytes:
    """The figure as PNG bytes."""
    return picture_of(figure, "png")


FORMATS = ("png", "svg", "pdf")
_DESCRIPTION = {"png": "Description", "svg": "Description", "pdf": "Subject"}  # where each format keeps a caption
_WITHOUT_DATE: dict[str, dict[str, None]] = {"png": {}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}
_PRINT_RESOLUTION = 300  # of a map of colours inside a vector figure


def picture_of(figure: Any, kind: str, description: str = "") -> bytes:
    """The figure as PNG, SVG or PDF, with its text as text; the same figure gives the same bytes."""
    stream = io.BytesIO()
    settings = {"svg.fonttype": "none", "svg.hashsalt": "copepod", "pdf.fonttype": 42}
    metadata: dict[str, str | None] = {
        **_WITHOUT_DATE[kind],
        **({_DESCRIPTION[kind]: description} if description else {}),
    }
    if kind == "png":
        figure.set_dpi(RESOLUTION)
        FigureCanvasAgg(figure).print_png(stream, metadata=metadata)  # savefig would go through the figure twice
        return stream.getvalue()
    with matplotlib.rc_context(settings):
        figure.savefig(stream, format=kind, dpi=_PRINT_RESOLUTION, facecolor=figure.get_facecolor(), metadata=metadata)
    return stream.getvalue()
