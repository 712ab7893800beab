"""Lists, counts, draws and replays what a run recorded: python3 -m copepod_recording list RUN_DIR, and so on."""

import argparse
import json
import os
import shutil
import signal
import sys
import tempfile
from contextlib import closing
from pathlib import Path

from copepod_conformance.__main__ import called_as, end, number_type

_SHOWN = 10  # differences
_PATIENCE_S = 600.0  # for a reply
_SOLVER_FAILED, _STORAGE_FAILED, _TERMINATED = 70, 73, 143


def main():
    """Exit code 0 if a replay shows no difference, and for the other commands if there is a recording."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(_TERMINATED))
    options = _options(sys.argv[1:])
    from copepod_component.errors import ComponentError  # late: --help is answered before the messages are generated

    try:
        return options.action(options) or 0
    except ComponentError as error:
        end(error, int(error.code))
    except BrokenPipeError:  # the reader of the output has ended, as in `… list RUN_DIR | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except OSError as problem:
        end(f"{problem.filename} cannot be used ({problem.strerror}).", _STORAGE_FAILED)


def make_parser():
    """Of what stands before --."""
    parser = argparse.ArgumentParser(
        prog=called_as("recording"), description="Lists, counts, draws and replays what a run recorded."
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def add(name, action, text):
        command = commands.add_parser(name, help=text, description=text)
        command.add_argument("directory", metavar="RUN_DIR")
        command.add_argument("--attempt", type=int, metavar="N", help="attempt of a resumed run (default: the last)")
        command.set_defaults(action=action)
        return command

    add("list", _list, "print one line per message")
    add("count", _count, "print the number and size of the messages of each kind")
    trace = add("trace", _trace, "write what every process did when, for https://ui.perfetto.dev and chrome://tracing")
    trace.add_argument("--steps", type=_steps, metavar="START:STOP", help="only these steps")
    trace.add_argument("--out", metavar="FILE", help="file to write (default: RUN_DIR/trace.json)")
    trace.add_argument("--picture", metavar="FILE", type=_picture, help="also draw the steps, as PNG or SVG")
    tolerance = number_type(float, 0.0, "relative difference (a number ≥ 0, such as 1e-9)")
    replay = add("replay", _replay, "play the coupler of the run to the component that the command after -- starts")
    component = add("component", _component, "take part in a run as the recorded component")
    for command in (replay, component):
        command.add_argument("--role", required=True, help="fluid, body, or the name of a controller")
        command.add_argument(
            "--tolerance", type=tolerance, default=0.0, metavar="X", help="relative difference (default: 0, every bit)"
        )
    return parser


def _options(arguments):
    parser = make_parser()
    place = arguments.index("--") if "--" in arguments else len(arguments)
    options, options.others = parser.parse_known_args(arguments[:place])
    options.command = arguments[place + 1 :]
    if options.others and (options.command or options.action is not _component):
        parser.error(f"unrecognized arguments: {' '.join(options.others)}")
    return options


def _wire(options):
    from copepod_recording.reader import Recording, recorded

    return Recording(recorded(options.directory, "wire", options.attempt))


def _list(options):
    from copepod_recording.reader import lines

    recording = _wire(options)
    for line in lines(recording):
        print(line)
    _print_endings([recording])


def _count(options):
    from copepod_recording.reader import counts

    recording = _wire(options)
    rows = counts(recording)
    print(f"{'component':10} {'':4} {'message':20} {'number':>10} {'bytes':>14}")
    for component, direction, name, number, size in rows:
        print(f"{component:10} {direction:4} {name:20} {number:10d} {size:14d}")
    print(f"{'all':36} {sum(row[3] for row in rows):10d} {sum(row[4] for row in rows):14d}")
    _print_endings([recording])


def _trace(options):
    from copepod_recording import trace
    from copepod_recording.reader import Recording, recorded

    folder = recorded(options.directory, "trace", options.attempt)
    processes = [Recording(path) for path in sorted(folder.glob("*.rec"))]
    wire = _wire(options) if list((Path(options.directory) / "wire").glob("*.rec")) else None
    timelines = trace.read(processes)
    shown = trace.window(timelines, options.steps)
    if not any(timeline.phases for timeline in shown):
        steps = [phase.step for timeline in timelines for phase in timeline.phases if phase.step >= 0]
        found = f"the recorded steps are {min(steps)} to {max(steps)}" if steps else "no step was recorded"
        end(f"There is nothing to draw ({found}). Choose other --steps.")
    out = Path(options.out or Path(options.directory) / "trace.json")
    out.write_text(json.dumps(trace.as_json(shown, wire)))
    print(f"{out}: open it with https://ui.perfetto.dev or chrome://tracing")
    if figures := trace.overlap(timelines):
        print(trace.overlap_text(figures))
    if options.picture:
        trace.draw(shown, options.picture)
        print(options.picture)
    _print_endings(processes)


def _replay(options):
    import zmq

    from copepod_conformance.component_process import Component
    from copepod_recording.replay import replay, script_of

    recording = _wire(options)
    script = script_of(recording, options.role)
    if not script.exchanges:
        end(f"{recording.path} has no requests to the {options.role} component. Record a longer run.")
    start = script.restore
    if start is not None and not Path(start.path).parent.exists():
        end(
            f"{recording.path.stem} cannot be replayed (it resumed from {Path(start.path).parent}, which no longer "
            "exists: a run keeps only its last checkpoints). Replay an earlier --attempt, or record a run that is not "
            "resumed."
        )
    if not options.command or shutil.which(options.command[0]) is None:
        name = " ".join(options.command) or "(none given)"
        end(f"The {options.role} component {name} cannot be started (no such program). Give its path.")
    compared, number, shown = 0, 0, []
    try:
        with tempfile.TemporaryDirectory(prefix="copepod-replay-") as folder, zmq.Context() as context:
            component = Component(options.command, dict(os.environ), folder, context, _PATIENCE_S, shows_output=True)
            with closing(replay(component, options.role, script, options.tolerance)) as replies:
                for exchange, differences in replies:
                    compared += 1
                    for number, text in enumerate(differences, number + 1):
                        if number <= _SHOWN:
                            shown.append(f"step {exchange.request.step}: {text}")
    finally:
        for line in shown:
            print(line)
    _print_endings([recording])
    how = f"within a relative difference of {options.tolerance:g}" if options.tolerance else "bit by bit"
    if number:
        end(
            f"{number} values in {compared} replies differ from the recording (compared {how}; the first "
            f"{min(number, _SHOWN)} above). Another build or solver? --tolerance allows for rounding.",
            _SOLVER_FAILED,
        )
    print(f"{compared} replies agree {how}")


def _component(options):
    from copepod_recording.replay import serve_recording

    sys.argv[1:] = options.others
    return serve_recording(options.role, _wire(options), options.tolerance)


def _print_endings(recordings):
    for recording in recordings:
        if recording.ending:
            print(f"{recording.path} is {recording.ending}; what comes before was used.", file=sys.stderr)


def _steps(text):
    """(start, stop) of "start:stop"."""
    start, separator, stop = text.partition(":")
    if not separator or not start.isdigit() or not stop.isdigit() or int(stop) <= int(start):
        raise argparse.ArgumentTypeError("must be START:STOP with START < STOP, as in 100:104")
    return int(start), int(stop)


def _picture(text):
    if Path(text).suffix.lower() not in (".png", ".svg"):
        raise argparse.ArgumentTypeError(f"{text} is neither PNG nor SVG. Use FILE.png or FILE.svg.")
    return text


if __name__ == "__main__":
    sys.exit(main())
