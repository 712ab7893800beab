"""A trace as a picture: one bar per process and rank, what is inside a phase drawn over it."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

_COLOURS = {
    "waiting": "#eeeeee",
    "wait for fluid": "#eeeeee",
    "wait for bodies": "#dddddd",
    "exchanging": "#f2c14e",
    "advancing": "#8fb8de",
    "couple": "#d1495b",
    "integrate": "#66a182",
    "map": "#c98c10",
    "refill": "#e09f3e",
    "momentum": "#a44a3f",
    "reduce": "#7d4e57",
    "halo": "#9d4edd",
    "bulk": "#2e6f9e",
}
_OTHER = "#999999"


def draw(timelines, path):
    """Writes PNG or SVG, depending on the suffix of the path."""
    start = min(phase.begin_ns for each in timelines for phase in each.phases)
    figure, axes = plt.subplots(figsize=(11, 0.7 * len(timelines) + 1.6))
    seen = []
    for row, timeline in enumerate(reversed(timelines)):
        for phase in timeline.phases:
            colour = _COLOURS.get(phase.name, _OTHER)
            height = 0.8 if _is_outer(phase.name) else 0.45
            begin, length = (phase.begin_ns - start) * 1e-3, (phase.end_ns - phase.begin_ns) * 1e-3
            axes.barh(row, length, left=begin, height=height, color=colour, linewidth=0)
            if phase.name not in seen:
                seen.append(phase.name)
    axes.set_yticks(range(len(timelines)), [timeline.title for timeline in reversed(timelines)])
    axes.set_xlabel("time [µs]")
    axes.margins(x=0)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    handles = [plt.Rectangle((0, 0), 1, 1, color=_COLOURS.get(name, _OTHER)) for name in seen]
    figure.legend(handles, seen, loc="upper center", ncols=min(9, len(seen)), frameon=False, fontsize=8)
    figure.tight_layout(rect=(0, 0, 1, 0.86))
    figure.savefig(path, dpi=130)
    plt.close(figure)


def _is_outer(name):
    """Phases of the protocol; those of solvers lie inside them."""
    return name in ("waiting", "exchanging", "advancing", "configuring", "checkpointing", "couple") or name.startswith(
        "wait "
    )
