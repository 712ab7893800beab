#!/usr/bin/python3
"""Test vectors of the protocol: checksums, and one frame of every message, for components without a kit.

protocol_vectors.py           prints docs/protocol_vectors.json
protocol_vectors.py --write   writes that file, and the tables and examples of docs/protocol.md between their marks
"""

import json
import re
import sys
from pathlib import Path

from google.protobuf.json_format import MessageToDict

from copepod.v1 import handshake_pb2
from copepod_component.messages import TRANSITIONS, Envelope, checksum, to_frame
from copepod_conformance import protocol
from copepod_conformance.cases import BodyCase, ControllerCase, FluidCase

ROOT = Path(__file__).resolve().parents[2]
FILE = ROOT / "docs" / "protocol_vectors.json"
PAGE = ROOT / "docs" / "protocol.md"
SESSION, EPOCH = 7, 3
_ANY = "any before the end"
_FAILURE = {
    "code": 70,
    "component": "fluid",
    "host": "here",
    "step": 2,
    "reason": "It diverged (NaN). Use a smaller step.",
}


def frames():
    """{message: (Envelope, frame)}, in the order of the schema."""
    envelopes = {name: _envelope(name) for name in protocol.MESSAGES}
    return {name: (envelope, to_frame(envelope)) for name, envelope in envelopes.items()}


def _envelope(name):
    numbered = {
        "FluidSetup": (1, 0),
        "BodySetup": (1, 0),
        "ControllerSetup": (1, 0),
        "Configured": (1, 0),
        "Kinematics": (2, 0),
        "Loads": (2, 0),
    }
    header = {"protocol_major": 2, "protocol_minor": 0, "session_id": SESSION, "epoch": EPOCH, "step": -1}
    if name in ("Hello", "Welcome", "Refusal"):
        header.update(session_id=0, epoch=0)
    elif name in ("Ping", "Pong", "Abort", "Failure"):
        header.update(step=2 if name in ("Pong", "Failure") else -1)
    else:
        header["sequence"], header["step"] = numbered.get(name, (5, 3))
    envelope = {
        "FluidSetup": FluidCase(set()).setup_request,
        "BodySetup": BodyCase({"actuator:pair_force"}).setup_request,
        "Kinematics": lambda: FluidCase(set()).step_request(0),
        "AppliedLoads": lambda: BodyCase({"actuator:pair_force"}).step_request(0),
        "ControllerSetup": ControllerCase(set()).setup_request,
        "Observation": lambda: ControllerCase(set()).step_request(0),
    }.get(name, Envelope)()
    for field, value in header.items():
        setattr(envelope, field, value)
    _fill(name, protocol.part(envelope, name))
    return envelope


def _fill(name, message):
    if name == "Hello":
        message.role, message.lane = 1, 1
        message.versions.major, message.versions.minor_min, message.versions.minor_max = 2, 0, 0
        message.session_token, message.host, message.pid, message.ranks, message.instance = "token", "here", 123, 1, 99
        message.capabilities.name, message.capabilities.version = "My fluid", "1.0"
        message.capabilities.features.extend(["shape:sphere", "solver:external"])
    elif name == "Welcome":
        message.minor, message.session_id, message.epoch = 0, SESSION, EPOCH
    elif name == "Refusal":
        message.reason = "The fluid component was refused (its session token is not that of this run)."
    elif name == "Configured":
        message.driving_nodes.append(0.0)
    elif name == "Loads":
        message.force_N.extend([1e-9, -2e-9, 0.5e-9] * 2)
        message.torque_N_m.extend([0.0] * 6)
    elif name == "Action":
        message.value.extend([1e-9, -2e-9, 0.5e-9])
    elif name in ("Save", "Restore"):
        message.path = "/tmp/checkpoint"
    elif name == "Summary":
        message.digest, message.cell_updates, message.ranks = 0x123456789ABCDEF0, 1000, 1
        message.seconds["bulk"] = 0.25
    elif name == "Ping":
        message.stamp_ns = 42
    elif name == "Pong":
        message.stamp_ns, message.step, message.phase = 42, 2, 2
        message.received_sequence = message.replied_sequence = 4
    elif name in ("Failure", "Abort"):
        failure = message.failure if name == "Abort" else message
        for field, value in _FAILURE.items():
            setattr(failure, field, value)


