"""What a report adds for the runs of the paper: its designs by family; radii of beads as the fluid feels them, measured
by drag runs, and the theory's speed with them; resonance in vacuum."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from copepod_report import resonance
from copepod_report.page import HTML, Canvas
from copepod_report.run_record import RunRecord, RunResult, rotated
from copepod_report.style import LIGHT, describe, new_figure
from copepod_run.figures import at, number_text

# The designs by family: what is changed from one to the next.
FAMILIES = (
    ("parallel capsules", "abcdef"),
    ("perpendicular capsules, wider gaps", "aghijk"),
    ("perpendicular capsules", "almnop"),
    ("big spheres", "q"),
)

Kind = tuple[float, float, str]  # radius [m], distance of its centres [m], orientation
# Of a swimmer: name, radii [cells], u_swim, and u_GA with the paper's sphere for every capsule and with measured radii.
Prediction = tuple[str, tuple[float, ...], float, float, float]
Radii = dict[Kind, float]  # hydrodynamic radius of each kind of capsule [m]


def chapters(runs: Sequence[RunRecord], canvas: Canvas) -> tuple[list[RunRecord], list[str]]:
    """The runs that remain for sections of their own, and the HTML of sections about the others."""
    sections = []
    drags = [run for run in runs if is_drag_run(run)]
    sweeps = resonance.sweeps_of(runs)
    radii = measure(drags)
    shown = [*(run for members in sweeps.values() for run in members), *(drags if radii else [])]
    left = [run for run in runs if run not in shown]
    if radii:
        predictions = [row for run in left for row in predict(run, radii)]
        sections.append(_section(radii, predictions))
    for name, members in sweeps.items():
        points = resonance.points_of(members)
        canvas.write(f"{name}.md", (resonance.markdown(points) + "\n").encode())
        text = "Amplitude of the trailing bead in vacuum over its natural frequency."
        drawn = canvas.draw(name, resonance.curve(points), text, wide=True)
        sections.append(resonance.section(name, points, drawn))
    return left, sections


def speeds_by_family(runs: Sequence[RunResult]) -> Any:
    """Swimming speed of every design, ours and published, a panel per family; None unless there are several designs."""
    speeds: dict[str, tuple[float, float | None]] = {}
    for run in runs:
        name = run.summary["case"]
        figures = run.summary.get("swimmers") or []
        if name.startswith("design_") and figures and figures[0].get("u_swim_lattice"):
            published = (figures[0].get("published") or {}).get("u_swim_lattice")
            speeds[name.removeprefix("design_")] = (figures[0]["u_swim_lattice"], published)
    if len(speeds) < 2:
        return None
    widths = [len(letters) + 1 for _, letters in FAMILIES]
    looks = {"label": "Copepod", "markersize": 6}, {"label": "published", "markersize": 9, "markerfacecolor": "none"}
    figure, panels = new_figure(3.4, ncols=len(FAMILIES), sharey=True, width_ratios=widths)
    for panel, (title, letters) in zip(panels, FAMILIES):
        values = 1e6 * np.array([speeds.get(letter, (None, None)) for letter in letters], float)
        for of_all, colour, look in zip(values.T, LIGHT.beads, looks):
            panel.plot(of_all, "o", color=colour, markeredgewidth=1.5, **look)
        panel.set_xticks(range(len(letters)), list(letters))
        panel.set_xlim(-0.7, len(letters) - 0.3)
        panel.set_title(title.replace(", ", ",\n"), fontsize=9, color=LIGHT.ink, wrap=True)
    panels[0].set_ylim(bottom=0)
    describe(panels[0], legend={"loc": "lower left"}, ylabel="u_swim [10⁻⁶ cells/step]")
    return figure


def is_drag_run(run: RunRecord) -> bool:
    """Whether a run holds one fixed body and no swimmer."""
    bodies = run.case.get("bodies") or []
    return not run.case.get("swimmers") and len(bodies) == 1 and bodies[0]["motion"] == "fixed"


def measure(runs: Sequence[RunRecord]) -> Radii:
    """Radii from drag runs of spheres and capsules in one and the same channel; empty without enough of them.

    A capsule's radius is that of the sphere with the same drag there, interpolated between the spheres: what the
    channel adds to the drag is the same for both, to first order in radius over width.
    """
    bodies = [run.case["bodies"][0] for run in runs]
    drags_N = [abs(run.trajectory.of(body["name"])["force_N"][-1, 2]) for run, body in zip(runs, bodies)]
    spheres = sorted((drag, body["radius_m"]) for drag, body in zip(drags_N, bodies) if body["shape"] == "sphere")
    if len(spheres) < 2:
        return {}
    drags, radii = np.transpose(spheres)
    # Drag over radius varies slowly with the radius, so that interpolating it loses no accuracy.
    coefficients = np.polyfit(drags, radii / drags, min(2, len(spheres) - 1))
    return {
        (body["radius_m"], body["length_m"], _orientation(body)): float(drag * np.polyval(coefficients, drag))
        for drag, body in zip(drags_N, bodies)
        if body["shape"] != "sphere"
    }


def _orientation(body: Mapping[str, Any]) -> str:
    """Of a capsule to the flow along z, as a swimmer's bead would call it."""
    return "parallel" if abs(rotated([0.0, 0.0, 1.0], body["orientation_wxyz"])[2]) > 0.5 else "perpendicular"


