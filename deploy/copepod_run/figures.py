"""The figures of summary.json: a swimmer's beside published ones, and the result table at the end of a run."""

import csv
import io
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from copepod_run.messages import elapsed_text

# key in a swimmer's summary, heading
FIGURES = {
    "u_swim_lattice": "u_swim [cells/step]",
    "kinematics.u_along_um_per_s": "u along [µm/s]",
    "kinematics.u_across_um_per_s": "u across [µm/s]",
    "kinematics.u_GA_um_per_s": "u_GA [µm/s]",
    "u_along_mean_um_per_s": "mean u along [µm/s]",
    "u_along_spread_um_per_s": "spread of u along [µm/s]",
    "change_percent": "change in last cycle [%]",
    "d1_cells": "d1 [cells]",
    "d2_cells": "d2 [cells]",
    "sin_dphi": "sin(φ1−φ2)",
    "K": "K [1/cell]",
    "u_GA_lattice": "u_GA [cells/step]",
    "error_percent": "error of u_GA [%]",
    "efficiency": "efficiency",
    "Re_swim": "Re",
    **{f"Re_bodies.{bead}": f"Re {bead}" for bead in ("B2", "B1", "B3")},
    **{f"arm_amplitudes_um.{arm}": f"amplitude of arm {arm} [µm]" for arm in range(4)},
    "kinematics.power_W": "power [W]",
    "kinematics.tilt_rad": "tilt [rad]",
    **{f"rotation_degrees.{axis}": f"turn about {axis} [°/cycle]" for axis in "xyz"},
    **{f"{force}.{figure}": f"{figure} {force}" for force in ("drag", "lift") for figure in ("mean", "rms")},
    "strouhal.mean": "Strouhal number",
}


@dataclass(frozen=True)
class Figure:
    """Our value is evaluated in the publication's way where there is a published value and such an evaluation."""

    ours: float | None
    published: float | None = None

    @property
    def deviation_percent(self) -> float | None:
        if self.ours is None or not self.published:
            return None
        return 100.0 * (self.ours - self.published) / abs(self.published)

    def texts(self) -> tuple[str, ...]:
        """Ours, the published figure and the deviation from it: «9.12e-06», «9.05e-06», «+0.8 %»; or ours only."""
        if self.published is None:
            return (number_text(self.ours),)
        deviation = self.deviation_percent
        change = "" if deviation is None else f"{deviation:+.1f} %".replace("-", "−")
        return number_text(self.ours), number_text(self.published), change


def compared(swimmer: Mapping[str, Any]) -> dict[str, Figure]:
    """{key: Figure} of an analysed swimmer's summary; empty if it was not analysed.

    The paper's figures of three beads in a row, else the kinematics.
    """
    figures = {}
    kinematics = swimmer.get("kinematics") or {}
    change = at(kinematics, "change_from_last_cycle.velocity")
    swimmer = {
        **swimmer,
        "rotation_degrees": rotation_degrees(kinematics),
        "change_percent": None if change is None else 100.0 * change,
        **{key: kinematics.get(key) for key in ("u_along_mean_um_per_s", "u_along_spread_um_per_s")},
    }
    has_figures_of_paper = at(swimmer, "u_swim_m_per_s") is not None
    if not has_figures_of_paper and "cycle" in kinematics:
        amplitudes = {str(arm): 1e6 * fit["amplitude_m"] for arm, fit in enumerate(kinematics.get("arms", []))}
        swimmer |= {
            "arm_amplitudes_um": amplitudes,
            "efficiency": kinematics.get("efficiency"),
            "Re_swim": kinematics.get("Re"),
        }
    for key in FIGURES:
        if has_figures_of_paper and key.startswith("kinematics."):
            continue
        ours, published = at(swimmer, key), at(swimmer.get("published"), key)
        if published is not None:
            as_in_paper = at(swimmer.get("as_in_paper"), key)
            ours = ours if as_in_paper is None else as_in_paper
        if ours is not None:
            figures[key] = Figure(ours, published)
    return figures


def figures_by_name(summary: Mapping[str, Any]) -> list[tuple[str, dict[str, Figure]]]:
    """The same of every swimmer and group of a run."""
    return [(entry["name"], compared(entry)) for entry in measured(summary)]


