"""Messages of a recording as lines, and how many there are of each kind."""

from collections import Counter

from copepod_component.messages import message_name

_ROLES = {0: "?", 1: "fluid", 2: "body"}
_LANES = {0: "?", 1: "data", 2: "control"}
_ARROWS = {1: "-->", 2: "<--"}


def lines(recording):
    """One line per message: time since the first, component, lane, direction, step, sequence, name, bytes."""
    start = None
    for recorded, envelope in recording.messages():
        start = recorded.time_ns if start is None else start
        about = _name(envelope)
        if envelope:
            again = f", attempt {envelope.attempt}" if envelope.attempt else ""
            about = f"step {envelope.step} #{envelope.sequence}{again} {about}"
        role, lane = _ROLES.get(recorded.role, "?"), _LANES.get(recorded.lane, "?")
        yield (
            f"{(recorded.time_ns - start) * 1e-9:13.6f} s  {_ARROWS.get(recorded.direction, '?')} "
            f"{role:5} {lane:7}  {about}, {len(recorded.envelope)} bytes"
        )


def counts(recording):
    """[(component, direction, message, number, bytes)], most bytes first."""
    number: Counter = Counter()
    size: Counter = Counter()
    for recorded, envelope in recording.messages():
        key = (_ROLES.get(recorded.role, "?"), "to" if recorded.direction == 1 else "from", _name(envelope))
        number[key] += 1
        size[key] += len(recorded.envelope)
    return [(*key, number[key], size[key]) for key, _ in size.most_common()]


def _name(envelope):
    return (message_name(envelope) or "none") if envelope else "not an intact Envelope"
