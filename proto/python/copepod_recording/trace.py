"""Phases of all processes of a run on one clock: a picture, or a trace in the format of Perfetto and chrome://tracing.

The format: https://docs.google.com/document/d/1CvAClvFfyA5R-PhYUmn5OOQtYMH4h6I0nSsKchNAySU ("Trace Event Format").
"""

from dataclasses import dataclass, replace
from operator import ge
from statistics import median

from copepod_component.messages import handshake, message_name, recording as schema
from copepod_recording.reader import party_of

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
    return [replace(each, phases=[phase for phase in each.phases if start <= phase.step < stop]) for each in timelines]


def as_json(timelines, wire=None):
    """{"traceEvents": […]}: one track per process and rank, and one per lane if messages were recorded too."""
    start = min(phase.begin_ns for timeline in timelines for phase in timeline.phases)
    end = max(phase.end_ns for timeline in timelines for phase in timeline.phases)
    tracks = [(number, each.title, 0, each.title, each.phases) for number, each in enumerate(timelines, 1)]
    if wire is not None:
        for number, (party, phases) in enumerate(_messages(wire, start, end).items(), 1):
            tracks.append((_MESSAGES, "messages", number, f"{party}: request to reply", phases))
    events = []
    for process, process_name, thread, thread_name, phases in tracks:
        events += [
            {"ph": "M", "name": "process_name", "pid": process, "tid": 0, "args": {"name": process_name}},
            {"ph": "M", "name": "process_sort_index", "pid": process, "tid": 0, "args": {"sort_index": process}},
            {"ph": "M", "name": "thread_name", "pid": process, "tid": thread, "args": {"name": thread_name}},
        ]
        for phase in phases:
            times_us = {"ts": (phase.begin_ns - start) * 1e-3, "dur": (phase.end_ns - phase.begin_ns) * 1e-3}
            about: dict = {"name": phase.name, "cat": "phase", "args": {"step": phase.step}}
            events.append({"ph": "X", "pid": process, "tid": thread, **about, **times_us})
    return {"traceEvents": events, "displayTimeUnit": "ns"}


def _messages(wire, start, end):
    """By component: from each request until its reply, as the coupler's socket saw both."""
    found: dict = {"fluid": [], "body": []}
    requests: dict = {}
    for recorded, envelope in wire.messages():
        party = party_of(recorded)
        if recorded.lane != handshake.LANE_DATA or party == "?" or envelope is None:
            continue
        if not start <= recorded.time_ns <= end:
            continue
        key = (party, envelope.sequence)
        if recorded.direction == schema.DIRECTION_TO_COMPONENT:
            requests.setdefault(key, (recorded.time_ns, envelope))
        elif key in requests:
            sent, request = requests.pop(key)
            name = f"{message_name(request)} → {message_name(envelope)}"
            found.setdefault(party, []).append(Phase(name, request.step, sent, recorded.time_ns))
    return found


def draw(timelines, path):
    """One bar per process and rank, what is inside a phase drawn over it; PNG or SVG after the suffix of the path."""
    from matplotlib.figure import Figure  # slow to load

    start = min(phase.begin_ns for each in timelines for phase in each.phases)
    figure = Figure(figsize=(11, 0.7 * len(timelines) + 1.6))
    axes = figure.subplots()
    bars: dict = {}  # by name
    for row, timeline in enumerate(reversed(timelines)):
        for phase in timeline.phases:
            colour = _COLOURS.get(phase.name, _OTHER)
            is_outer = phase.name in _OF_PROTOCOL or phase.name.startswith("wait ")  # those of solvers lie inside
            height = 0.8 if is_outer else 0.45
            begin, length = (phase.begin_ns - start) * 1e-3, (phase.end_ns - phase.begin_ns) * 1e-3
            bar = axes.barh(row, length, left=begin, height=height, color=colour, linewidth=0)
            bars.setdefault(phase.name, bar)
    axes.set_yticks(range(len(timelines)), [timeline.title for timeline in reversed(timelines)])
    axes.set_xlabel("time [µs]")
    axes.margins(x=0)
    axes.spines[["top", "right", "left"]].set_visible(False)
    figure.legend(bars.values(), bars, loc="upper center", ncols=min(9, len(bars)), frameon=False, fontsize=8)
    figure.tight_layout(rect=(0, 0, 1, 0.86))
    figure.savefig(path, dpi=130)


def _steps(timelines):
    """Nanoseconds of each step that the coupler and the rank 0 of the fluid recorded whole: the bulk update after the
    reply; the round trip, from the reply until the coupler asked about the next step; the part of that during which the
    bulk update ran; how long the fluid waited for the next request, after its bulk update."""
    fluid = next((each for each in timelines if (each.process, each.rank) == ("fluid", 0)), None)
    coupler = next((each for each in timelines if each.process == "coupler"), None)
    if fluid is None or coupler is None:
        return
    exchanging, asks = _by_step(fluid, "exchanging"), _by_step(coupler, "wait for fluid")
    waits = {phase.begin_ns: phase.end_ns - phase.begin_ns for phase in fluid.phases if phase.name == "waiting"}
    for step, bulk in sorted(_by_step(fluid, "advancing").items()):
        if step in exchanging and step in asks and step + 1 in asks:
            # The coupler may have the loads before the fluid, on the same core, returns from sending them.
            replied = min(exchanging[step].end_ns, asks[step].end_ns)
            asked = asks[step + 1].begin_ns
            hidden = max(0, min(asked, bulk.end_ns) - max(replied, bulk.begin_ns))
            yield bulk.end_ns - bulk.begin_ns, asked - replied, hidden, waits.get(bulk.end_ns, 0)


def _by_step(timeline, name):
    """First phase of this name in each step."""
    return {phase.step: phase for phase in reversed(timeline.phases) if phase.name == name and phase.step >= 0}


def overlap(timelines):
    """How much of the coupling overlaps the bulk update: the gain of the early reply. Steps, medians in µs, shares of
    the round trip and of the steps that were hidden; empty without steps.

    Once the fluid has replied with the loads of step n, two things happen at the same time: its bulk update of step n,
    and the round trip over coupler, bodies and messages until the kinematics of step n + 1 arrive. What is left of the
    round trip after the bulk update is what the fluid waits for.
    """
    found = list(_steps(timelines))
    if not found:
        return {}
    bulk, round_trip, hidden, waited = zip(*found)
    return {
        "steps": len(found),
        "bulk_us": median(bulk) * 1e-3,
        "round_trip_us": median(round_trip) * 1e-3,
        "waited_us": median(waited) * 1e-3,
        "hidden": sum(hidden) / sum(round_trip) if sum(round_trip) > 0 else 1.0,
        "hidden_steps": sum(map(ge, hidden, round_trip)) / len(found),
    }


def overlap_text(figures):
    """These figures as a sentence or two."""
    return (
        f"{figures['steps']} steps; medians: bulk update {figures['bulk_us']:.0f} us, round trip over coupler and "
        f"bodies {figures['round_trip_us']:.0f} us, wait of the fluid {figures['waited_us']:.0f} us\n"
        f"hidden by the bulk update: {100 * figures['hidden']:.1f} % of the round trip; all of it in "
        f"{100 * figures['hidden_steps']:.1f} % of the steps"
    )
