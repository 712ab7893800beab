"""What all experiments share: named schemes, and cases whose SI numbers are lattice units."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from copepod_report.style import LIGHT

CaseDict = dict[str, Any]
Result = TypeVar("Result")

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
    point: Any  # a dataclass of the case's own
    case: CaseDict


@dataclass(frozen=True)
class Section:
    """Part of the page: Markdown, figures as PNG by file name, and (column, value) of the overview by scheme."""

    markdown: str
    figures: dict[str, bytes]
    overview: dict[str, dict[str, str]]


def viscosity(tau: float) -> float:
    """ν = (τ − 1/2)/3 [theory, F3]."""
    return (tau - 0.5) / 3


def lattice_case(
    cells: Sequence[int], tau: float, boundary: str, bodies: Sequence[CaseDict], steps: int, **fluid: Any
) -> CaseDict:
    """A case in a fluid of density 1 kg/m³ with cells of 1 m and steps of 1 s; `fluid` adds keys of this section."""
    return {
        "fluid": {
            "solver": "lattice_boltzmann",
            "density_kg_per_m3": 1,
            "kinematic_viscosity_m2_per_s": viscosity(tau),
            "cell_size_m": 1,
            "relaxation_time": tau,
            "domain_cells": list(cells),
            "boundaries": {axis: boundary for axis in "xyz"},
            **fluid,
        },
        "bodies": list(bodies),
        "coupling": {"load_averaging": "none"},
        "run": {"steps": steps},
    }


def sphere(radius: float, position: Sequence[float], motion: Any, density: float = 1.0, **more: Any) -> CaseDict:
    """The body of an experiment; `density` over the fluid's."""
    mass = density * 4.18879 * radius**3
    place = [float(value) for value in position]
    return {"name": "sphere", "radius_m": radius, "mass_kg": mass, "position_m": place, "motion": motion, **more}


def by_point(results: Sequence[tuple[Experiment, Result]]) -> tuple[list[str], dict[Any, dict[str, Result]]]:
    """Schemes, and what they measured: {point: {scheme: result}}, in the order of the experiments."""
    found: dict[Any, dict[str, Result]] = {}
    for experiment, result in results:
        found.setdefault(experiment.point, {})[experiment.scheme] = result
    return list(dict.fromkeys(experiment.scheme for experiment, _ in results)), found


def table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Markdown."""
    lines = ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])
