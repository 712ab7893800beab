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

from copepod_report import flow
from copepod_report.run_record import RunRecord
from copepod_report.scene import Samples, most_frames, scene_of, slice_of
from copepod_report.style import DARK, LIGHT, Theme
from copepod_report.trajectory import chosen_samples

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


def of_run(run: RunRecord, views: int = 1) -> str:
    """The view of a run's trajectory so far, with its flow if it recorded one; empty without samples."""
    trajectory = run.trajectory
    if len(trajectory) == 0:
        return ""
    shown = chosen_samples(len(trajectory), most_frames(len(trajectory.bodies), views))
    samples = Samples(
        trajectory.bodies,
        trajectory.steps[shown],
        trajectory.time_s[shown],
        trajectory.some_of("position_m", shown),
        trajectory.some_of("orientation_wxyz", shown),
        np.linalg.norm(trajectory.some_of("velocity_m_per_s", shown), axis=-1),
    )
    scene = scene_of(run.name, run.case, run.cell_size_m, samples, views)
    return figure({**scene, "flow": flow_slice(run, scene["box"])})


def flow_slice(run: RunRecord, box: Any) -> Any:
    """The plane of the report's picture of the flow; None where a run did not record one (yet)."""
    if not box or not box["size"] or not run.status.is_finished:
        return None
    picture = flow.choose(run, flow.View())
    if picture is None:
        return None
    speed = np.hypot(picture.velocity_along_m_per_s, picture.velocity_across_m_per_s)
    low, high = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
    cell = [size / cells for size, cells in zip(box["size"], run.case["fluid"]["domain_cells"])]
    for axis, first, cells in zip((picture.along, picture.across), picture.corner_cells, speed.shape[::-1]):
        low[axis], high[axis] = first * cell[axis], (first + cells) * cell[axis]
    low[picture.normal] = high[picture.normal] = picture.at_m / run.cell_size_m * cell[picture.normal]
    columns, rows = sorted((picture.along, picture.across))
    title = "Mean speed in the plane" if picture.is_mean else f"Speed in the plane at step {picture.window[0]}"
    shown = speed if picture.along == columns else speed.T
    return {"title": title, **slice_of(shown, columns, rows, low, high)}


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
