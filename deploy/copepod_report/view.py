"""The interactive view of a run as HTML: the scene as JSON, and once per page the scripts with three.js in them."""

import gzip
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from copepod_report import flow
from copepod_report.page import HTML
from copepod_report.run_record import RunRecord
from copepod_report.scene import Samples, as_text, most_frames, scene_of
from copepod_report.trajectory import chosen_samples

THREE_JS = Path("/usr/share/javascript/three/three.min.js")  # Debian: libjs-three
_MOST_CELLS = 256  # of the flow, along each axis
_SOURCES = Path(__file__).with_name("view")


def of_run(run: RunRecord, views: int = 1) -> str:
    """The view of a run's trajectory so far, with its flow if it recorded one; empty without samples."""
    trajectory = run.trajectory
    if len(trajectory) == 0:
        return ""
    shown = chosen_samples(len(trajectory), most_frames(len(trajectory.bodies), views))
    quantities = ("position_m", "orientation_wxyz", "velocity_m_per_s")
    motion = (trajectory.some_of(quantity, shown) for quantity in quantities)
    samples = Samples(trajectory.bodies, trajectory.steps[shown], trajectory.time_s[shown], *motion)
    scene = scene_of(run.name, run.case, run.cell_size_m, samples)
    return figure({**scene, "flow": flow_slice(run, scene["box"])})


def flow_slice(run: RunRecord, box: Any) -> Any:
    """The plane of the report's picture of the flow; None where a run did not record one (yet).

    Colours stand for the square root of the speed; `low`, `high` are opposite corners in the unit of the scene.
    """
    if not box or not box["size"] or not run.status.is_finished:
        return None
    if not (picture := flow.choose(run, flow.View())):
        return None
    corners, seen = np.empty((2, 3)), [picture.along, picture.across]  # in cells
    corners[:, seen] = np.add(picture.corner_cells, [(0, 0), picture.speed_m_per_s.shape[::-1]])
    corners[:, picture.normal] = picture.at_m / run.cell_size_m
    low, high = (corners * np.divide(box["size"], run.case["fluid"]["domain_cells"])).tolist()
    along, across = sorted(seen)
    speed = picture.speed_m_per_s if picture.along == along else picture.speed_m_per_s.T
    rows, columns = (max(1, math.ceil(cells / _MOST_CELLS)) for cells in speed.shape)
    shown = speed[::rows, ::columns]
    most = float(np.quantile(shown, 0.998)) or 1.0
    return {
        "title": "Mean speed in the plane" if picture.is_mean else f"Speed in the plane at step {picture.window[0]}",
        "along": along,
        "across": across,
        "low": low,
        "high": high,
        "shape": list(shown.shape),
        "most_m_per_s": most,
        "levels": as_text(np.round(255 * np.sqrt(np.clip(shown / most, 0.0, 1.0))).astype(np.uint8)),
    }


def figure(scene: Mapping[str, Any]) -> str:
    """The view of a scene; without three.js a line that names the missing package."""
    box = scene["box"]
    return str(HTML.view(scene, _faces(box) if box else "") if THREE_JS.is_file() else HTML.view_missing())


def _faces(box: Mapping[str, list[str]]) -> str:
    """«walls at x, y and z low; periodic along z; mirror planes across x and y»."""
    whole = [axis for axis in "xyz" if {f"{axis}_low", f"{axis}_high"} <= set(box["walls"])]
    single = [name.replace("_", " ") for name in box["walls"] if name[0] not in whole]
    kinds = {"walls at": whole + single, "periodic along": box["periodic"], "mirror planes across": box["symmetry"]}
    return "; ".join(f"{kind} {', '.join(names)}" for kind, names in kinds.items() if names) or "open on all sides"


def scripts() -> str:
    """Styles and scripts of all views of a page, three.js first; empty if that is not installed."""
    if not THREE_JS.is_file():
        return ""
    packed = gzip.compress(THREE_JS.read_bytes(), mtime=0)
    code = "\n".join((_SOURCES / f"{name}.js").read_text() for name in ("motion", "stage", "view"))
    return str(HTML.scripts((_SOURCES / "view.css").read_text(), packed, code))
