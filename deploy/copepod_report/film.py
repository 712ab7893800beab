"""A film of the flow: the report's picture of each snapshot, in one plane and with one scale of colours."""

import subprocess
from dataclasses import replace

from copepod_report import flow
from copepod_report.fields import times_in
from copepod_report.run_record import RunRecord, read_file
from copepod_report.style import png_of
from copepod_run import packages
from copepod_run.errors import BadCase, ExitCode, Stop
from copepod_run.figures import quantity_text

_SHOWN_FOR_S = 10  # at 2 to 25 pictures a second
_SCALED_BY = 20  # pictures whose speeds determine the scale of colours
_X264 = "-c:v libx264 -preset medium -crf 20 -pix_fmt yuv420p -vf pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white -f mp4"
_FRAGMENTS = "-movflags frag_keyframe+empty_moov+default_base_moof"  # ffmpeg writes to a pipe, where it cannot go back


def film_of(run: RunRecord, view: flow.View) -> bytes:
    """The snapshots of a run as MP4, which browsers and presentations play.

    Raises Stop(2) without ffmpeg, with fewer than two snapshots, or if the run lacks what the view names.
    """
    packages.require(("ffmpeg",), "a film needs it, nothing else does")
    steps = read_file(run.directory / "fields.h5", times_in).steps
    if len(steps) < 2:
        raise BadCase(
            f"{run.name} cannot be filmed (a film needs two snapshots of the flow, the run recorded {len(steps)}). "
            "Set output.fields.every_steps in the case."
        )
    last = flow.choose(run, replace(view, time="last"))
    assert last is not None
    fixed = replace(view, plane=last.plane, at_m=last.at_m)
    chosen = [steps[number * (len(steps) - 1) // (_SCALED_BY - 1)] for number in range(_SCALED_BY)]
    top_m_per_s = max(flow.top_speed_m_per_s(run, _picture(run, fixed, step)) for step in set(chosen))
    pictures = []
    for step in steps:
        picture = _picture(run, fixed, step)
        figure = flow.draw(run, picture, top_m_per_s)
        figure.axes[0].set_title(quantity_text(step * run.summary["step_s"], "s"), loc="left", fontsize=9)
        pictures.append(png_of(figure))
    rate = min(max(len(steps) / _SHOWN_FOR_S, 2), 25)
    made = subprocess.run(
        ["ffmpeg", "-loglevel", "error", "-f", "image2pipe", "-c:v", "png", "-framerate", f"{rate:g}", "-i", "-"]
        + [*_X264.split(), *_FRAGMENTS.split(), "-"],
        input=b"".join(pictures),
        capture_output=True,
    )
    if made.returncode != 0:
        said = made.stderr.decode(errors="replace").strip().splitlines() or ["no reason given"]
        raise Stop(ExitCode.FAILED, f"ffmpeg made no film of {run.name} ({said[-1]}). Try another --plane.")
    return made.stdout


def _picture(run: RunRecord, view: flow.View, step: int) -> flow.FlowPicture:
    picture = flow.choose(run, replace(view, time=str(step)))
    assert picture is not None
    return picture
