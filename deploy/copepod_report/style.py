"""How plots look, on light and on dark pages."""

import io
from dataclasses import dataclass
from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402  (the backend must be chosen first)


@dataclass(frozen=True)
class Theme:
    """Colours of a page; the three bead colours stay apart for colour-blind readers too."""

    name: str
    paper: str
    ink: str
    faint: str
    beads: tuple[str, str, str]  # trailing, middle, leading
    flow: str  # colour map from slow to fast
    stream: str  # stream lines


LIGHT = Theme("light", "#ffffff", "#1d2733", "#c9d1d9", ("#0072b2", "#d55e00", "#009e73"), "Blues", "#1d2733")
DARK = Theme("dark", "#12181f", "#dfe6ec", "#3a4652", ("#56b4e9", "#ff9a5c", "#35d0a0"), "GnBu_r", "#dfe6ec")
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
    with plt.rc_context(settings):
        figure, axes = plt.subplots(figsize=(WIDTH_INCHES, height_inches), layout="constrained", **subplots)
    for axis in getattr(axes, "flat", [axes]):
        axis.grid(True, linewidth=0.5, alpha=0.6)
        axis.set_axisbelow(True)
    return figure, axes


def legend_above(axes: Any, theme: Theme, columns: int = 3) -> None:
    look = {"fontsize": 9, "labelcolor": theme.ink, "frameon": False, "borderaxespad": 0.2}
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=columns, **look)


def png_of(figure: Any) -> bytes:
    """The figure as PNG bytes; closes it."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=RESOLUTION, facecolor=figure.get_facecolor())
    plt.close(figure)
    return stream.getvalue()
