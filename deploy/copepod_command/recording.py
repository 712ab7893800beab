"""`copepod recording`: lists, counts and draws what a run recorded."""

import json
from pathlib import Path

from copepod_run import destinations
from copepod_run.errors import ExitCode, Stop
from copepod_run.messages import say


def recording(options):
    """Returns 0; raises Stop if there is no recording."""
    return {"list": _list, "count": _count, "trace": _trace}[options.what](options)


def _open(path):
    from copepod_recording.reader import Recording, UnreadableRecording

    try:
        return Recording(path)
    except (OSError, UnreadableRecording) as problem:
        raise Stop(ExitCode.STORAGE_FAILED, str(problem)) from None


def _wire(options):
    from copepod_recording.location import wire_file

    return _open(wire_file(options.directory, options.attempt))


def _list(options):
    from copepod_recording.listing import lines

    recorded = _wire(options)
    for line in lines(recorded):
        print(line)
    _say_where_it_ends([recorded])
    return ExitCode.FINISHED


def _count(options):
    from copepod_recording.listing import counts

    recorded = _wire(options)
    rows = counts(recorded)
    print(f"{'component':10} {'':4} {'message':20} {'number':>10} {'bytes':>14}")
    for component, direction, name, number, size in rows:
        print(f"{component:10} {direction:4} {name:20} {number:10d} {size:14d}")
    print(f"{'all':36} {sum(row[3] for row in rows):10d} {sum(row[4] for row in rows):14d}")
    _say_where_it_ends([recorded])
    return ExitCode.FINISHED


def _trace(options):
    from copepod_recording import shadow, trace
    from copepod_recording.location import trace_folder, wire_file

    folder = trace_folder(options.directory, options.attempt)
    out = Path(options.out or Path(options.directory) / "trace.json")
    destinations.require_file(out, "--out")
    _require_picture(options.picture)
    processes = [_open(path) for path in sorted(folder.glob("*.rec"))]
    wire = None
    if list((Path(options.directory) / "wire").glob("*.rec")):
        wire = _open(wire_file(options.directory, options.attempt))
    timelines = trace.read(processes)
    shown = trace.window(timelines, options.steps)
    if not any(timeline.phases for timeline in shown):
        raise Stop(ExitCode.BAD_CASE, f"there is nothing to draw ({_what_there_is(timelines)}). Choose other --steps.")
    out.write_text(json.dumps(trace.as_json(shown, wire)))
    print(f"{out}: open it with https://ui.perfetto.dev or chrome://tracing")
    figures = shadow.figures(timelines)
    if figures:
        print(shadow.text(figures))
    if options.picture:
        from copepod_recording import picture

        picture.draw(shown, options.picture)
        print(options.picture)
    _say_where_it_ends(processes)
    return ExitCode.FINISHED


def _require_picture(path):
    """Raises Stop unless a picture can be written there."""
    destinations.require_file(path, "--picture")
    if path and Path(path).suffix.lower() not in (".png", ".svg"):
        raise Stop(
            ExitCode.BAD_CASE, f"--picture {path} is neither PNG nor SVG (the name tells). Use FILE.png or FILE.svg."
        )


def _what_there_is(timelines):
    steps = [phase.step for timeline in timelines for phase in timeline.phases if phase.step >= 0]
    return f"{min(steps)} to {max(steps)} are the recorded steps" if steps else "the recording holds no step"


def _say_where_it_ends(recordings):
    for recorded in recordings:
        if recorded.ending:
            say(f"{recorded.path} is {recorded.ending}; what comes before was used")
