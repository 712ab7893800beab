"""Phases of all processes of a run on one clock: a picture, or a trace in the format of Perfetto and chrome://tracing.

The format: https://docs.google.com/document/d/1CvAClvFfyA5R-PhYUmn5OOQtYMH4h6I0nSsKchNAySU ("Trace Event Format").
"""

from dataclasses import dataclass

from copepod_component.messages import message_name
from copepod_recording.reader import ROLES

_ORDER = {"coupler": 0, "body": 1, "fluid": 2}
_MESSAGES = 100  # process number of the recorded messages
_COLOURS = {
    "waiting": "#eeeeee",
    "wait for fluid": "#eeeeee",
    "wait for bodies": "#dddddd",
    "exchanging": "#f2c14e",
    "advancing": "#8fb8de",
    "couple": "#d1495b",
    "integrate": "#66a182",
    "map": "#c98c10",
    "refill": "#e09f3e",
    "momentum": "#a44a3f",
    "reduce": "#7d4e57",
    "halo": "#9d4edd",
    "bulk": "#2e6f9e",
}
_OTHER = "#999999"
_OF_PROTOCOL = ("waiting", "exchanging", "advancing", "configuring", "checkpointing", "couple")


@dataclass(frozen=True)
class Phase:
    """What a process did from `begin_ns` to `end_ns`, on the coupler's clock."""

    name: str
    step: int
    begin_ns: int
    end_ns: int


@dataclass(frozen=True)
class Timeline:
    """Phases of one process (of one rank), by begin; those inside others follow them."""

    process: str
    rank: int
    phases: list

    @property
    def title(self):
        return f"{self.process} rank {self.rank}" if self.process == "fluid" else self.process


def read(recordings):
    """Timeline of every recording, coupler first; all on the clock of the first one."""
    ordered = sorted(recordings, key=lambda each: (_ORDER.get(each.header.process, len(_ORDER)), each.header.rank))
    return [_timeline(recording, ordered[0].header) for recording in ordered]


def _timeline(recording, reference):
    header = recording.header
    shift = 0
    if header.clock != reference.clock:  # another machine: as good as their clocks of the day agree
        shift = (header.utc_ns - header.monotonic_ns) - (reference.utc_ns - reference.monotonic_ns)
    phases = [
        Phase(phase.name, phase.step, phase.begin_ns + shift, phase.begin_ns + phase.duration_ns + shift)
        for phase in recording.phases()
    ]
    phases.sort(key=lambda phase: (phase.begin_ns, -phase.end_ns))
    return Timeline(header.process, header.rank, phases)


def window(timelines, steps):
    """Only what belongs to steps [start, stop); everything if `steps` is None."""
    if steps is None:
        return timelines
    start, stop = steps
    return [
        Timeline(each.process, each.rank, [phase for phase in each.phases if start <= phase.step < stop])
        for each in timelines
    ]


def as_json(timelines, wire=None):
    """{"traceEvents": […]}: one track per process and rank, and one per lane if messages were recorded too."""
    begins = [phase.begin_ns for timeline in timelines for phase in timeline.phases]
    ends = [phase.end_ns for timeline in timelines for phase in timeline.phases]
    start, end = min(begins, default=0), max(ends, default=0)
    events = []
    for number, timeline in enumerate(timelines, 1):
        events += _names(number, timeline.title, 0, timeline.title)
        events += [
            _complete(number, 0, phase.name, phase.begin_ns - start, phase.end_ns - start, phase.step)
            for phase in timeline.phases
        ]
    if wire is not None:
        events += _messages(wire, start, end)
    return {"traceEvents": events, "displayTimeUnit": "ns"}


def _names(process, process_name, thread, thread_name):
    return [
        {"ph": "M", "name": "process_name", "pid": process, "tid": 0, "args": {"name": process_name}},
        {"ph": "M", "name": "process_sort_index", "pid": process, "tid": 0, "args": {"sort_index": process}},
        {"ph": "M", "name": "thread_name", "pid": process, "tid": thread, "args": {"name": thread_name}},
    ]


def _complete(process, thread, name, begin_ns, end_ns, step):
    """A phase; times are microseconds."""
    return {
        "ph": "X",
        "pid": process,
        "tid": thread,
        "name": name,
        "cat": "phase",
        "ts": begin_ns * 1e-3,
        "dur": (end_ns - begin_ns) * 1e-3,
        "args": {"step": step},
    }


def _messages(wire, start, end):
    """From each request until its reply, as the coupler's socket saw both."""
    events = []
    for role, name in ROLES.items():
        events += _names(_MESSAGES, "messages", role, f"{name}: request to reply")
    requests: dict = {}
    for recorded, envelope in wire.messages():
        if recorded.lane != 1 or recorded.role not in ROLES or not start <= recorded.time_ns <= end or not envelope:
            continue
        key = (recorded.role, envelope.sequence)
        if recorded.direction == 1:
            requests.setdefault(key, (recorded.time_ns, message_name(envelope), envelope.step))
        elif key in requests:
            sent, name, step = requests.pop(key)
            name = f"{name} → {message_name(envelope)}"
            events.append(_complete(_MESSAGES, recorded.role, name, sent - start, recorded.time_ns - start, step))
    return events


def draw(timelines, path):
    """One bar per process and rank, what is inside a phase drawn over it; PNG or SVG after the suffix of the path."""
    import matplotlib  # slow to load

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    start = min(phase.begin_ns for each in timelines for phase in each.phases)
    figure, axes = plt.subplots(figsize=(11, 0.7 * len(timelines) + 1.6))
    seen = []
    for row, timeline in enumerate(reversed(timelines)):
        for phase in timeline.phases:
            colour = _COLOURS.get(phase.name, _OTHER)
            is_outer = phase.name in _OF_PROTOCOL or phase.name.startswith("wait ")  # those of solvers lie inside
            height = 0.8 if is_outer else 0.45
            begin, length = (phase.begin_ns - start) * 1e-3, (phase.end_ns - phase.begin_ns) * 1e-3
            axes.barh(row, length, left=begin, height=height, color=colour, linewidth=0)
            if phase.name not in seen:
                seen.append(phase.name)
    axes.set_yticks(range(len(timelines)), [timeline.title for timeline in reversed(timelines)])
    axes.set_xlabel("time [µs]")
    axes.margins(x=0)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    handles = [plt.Rectangle((0, 0), 1, 1, color=_COLOURS.get(name, _OTHER)) for name in seen]
    figure.legend(handles, seen, loc="upper center", ncols=min(9, len(seen)), frameon=False, fontsize=8)
    figure.tight_layout(rect=(0, 0, 1, 0.86))
    figure.savefig(path, dpi=130)
    plt.close(figure)