def rotation_degrees(kinematics: Mapping[str, Any]) -> dict[str, float]:
    """Rotation vector of the last full cycle by world axis; components that rounding errors determine are left out."""
    rotation = kinematics.get("rotation_rad") or []
    least = max(1e-9, 1e-6 * math.hypot(*rotation))
    return {axis: math.degrees(angle) for axis, angle in zip("xyz", rotation) if abs(angle) > least}


def at(mapping: Any, path: str) -> Any:
    """Value at «a.b» in nested mappings, or None."""
    for key in path.split("."):
        if not isinstance(mapping, dict):
            return None
        mapping = mapping.get(key)
    return mapping


def number_text(value: Any) -> str:
    """Numbers as people read them: four significant digits, five of ten thousands."""
    if isinstance(value, (list, tuple)):
        return " ".join(number_text(item) for item in value)
    if isinstance(value, float):
        return f"{value:.{5 if 1e4 <= abs(value) < 1e5 else 4}g}"
    return "-" if value is None else str(value)


_PREFIXES = {12: "T", 9: "G", 6: "M", 3: "k", 0: "", -3: "m", -6: "µ", -9: "n", -12: "p", -15: "f"}


def prefix_of(value: float, least: int = -15, most: int = 0) -> tuple[int, str]:
    """Power of ten and letter of the largest prefix between two powers with which a value is at least one."""
    power = 3 * math.floor(math.log10(abs(value) * (1 + 1e-9)) / 3) if value else least
    power = min(max(power, least), most)
    return power, _PREFIXES[power]


def quantity_text(value: float, unit: str) -> str:
    """«754.8 ps», «4 µm», «1.2 s»: three or four digits, with the prefix that people use."""
    if value == 0:
        return f"0 {unit}"
    power, prefix = prefix_of(value)
    return f"{value / 10**power:.4g} {prefix}{unit}"


# key of a swimmer's summary, what to call it, unit
_SWIMMER_ROWS = (
    ("u_swim_lattice", "swimming speed u_swim", "cells/step"),
    ("u_swim_m_per_s", "", "m/s"),
    ("u_GA_lattice", "theory u_GA (Golestanian, Ajdari)", "cells/step"),
    ("error_percent", "difference to theory", "%"),
    ("d1_cells", "amplitude of the trailing arm, d1", "cells"),
    ("d2_cells", "amplitude of the leading arm, d2", "cells"),
    ("sin_dphi", "sin(phi1 - phi2)", ""),
    ("mean_arm_cells", "mean arms", "cells"),
    ("K", "geometry factor K", "1/cell"),
    ("efficiency", "efficiency", ""),
    ("Re_swim", "Re of the swimmer", ""),
    ("Re_bodies.B2", "Re of B2, trailing", ""),
    ("Re_bodies.B1", "Re of B1, middle", ""),
    ("Re_bodies.B3", "Re of B3, leading", ""),
    ("drag.mean", "drag coefficient", ""),
    ("drag.rms", "root mean square about it", ""),
    ("drag.half_span", "half of its span", ""),
    ("lift.mean", "lift coefficient", ""),
    ("lift.rms", "root mean square about it", ""),
    ("lift.half_span", "half of its span", ""),
    ("strouhal.mean", "Strouhal number", ""),
    ("strouhal.half_span", "half of its span", ""),
    ("strouhal.periods", "periods of the lift", ""),
)

# the same of the last full cycle of a swimmer of any shape: key of its `kinematics`
_KINEMATICS_ROWS = (
    ("u_along_um_per_s", "velocity along its own axis", "µm/s"),
    ("u_along_cells_per_step", "", "cells/step"),
    ("u_along_lengths_per_cycle", "", "lengths/cycle"),
    ("steady", "mean of the last cycles", "µm/s"),
    ("u_across_um_per_s", "velocity across it", "µm/s"),
    ("rotation_degrees", "rotation in a cycle about x, y, z", "degrees"),
    ("tilt_degrees", "tilt of the axis since the start", "degrees"),
    ("rest", "motion in a cycle", "(below 1e-9 lengths and 1e-9 rad)"),
    ("change_from_last_cycle.velocity", "its velocity, change in last cycle", "relative"),
    ("change_from_last_cycle.rotation", "its rotation, change in last cycle", "relative"),
)

