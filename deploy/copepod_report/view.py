"""The interactive view of a run as HTML: the scene as JSON, and once per page the scripts with three.js in them."""

import base64
import gzip
import json
from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.colors import to_hex

from copepod_report import fields, flow
from copepod_report.run_record import RunRecord, read_file
from copepod_report.scene import Samples, scene_of, slice_of
from copepod_report.style import DARK, LIGHT, Theme

THREE_JS = Path("/usr/share/javascript/three/three.min.js")  # Debian: libjs-three
_SOURCES = Path(__file__).with_name("view")
_LICENCE = """three.js r111, compressed with gzip. Copyright © 2010-2019 three.js authors. The MIT License:
Permission is hereby granted, free of charge, to any person obtaining a copy of this software and associated
documentation files (the "Software"), to deal in the Software without restriction, including without limitation the
rights to use, copy, modify, merge, publish, distribute, sublicense, and/or sell copies of the Software, and to permit
persons to whom the Software is furnished to do so, subject to the following conditions: The above copyright notice and
this permission notice shall be included in all copies or substantial portions of the Software. THE SOFTWARE IS PROVIDED
"AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO THE WARRANTIES OF
MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR COPYRIGHT
HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE,
ARISING FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE."""


def of_run(run: RunRecord) -> str:
    """The view of a run's trajectory so far, with its mean flow if it recorded one; empty without samples."""
    trajectory = run.trajectory
    if len(trajectory) == 0:
        return ""
    samples = Samples(
        trajectory.bodies,
        trajectory.steps,
        trajectory.time_s,
        trajectory.all_of("position_m"),
        trajectory.all_of("orientation_wxyz"),
        np.linalg.norm(trajectory.all_of("velocity_m_per_s"), axis=-1),
    )
    scene = scene_of(run.name, run.case, run.cell_size_m, samples)
    return figure({**scene, "flow": mean_flow(run, scene["box"])})


def mean_flow(run: RunRecord, box: Any) -> Any:
    """A slice of the mean flow that holds the swimmers; None where a run did not record one (yet)."""
    path = run.directory / "fields.h5"
    if not box or not box["size"]:
        return None
    times = read_file(path, fields.times_in) if run.status.is_finished else fields.FieldTimes()
    if not times.has_mean:
        return None
    point, along, across = flow.plane_of(run)
    (normal,) = {0, 1, 2} - {along, across}
    layer = read_file(path, lambda path: fields.read_layer(path, fields.MEAN, normal, point[normal]))
    rows, columns = sorted((along, across), reverse=True)
    velocity = layer.velocity_m_per_s
    low, high = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
    for axis, cells in ((rows, velocity.shape[0]), (columns, velocity.shape[1]), (normal, 0)):
        cell = box["size"][axis] / run.case["fluid"]["domain_cells"][axis]
        start = layer.first_cell[axis] if cells else point[normal]
        low[axis], high[axis] = start * cell, (start + cells) * cell
    speed = np.hypot(velocity[..., along], velocity[..., across])
    return {"title": "Mean speed in the plane", **slice_of(speed, columns, rows, low, high)}


def figure(scene: Mapping[str, Any]) -> str:
    """The view of a scene; without three.js a line that names the missing package."""
    if not THREE_JS.is_file():
        return (
            '<p class="missing">The interactive view is left out (three.js is not installed). Install it with: '
            "apt-get install libjs-three</p>"
        )
    # No «<» inside: a name in it could otherwise end the script.
    content = json.dumps(scene, separators=(",", ":"), ensure_ascii=False).replace("<", "\\u003c")
    return (
        '<figure class="wide view"><div class="stage"><noscript>The interactive view needs JavaScript. The figures '
        f'show the run.</noscript></div><figcaption>{caption(scene)}</figcaption><script type="application/json">'
        f"{content}</script></figure>"
    )


def caption(scene: Mapping[str, Any]) -> str:
    """HTML: what is shown, the domain, and the meaning of the colours."""
    motion, box, flow = scene["motion"], scene["box"], scene.get("flow")
    frames, bodies = len(motion["steps"]), len(scene["bodies"])
    sentences = [f"{bodies} {'body' if bodies == 1 else 'bodies'}, {frames} samples of the trajectory."]
    if box and box["size"]:
        size = " × ".join(f"{length:.4g}" for length in box["size"])
        sentences.append(f"Domain {size} {scene['unit']}; {_faces(box)}.")
    elif box:
        sentences.append(f"Wall at {box['walls'][0][0]} = 0.")
    text = escape(" ".join(sentences))
    if flow:
        most = f"{flow['most_m_per_s']:.3g} m/s"
        text += f' {escape(flow["title"])}: 0 <span class="scale"></span> {most}, square-root scale.'
    return text


def _faces(box: Mapping[str, Any]) -> str:
    """«walls at x, y and z low; periodic along z; mirror planes across x and y»."""
    whole = [axis for axis in "xyz" if {f"{axis}_low", f"{axis}_high"} <= set(box["walls"])]
    single = [name.replace("_", " ") for name in box["walls"] if name[0] not in whole]
    kinds = (
        ("walls at", whole + single),
        ("periodic along", box["periodic"]),
        ("mirror planes across", box["symmetry"]),
    )
    return "; ".join(f"{kind} {', '.join(names)}" for kind, names in kinds if names) or "open on all sides"


def scripts() -> str:
    """Styles and scripts of all views of a page, three.js first; empty if that is not installed."""
    if not THREE_JS.is_file():
        return ""
    packed = base64.b64encode(gzip.compress(THREE_JS.read_bytes(), mtime=0)).decode()
    code = "\n".join((_SOURCES / f"{name}.js").read_text() for name in ("motion", "stage", "view"))
    return (
        f"<style>\n{_colours()}{(_SOURCES / 'view.css').read_text()}</style>\n"
        f'<!-- {_LICENCE} -->\n<script type="text/plain" id="three">{packed}</script>\n'
        f'<script>"use strict";\n(() => {{\n{code}}})();\n</script>'
    )


def _colours() -> str:
    """The colours of both themes as properties of CSS."""

    def properties(theme: Theme) -> str:
        beads = " ".join(f"--bead-{number}: {colour};" for number, colour in enumerate(theme.beads))
        stops = matplotlib.colormaps[theme.flow]([step / 8 for step in range(9)])
        return f":root {{ {beads} --flow: {', '.join(to_hex(stop) for stop in stops)}; }}"

    return f"{properties(LIGHT)}\n@media (prefers-color-scheme: dark) {{ {properties(DARK)} }}\n"
