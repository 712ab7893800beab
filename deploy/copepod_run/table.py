"""The result table at the end of a run, made from summary.json."""

from copepod_run.figures import at, number_text
from copepod_run.stages import elapsed_text

# key of a swimmer's summary, what to call it, unit
_SWIMMER_ROWS = (
    ("u_swim_lattice", "swimming speed u_swim", "cells/step"),
    ("u_swim_m_per_s", "", "m/s"),
    ("u_GA_lattice", "theory u_GA (Golestanian, Ajdari)", "cells/step"),
    ("error_percent", "difference to theory", "%"),
    ("d1_cells", "amplitude of arm 1, d1", "cells"),
    ("d2_cells", "amplitude of arm 2, d2", "cells"),
    ("sin_dphi", "sin(phi1 - phi2)", ""),
    ("mean_arm_cells", "mean arms", "cells"),
    ("K", "geometry factor K", "1/cell"),
    ("efficiency", "efficiency", ""),
    ("Re_swim", "Re of the swimmer", ""),
    ("Re_bodies.B2", "Re of B2, trailing", ""),
    ("Re_bodies.B1", "Re of B1, middle", ""),
    ("Re_bodies.B3", "Re of B3, leading", ""),
)

# columns beside our own: key of a swimmer's summary, heading
_OTHER_COLUMNS = (("as_in_paper", "paper's way"), ("published", "published"))
_COLUMN = 13


def result_table(summary, directory):
    """The whole table as text, one line per row, no line wider than 100 columns."""
    lines = [f"{summary.get('case', 'run')}: {summary.get('status', 'finished')}, results in {directory}", ""]
    lines += [f"  {name:<20}{value}" for name, value in run_rows(summary)]
    for swimmer in summary.get("swimmers") or []:
        lines += ["", *_swimmer_lines(swimmer)]
    return "\n".join(lines)


def run_rows(summary):
    """(name, value) of everything that is not about a swimmer."""
    wall_s = summary.get("wall_s") or 0.0
    rows = [
        ("wall time", elapsed_text(wall_s) if wall_s >= 10 else f"{wall_s:.2f} s"),
        ("steps", f"{summary.get('steps')} of {number_text(summary.get('step_s'))} s"),
    ]
    if summary.get("mlups"):
        ranks = summary.get("ranks", 1)
        rows.append(
            (
                "speed",
                f"{summary['mlups']:.1f} MLUPS, {summary.get('precision', '')} precision, "
                f"{ranks} {'rank' if ranks == 1 else 'ranks'}",
            )
        )
    rows += _timing_rows(summary.get("timing") or {}, has_fluid=bool(summary.get("mlups")))
    if summary.get("digest") is not None:
        rows.append(("digest", str(summary["digest"])))
    return rows


def swimmer_rows(swimmer):
    """(name, unit, value, {heading: value}) of all figures that a swimmer has."""
    rows = []
    for key, name, unit in _SWIMMER_ROWS:
        value = at(swimmer, key)
        if value is not None:
            others = {
                heading: at(swimmer.get(column), key) for column, heading in _OTHER_COLUMNS if swimmer.get(column)
            }
            rows.append((name, unit, value, others))
    return rows


def _timing_rows(timing, has_fluid):
    """Time spent by the three processes, and what the coupling cost on top of the fluid where there is one."""
    rows = []
    parts = [
        (name, timing.get(key))
        for name, key in (
            ("fluid", "fluid_s"),
            ("bodies", "body_s"),
            ("coupler", "coupler_s"),
            ("waiting", "exchange_wait_s"),
        )
    ]
    if any(value is not None for _, value in parts):
        rows.append(("time spent", ", ".join(f"{name} {value:.2f} s" for name, value in parts if value is not None)))
    if has_fluid and timing.get("coupling_overhead") is not None:
        rows.append(("coupling overhead", f"{100 * timing['coupling_overhead']:.2f} %"))
    return rows


def _swimmer_lines(swimmer):
    rows = swimmer_rows(swimmer)
    name = swimmer.get("name", "swimmer")
    if not rows:
        return [f"  {name}: not analysed, the run ended before the last period of its stroke did"]
    headings = list(rows[0][3])
    lines = [f"  {name:<36}{'this run':>{_COLUMN}}" + "".join(f"{heading:>{_COLUMN}}" for heading in headings)]
    for label, unit, value, others in rows:
        beside = "".join(
            f"{number_text(others[heading]) if others[heading] is not None else '':>{_COLUMN}}" for heading in headings
        )
        lines.append(f"    {label:<34}{number_text(value):>{_COLUMN}}{beside}  {unit}".rstrip())
    return lines