def as_json():
    """The text of docs/protocol_vectors.json."""
    vectors = [
        {"message": name, "envelope": MessageToDict(envelope, preserving_proto_field_name=True), "frame": frame.hex()}
        for name, (envelope, frame) in frames().items()
    ]
    return json.dumps({"vectors": vectors}, indent=1, ensure_ascii=False) + "\n"


def checksums():
    """Rows of the table of docs/protocol.md."""
    rows = ["| bytes | XXH3 (hexadecimal number) | the nine bytes on the wire |", "|---|---|---|"]
    for text, content in (("none", b""), ("`abc` (61 62 63)", b"abc"), ("0, 1, …, 255", bytes(range(256)))):
        number = int.from_bytes(checksum(content)[1:], "little")
        rows.append(f"| {text} | {number:016x} | {checksum(content).hex(' ')} |")
    return "\n".join(rows)


def ping():
    """The frame of the Ping, field by field."""
    frame = frames()["Ping"][1]
    parts = (
        (2, "protocol_major = 2"),
        (9, "session_id = 7"),
        (2, "epoch = 3"),
        (2, "step = −1 (sint64: zigzag)"),
        (12, "ping: 9 bytes, stamp_ns = 42"),
        (9, "checksum"),
    )
    lines, place = [], 0
    for length, meaning in parts:
        lines.append(f"{frame[place:place + length].hex(' '):<36} {meaning}")
        place += length
    assert place == len(frame)
    return "\n".join(["```", *lines, "```"])


def _roles(row):
    return "all" if len(row["roles"]) > 1 else row["roles"][0]


def _trigger(row):
    return row.get("event") or row["message"]


def transitions():
    """The transition table, a row each."""
    rows = ["| role | in state | on | does | replies | then |", "|---|---|---|---|---|---|"]
    for row in TRANSITIONS:
        states = _ANY if _is_from_anywhere(row) else ", ".join(row["from"])
        trigger = f"*{row['event']}*" if "event" in row else f"`{row['message']}`"
        work = "" if row["work"] == "none" else row["work"]
        reply = f"`{row['reply']}`" if "reply" in row else ""
        rows.append(f"| {_roles(row)} | {states} | {trigger} | {work} | {reply} | {row.get('to', 'same')} |")
    return "\n".join(rows)


def state_diagram():
    """The same as a diagram; work that ends in its initial state is part of the request's arrow."""
    arrows = {}
    for state in dict.fromkeys(name for row in TRANSITIONS for name in row["from"]):
        for row in TRANSITIONS:
            if state in row["from"] and not _is_from_anywhere(row) and ("to" in row or "message" in row):
                arrows.setdefault((state, row.get("to", state)), []).append(_label(row))
    lines = ["```mermaid", "stateDiagram-v2", "  [*] --> connected: Hello"]
    lines += [f"  {start} --> {end}: {', '.join(labels)}" for (start, end), labels in arrows.items()]
    lines += [f'  state "{_ANY}" as running']
    lines += [f"  running --> {row['to']}: {_label(row)}" for row in TRANSITIONS if _is_from_anywhere(row)]
    return "\n".join([*lines, "```"])


def _is_from_anywhere(row):
    return {"connected", "stepping", "checkpointing"} <= set(row["from"])


def _label(row):
    reply = f" → {row['reply']}" if "reply" in row else ""
    return _trigger(row) + reply + ("" if _roles(row) == "all" else f" ({_roles(row)})")


def features():
    """The names that components announce."""
    table = json.loads(Path(handshake_pb2.__file__).with_name("features.json").read_text())
    rows = [f"| `{row['name']}` | {row['kind']} | {row['meaning']} |" for row in table]
    return "\n".join(["| feature | kind | meaning |", "|---|---|---|", *rows])


def page(text):
    """docs/protocol.md with its tables and examples brought up to date."""
    generated = (checksums, ping, transitions, state_diagram, features)
    for name, content in ((make.__name__, make()) for make in generated):
        text, found = re.subn(
            rf"(<!-- protocol_vectors {name} -->\n).*?(<!-- end -->)",
            lambda marks: f"{marks[1]}{content}\n{marks[2]}",
            text,
            flags=re.DOTALL,
        )
        assert found == 1, f"docs/protocol.md lacks the mark of {name}"
    return text


if __name__ == "__main__":
    if sys.argv[1:] == ["--write"]:
        FILE.write_text(as_json())
        PAGE.write_text(page(PAGE.read_text()))
    else:
        print(as_json(), end="")
