"""The result table at the end of a run, made from summary.json."""

from copepod_command.stages import elapsed_text

# key of a swimmer's summary, what to call it, unit
_SWIMMER_ROWS = (
    ("u_swim_lattice", "swimming speed u_swim", "cells/step"),
    ("u_swim_m_per_s", "", "m/s"),
    ("u_GA_lattice", "theory u_GA [Golestanian, Ajdari]", "cells/step"),
    ("error_percent", "difference to theory", "%"),
    ("d1_cells", "amplitude of arm 1, d1", "cells"),
    ("d2_cells", "amplitude of arm 2, d2", "cells"),
    ("sin_dphi", "sin(phi1 - phi2)", ""),
    ("mean_arm_cells", "mean arms", "cells"),
    ("K", "geometry factor K", "1/cells"),
    ("efficiency", "efficiency", ""),
    ("Re_swim", "Re of the swimmer", ""),
)


def result_table(summary, directory):
    """The whole table as text, one line per row, no line wider than 100 columns."""
    lines = [f"{summary.get('case', 'run')}: {summary.get('status', 'finished')}, results in {directory}", ""]
    lines += _run_rows(summary)
    for swimmer in summary.get("swimmers", []):
        lines += ["", *_swimmer_rows(swimmer)]
    return "\n".join(lines)


def number_text(value):
    """Numbers as people read them: four significant digits."""
    if isinstance(value, (list, tuple)):
        return " ".join(number_text(item) for item in value)
    if isinstance(value, float):
        return f"{value:.4g}"
    return "-" if value is None else str(value)


def _run_rows(summary):
    rows = [("wall time", elapsed_text(summary["wall_s"]) if summary.get("wall_s", 0) >= 10
             else f"{summary.get('wall_s', 0):.2f} s"),
            ("steps", f"{summary.get('steps')} of {number_text(summary.get('step_s'))} s")]
    if summary.get("mlups"):
        rows.append(("speed", f"{summary['mlups']:.1f} MLUPS, {summary.get('precision', '')} precision, "
                              f"{summary.get('ranks', 1)} rank(s)"))
    rows += _timing_rows(summary.get("timing", {}))
    if summary.get("digest") is not None:
        rows.append(("digest", str(summary["digest"])))
    return [f"  {name:<18}{value}" for name, value in rows]


def _timing_rows(timing):
    """Time spent by the three processes, and what the coupling cost on top of the fluid."""
    rows = []
    parts = [(name, timing.get(key)) for name, key in (("fluid", "fluid_s"), ("bodies", "body_s"),
                                                       ("coupler", "coupler_s"), ("waiting", "exchange_wait_s"))]
    if any(value is not None for _, value in parts):
        rows.append(("busy", ", ".join(f"{name} {value:.2f} s" for name, value in parts if value is not None)))
    if timing.get("coupling_overhead") is not None:
        rows.append(("coupling overhead", f"{100 * timing['coupling_overhead']:.2f} %"))
    return rows


def _swimmer_rows(swimmer):
    """A swimmer's figures, the published ones beside them where there are some."""
    published = swimmer.get("published") or {}
    lines = [f"  {swimmer.get('name', 'swimmer'):<36}{'this run':>14}{'published':>14}" if published else
             f"  {swimmer.get('name', 'swimmer'):<36}{'this run':>14}"]
    for key, name, unit in (*_SWIMMER_ROWS, *_body_rows(swimmer)):
        value = swimmer.get("Re_bodies", {}).get(name.removeprefix("Re of ")) if key == "Re_bodies" else swimmer.get(key)
        if value is None:
            continue
        reference = _published(published, key, name)
        beside = f"{number_text(reference):>14}" if published else ""
        lines.append(f"    {name:<34}{number_text(value):>14}{beside}  {unit}".rstrip())
    return lines


def _body_rows(swimmer):
    return [("Re_bodies", f"Re of {body}", "") for body in swimmer.get("Re_bodies", {})]


def _published(published, key, name):
    if key == "Re_bodies":
        return (published.get("Re_bodies") or {}).get(name.removeprefix("Re of "), "")
    return published.get(key, "")
