"""What all cases share: named schemes, experiments in lattice units, and tables by point and scheme."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any, TypeVar

from copepod_report.style import LIGHT
from copepod_run.figures import markdown_table

CaseDict = dict[str, Any]
Value = TypeVar("Value")
Results = Sequence[tuple[str, Any, Value]]  # scheme, point, and what was measured there
Overview = dict[tuple[str, str], str]  # what the page shows of a scheme below a heading

SCHEMES: dict[str, dict[str, str]] = {
    "paper": {"collision": "bgk", "moving_boundary": "bounce_back", "refill": "equilibrium"},
    "bounce_back": {"collision": "trt", "moving_boundary": "bounce_back", "refill": "equilibrium"},
    "interpolated": {"collision": "trt", "moving_boundary": "interpolated", "refill": "nonequilibrium"},
    "central_linear": {"collision": "trt", "moving_boundary": "central_linear", "refill": "nonequilibrium"},
    "parabolic": {"collision": "trt", "moving_boundary": "parabolic", "refill": "nonequilibrium"},
}

COLOURS = dict(zip(SCHEMES, (LIGHT.ink, *LIGHT.beads, "#cc79a7")))  # in figures


@dataclass(frozen=True)
class Experiment:
    """One run: its folder's name, the scheme, what the case varies, and the case itself."""

    name: str
    scheme: str
    point: Any  # of the case's own class
    case: CaseDict


@dataclass(frozen=True)
class Section:
    """Part of the page: tables and numbers by their names in accuracy.md, what the overview has of it, and figures as
    PNG by file name."""

    values: Mapping[str, Any]
    overview: Overview
    figures: dict[str, bytes] = field(default_factory=dict)


def experiments(case: ModuleType, scheme: str, fast: bool) -> list[Experiment]:
    """One for each point of a case, named by LABEL: of FAST, or of POINTS and what MORE has for the scheme. None where
    bgk is unstable."""
    points = case.FAST if fast else [*case.POINTS, *getattr(case, "MORE", {}).get(scheme, ())]
    found = []
    for point in points:
        written = case.case_of(point)
        if SCHEMES[scheme]["collision"] != "bgk" or written["fluid"]["relaxation_time"] > 0.52:
            written["fluid"].update(SCHEMES[scheme])
            label = case.LABEL.format(point).replace(", ", "_")
            found.append(Experiment(f"{case.__name__.rpartition('.')[2]}-{scheme}-{label}", scheme, point, written))
    return found


def viscosity(tau: float) -> float:
    """ν = (τ − 1/2)/3 [theory, F3]."""
    return (tau - 0.5) / 3


def lattice_case(
    cells: Sequence[int],
    tau: float,
    boundaries: str | CaseDict,
    bodies: Sequence[CaseDict],
    steps: int,
    from_step: int = 0,
    **fluid: Any,
) -> CaseDict:
    """A case in a fluid of density 1 kg/m³ with cells of 1 m and steps of 1 s, without the keys of a scheme.

    The trajectory begins at `from_step`; `fluid` adds keys of this section. Loads are not averaged if no body is free.
    """
    return {
        "fluid": {
            "solver": "lattice_boltzmann",
            "density_kg_per_m3": 1,
            "kinematic_viscosity_m2_per_s": viscosity(tau),
            "cell_size_m": 1,
            "relaxation_time": tau,
            "domain_cells": list(cells),
            "boundaries": {axis: boundaries for axis in "xyz"} if isinstance(boundaries, str) else boundaries,
            **fluid,
        },
        "bodies": list(bodies),
        "coupling": {} if any(body["motion"] == "free" for body in bodies) else {"load_averaging": "none"},
        "run": {"steps": steps},
        "output": {"trajectory": {"every_steps": 1, "from_step": from_step}},
    }


def sphere(radius: float, position: Sequence[float], motion: Any, density: float = 1.0, **more: Any) -> CaseDict:
    """The body of an experiment; `density` over the fluid's."""
    mass = density * 4.18879 * radius**3
    place = [float(value) for value in position]
    return {"name": "sphere", "radius_m": radius, "mass_kg": mass, "position_m": place, "motion": motion, **more}


def uniform_flow(speed: float) -> CaseDict:
    """Along z, at first."""
    return {"kind": "uniform", "velocity_m_per_s": [0, 0, speed]}


def grouped(results: Results[Value], point_of: Callable[[Any], Any]) -> Results[list[Value]]:
    """What was measured with each scheme at all points together that `point_of` makes equal, in their order."""
    found: dict[tuple[str, Any], list[Value]] = {}
    for scheme, point, value in results:
        found.setdefault((scheme, point_of(point)), []).append(value)
    return [(*key, values) for key, values in found.items()]


def by_scheme(results: Results[Value]) -> dict[str, list[Value]]:
    """What was measured with each scheme, in the order of the results."""
    return {scheme: values for scheme, _, values in grouped(results, lambda point: None)}


def worst(results: Results[Value], head: str, error: Callable[[Value], float], form: str = "+.1f") -> Overview:
    """The largest error with each scheme."""
    found = by_scheme(results)
    return {(scheme, head): format(max(map(error, values), key=abs), form) for scheme, values in found.items()}


def table_by_point(
    results: Results[Value], heads: str, row: Callable[[Any], str], cell: Callable[[Value], str], none: str = "–"
) -> str:
    """Markdown: for each point its `row`, below `heads`, and a cell for each scheme; `none` without a result."""
    schemes, points = list(by_scheme(results)), dict.fromkeys(point for _, point, _ in results)
    cells = {(point, scheme): cell(value) for scheme, point, value in results}
    rows = (" | ".join([row(point), *(cells.get((point, scheme), none) for scheme in schemes)]) for point in points)
    return markdown_table(" | ".join([heads, *schemes]), rows)