# and of one that the paper's figures above do not describe
_GENERAL_ROWS = (
    ("u_GA_um_per_s", "theory u_GA (Golestanian, Ajdari)", "µm/s"),
    ("mean_arms_um", "mean arms", "µm"),
    ("amplitudes_um", "amplitudes of the arms", "µm"),
    ("power_W", "power of the drive", "W"),
    ("dissipation_W", "power given to the fluid", "W"),
    ("efficiency", "efficiency", ""),
    ("Re", "Re of the swimmer", ""),
)

_SWARM_ROWS = (
    ("u_along_mean_m_per_s", "mean velocity along own axes", "m/s"),
    ("u_along_spread_m_per_s", "standard deviation", "m/s"),
    ("polar_order", "polar order", ""),
    ("nearest_distance_mean_m", "mean distance to the nearest", "m"),
    ("nearest_distance_least_m", "least distance", "m"),
)

# a table for each swimmer up to this number, for all together beyond it
MOST_TABLES = 6

# in the table at the end of a run, of columns of flow.csv; the report has all
_MOST_ROWS = 16

# columns beside our own: key of a swimmer's summary, heading
_OTHER_COLUMNS = (("as_in_paper", "paper's way"), ("published", "published"))
_COLUMN = 13


def result_table(summary: Mapping[str, Any], directory: str | Path) -> str:
    """The whole table as text, one line per row, no line wider than 100 columns."""
    lines = [f"{summary.get('case', 'run')}: {summary.get('status', 'finished')}, results in {directory}", ""]
    lines += [f"  {name:<20}{value}" for name, value in run_rows(summary)]
    swimmers = measured(summary)
    for swimmer in swimmers if len(swimmers) <= MOST_TABLES else []:
        name, (headings, rows) = swimmer.get("name", "swimmer"), swimmer_table(swimmer)
        note = at(swimmer, "kinematics.note")
        none = [f"  {name}: {reason_without_rows(swimmer)}"]
        lines += ["", *(_table_lines(name, headings, rows, note) if rows else none)]
    if swarm := [(label, number_text(value), unit) for label, unit, value in swarm_rows(summary)]:
        lines += ["", *_table_lines(f"{len(summary['swimmers'])} swimmers in their last full cycles", (), swarm)]
    headings, flow = flow_table(summary)
    if 0 < len(flow) <= _MOST_ROWS:
        lines += ["", *_table_lines("flow", headings, [(*row, "") for row in flow])]
    return "\n".join(lines)


def _table_lines(
    title: str, headings: Sequence[str], rows: Iterable[Sequence[str]], note: str | None = None
) -> list[str]:
    lines = [f"  {title:<36}{''.join(f'{heading:>{_COLUMN}}' for heading in headings)}".rstrip()]
    if note:
        lines.append(f"    ({note})")
    for label, *values, unit in rows:
        lines.append(f"    {label:<34}{''.join(f'{value:>{_COLUMN}}' for value in values)}  {unit}".rstrip())
    return lines


def run_rows(summary: Mapping[str, Any]) -> list[tuple[str, str]]:
    """(name, value) of everything that is not about a swimmer."""
    step_s = summary.get("step_s")  # not known before the first sample
    rows = [("steps", f"{summary.get('steps')}" + (f" of {number_text(step_s)} s" if step_s else ""))]
    if (periodic := summary.get("periodic")) is not None:
        rows.append(("until periodic", "reached" if periodic else "not reached in these steps"))
    if (wall_s := summary.get("wall_s")) is not None:  # of a run that has finished
        rows.insert(0, ("wall time", elapsed_text(wall_s) if wall_s >= 10 else f"{wall_s:.2f} s"))
    if summary.get("mlups"):
        ranks = "1 rank" if summary.get("ranks", 1) == 1 else f"{summary['ranks']} ranks"
        rows.append(("speed", f"{summary['mlups']:.1f} MLUPS, {summary.get('precision', '')} precision, {ranks}"))
    timing = summary.get("timing") or {}
    names = {"fluid_s": "fluid", "body_s": "bodies", "coupler_s": "coupler", "exchange_wait_s": "waiting"}
    if parts := [f"{part} {timing[key]:.2f} s" for key, part in names.items() if timing.get(key) is not None]:
        rows.append(("time spent", ", ".join(parts)))
    if summary.get("mlups") and timing.get("coupling_overhead") is not None:  # on top of the fluid, where there is one
        rows.append(("coupling overhead", f"{100 * timing['coupling_overhead']:.2f} %"))
    if summary.get("mass_drift") is not None:
        rows.append(("mass drift", f"{summary['mass_drift'] * 1e6:.2g} ppm"))
    if summary.get("momentum_drift") is not None:
        rows.append(("momentum drift", f"{summary['momentum_drift'] * 100:.2g} % of the bodies' impulses"))
    if summary.get("digest") is not None:
        rows.append(("digest", str(summary["digest"])))
    return rows


