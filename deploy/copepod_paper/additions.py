"""What a report adds for the runs of the paper."""

from collections.abc import Sequence
from typing import Any

from copepod_paper import families, hydrodynamic_radii, resonance
from copepod_report.report import Additions, Canvas
from copepod_report.run_record import RunRecord, RunResult, SwimmerRecord
from copepod_report.style import Theme


class PaperAdditions(Additions):
    """Radii from drag runs and resonance curves as chapters; designs by family; the exact motion in vacuum."""

    def chapters(self, runs: Sequence[RunRecord], canvas: Canvas) -> tuple[list[RunRecord], list[str]]:
        sections = []
        drags = [run for run in runs if hydrodynamic_radii.is_drag_run(run)]
        sweeps = resonance.sweeps_of(runs)
        shown = [run for members in sweeps.values() for run in members]
        radii = hydrodynamic_radii.measure(drags)
        if radii:
            shown += drags
        left = [run for run in runs if run not in shown]
        if radii:
            predictions = [row for run in left for row in hydrodynamic_radii.predict(run, radii)]
            sections.append(hydrodynamic_radii.section(radii, predictions))
        sections += [self._resonance(name, members, canvas) for name, members in sweeps.items()]
        return left, sections

    def comparison(self, runs: Sequence[RunResult], canvas: Canvas) -> list[str]:
        return canvas.draw(
            "speeds_by_family",
            lambda theme: families.speeds_by_family(runs, theme),
            "Swimming speed of the paper's designs, by family; (a) belongs to three of them.",
            wide=True,
        )

    def positions(self, axes: Any, swimmer: SwimmerRecord, theme: Theme) -> None:
        if swimmer.run.case["fluid"]["solver"] == "vacuum":
            resonance.draw_exact(axes, swimmer, theme)

    def _resonance(self, name: str, members: Sequence[RunRecord], canvas: Canvas) -> str:
        points = resonance.points_of(members)
        canvas.write(f"{name}.md", (resonance.markdown(points) + "\n").encode())
        drawn = canvas.draw(
            name,
            lambda theme: resonance.curve(points, theme),
            "Amplitude of the trailing bead in vacuum over its natural frequency.",
            wide=True,
        )
        return resonance.section(name, points, drawn)