def geometrical_factor(radii: Sequence[float] | np.ndarray, mean_arms: Sequence[float] | np.ndarray) -> float:
    """K = 3 r₁r₂r₃ / (2 (r₁+r₂+r₃)²) · [1/l̄₁² + 1/l̄₂² − 1/(l̄₁+l̄₂)²]   [paper, eq. (29)]; any one unit of length."""
    first, second = mean_arms
    brackets = 1 / first**2 + 1 / second**2 - 1 / (first + second) ** 2
    return 3 * np.prod(radii) / (2 * np.sum(radii) ** 2) * brackets


def predict(run: RunRecord, radii: Radii) -> list[Prediction]:
    """Prediction of every analysed swimmer in a fluid whose beads are all known; the right ω throughout."""
    if run.case["fluid"]["solver"] == "vacuum":
        return []
    predictions = []
    for swimmer in run.swimmers:
        found = [
            bead["radius_m"]
            if bead["shape"] == "sphere"
            else radii.get((bead["radius_m"], bead["length_m"], bead["orientation"]))
            for bead in swimmer.beads
        ]
        if at(swimmer.figures, "u_GA_lattice") is None or None in found:
            continue
        cells = tuple(radius / run.cell_size_m for radius in found)
        scale = geometrical_factor(cells, swimmer.figures["mean_arm_cells"]) / swimmer.figures["K"]
        u_GA = swimmer.figures["u_GA_lattice"]
        predictions.append((run.name, cells, swimmer.figures["u_swim_lattice"], u_GA, u_GA * scale))
    return predictions


def error_percent(u_GA: float, u_swim: float) -> float:
    """Of the theory's speed."""
    return 100 * abs(u_GA - u_swim) / abs(u_GA)


def _section(radii: Radii, predictions: Sequence[Prediction]) -> str:
    """HTML: measured radii, and how far the theory is off with them and with the paper's sphere for every capsule."""
    kinds = [(kind, 1e6 * radius, 1e6 * length, 1e6 * value) for (radius, length, kind), value in radii.items()]
    heads = ("run", "radii [cells]", "u_swim", "u_GA, paper's radii", "off", "u_GA, measured radii", "off")
    rows = []
    for name, cells, u_swim, *theory in predictions:
        errors = ((number_text(u_GA), f"{error_percent(u_GA, u_swim):.1f} %") for u_GA in theory)
        rows.append((name, " ".join(f"{radius:.2f}" for radius in cells), number_text(u_swim), *sum(errors, ())))
    return str(HTML.radii_section(kinds, heads, rows))
