"""A swimmer's figures beside those that somebody else published."""

from dataclasses import dataclass

# key in a swimmer's summary, heading
FIGURES = {
    "u_swim_lattice": "u_swim",
    "d1_cells": "d1",
    "d2_cells": "d2",
    "sin_dphi": "sin(φ1−φ2)",
    "K": "K",
    "u_GA_lattice": "u_GA",
    "error_percent": "error of u_GA [%]",
    "efficiency": "efficiency",
    "Re_swim": "Re",
    "Re_bodies.B2": "Re B2",
    "Re_bodies.B1": "Re B1",
    "Re_bodies.B3": "Re B3",
}


@dataclass(frozen=True)
class Figure:
    """Ours is evaluated in the publication's way where there is a published value and such an evaluation."""

    ours: float
    published: float = None

    @property
    def deviation_percent(self):
        if self.ours is None or not self.published:
            return None
        return 100.0 * (self.ours - self.published) / abs(self.published)


def compared(swimmer):
    """{key: Figure} of an analysed swimmer's summary; empty if it was not analysed."""
    figures = {}
    for key in FIGURES:
        ours, published = at(swimmer, key), at(swimmer.get("published"), key)
        if published is not None:
            as_in_paper = at(swimmer.get("as_in_paper"), key)
            ours = ours if as_in_paper is None else as_in_paper
        if ours is not None:
            figures[key] = Figure(ours, published)
    return figures


def at(mapping, path):
    """Value at «a.b» in nested mappings, or None."""
    for key in path.split("."):
        if not isinstance(mapping, dict):
            return None
        mapping = mapping.get(key)
    return mapping


def number_text(value):
    """Numbers as people read them: four significant digits."""
    if isinstance(value, (list, tuple)):
        return " ".join(number_text(item) for item in value)
    if isinstance(value, float):
        return f"{value:.4g}"
    return "-" if value is None else str(value)


def percent_text(value):
    """«+1.3 %», «−0.4 %»; empty for None."""
    return "" if value is None else f"{value:+.1f} %".replace("-", "−")