def swimmer_table(swimmer: Mapping[str, Any]) -> tuple[list[str], list[tuple[str, ...]]]:
    """(headings, rows) of all figures that a swimmer has: a row has its label, a value below each heading, its unit."""
    others = {heading: swimmer.get(column) for column, heading in _OTHER_COLUMNS if swimmer.get(column)}
    has_figures_of_paper = at(swimmer, "u_swim_m_per_s") is not None
    kinematics = _with_derived(swimmer.get("kinematics") or {})
    selected = [(key, label, unit, at(swimmer, key)) for key, label, unit in _SWIMMER_ROWS]
    general = _KINEMATICS_ROWS if has_figures_of_paper else _KINEMATICS_ROWS + _GENERAL_ROWS
    selected += [("", label, unit, at(kinematics, key)) for key, label, unit in general]
    rows = []
    for key, label, unit, value in selected:
        beside = (at(column, key) for column in others.values())
        if value is not None:
            rows.append((label, number_text(value), *("" if one is None else number_text(one) for one in beside), unit))
    return ["this run", *others], rows


def reason_without_rows(swimmer: Mapping[str, Any]) -> str:
    """Why a swimmer has no figures."""
    note = swimmer.get("note") or at(swimmer, "kinematics.note")
    return f"not analysed, {note or 'the run ended before a full cycle of its drive did'}"


def measured(summary: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The entries of all swimmers and groups, and of what has coefficients."""
    return [entry for kind in ("swimmers", "groups", "coefficients") for entry in summary.get(kind) or []]


def swarm_rows(summary: Mapping[str, Any]) -> list[tuple[str, str, Any]]:
    """(name, unit, value) of what describes several swimmers together."""
    swarm = summary.get("swarm") or {}
    return [(name, unit, swarm[key]) for key, name, unit in _SWARM_ROWS if swarm.get(key) is not None]


def flow_means(summary: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Mean, root mean square of the deviation from it, least and most of each column of flow.csv that has samples."""
    return {entry["name"]: entry for entry in summary.get("flow") or [] if "mean" in entry}


def flow_table(summary: Mapping[str, Any]) -> tuple[list[str], list[tuple[str, ...]]]:
    """(headings, rows) of the same: a row has the column and a value below each heading."""
    keys = {"mean": "mean", "rms": "rms", "min": "least", "max": "most"}
    rows = [(name, *(number_text(of[key]) for key in keys)) for name, of in flow_means(summary).items()]
    return list(keys.values()), rows


def _with_derived(kinematics: Mapping[str, Any]) -> dict[str, Any]:
    """With angles in degrees and lengths in µm, as people read them."""
    if kinematics.get("cycle") is None:
        return {}
    arms = kinematics["arms"]
    rotation, mean = rotation_degrees(kinematics), kinematics.get("u_along_mean_um_per_s")
    return {
        **kinematics,
        "steady": None if mean is None else f"{mean:.4g} ± {kinematics['u_along_spread_um_per_s']:.2g}",
        "rotation_degrees": [rotation.get(axis, 0.0) for axis in "xyz"],
        "rest": "at rest" if kinematics.get("at_rest") else None,
        "tilt_degrees": math.degrees(kinematics["tilt_rad"]),
        "mean_arms_um": [1e6 * arm["mean_m"] for arm in arms] if 0 < len(arms) <= 4 else None,
        "amplitudes_um": [1e6 * arm["amplitude_m"] for arm in arms] if 0 < len(arms) <= 4 else None,
    }


def markdown_table(heads: str, rows: Iterable[str]) -> str:
    """A table in Markdown; heads and cells of a row are separated by « | » already."""
    return "\n".join([f"| {heads} |", "|" + "---|" * (heads.count("|") + 1), *(f"| {row} |" for row in rows)])


def csv_text(columns: Mapping[str, Iterable[Any]]) -> str:
    """A table of columns, by their heading, as CSV."""
    stream = io.StringIO()
    csv.writer(stream, lineterminator="\n").writerows([list(columns), *zip(*columns.values())])
    return stream.getvalue()
