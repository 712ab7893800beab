"""The protocol as data: queries of the message classes and the transition table. There is no second copy of either."""

from collections import deque

from copepod_component.messages import TRANSITIONS, Envelope, handshake, message_name, transition

_FIELDS = {field.message_type.name: field.name for field in Envelope.DESCRIPTOR.oneofs_by_name["body"].fields}
MESSAGES = tuple(_FIELDS)  # every message of the protocol, in the order of the schema
HANDSHAKE = ("Welcome", "Refusal")
SETUP = {"fluid": "FluidSetup", "body": "BodySetup", "controller": "ControllerSetup"}
STEP = {"fluid": "Kinematics", "body": "AppliedLoads", "controller": "Observation"}
ROLE_NUMBER = {role: handshake.Role.Value(f"ROLE_{role.upper()}") for role in SETUP}
START, WORK_DONE = "connected", "work done"


def part(envelope, name):
    """The message `name` inside an Envelope; made present if it is not."""
    message = getattr(envelope, _FIELDS[name])
    message.SetInParent()
    return message


def content(envelope):
    """The message inside an Envelope."""
    return getattr(envelope, envelope.WhichOneof("body"))


def reply_to(message):
    """Name of the reply to a request; it does not depend on the state."""
    return next(row["reply"] for row in TRANSITIONS if row.get("message") == message)


def settled(role, state):
    """The state once the work at hand is done: `stepping` becomes `ready`."""
    row = transition(role, state, event=WORK_DONE)
    return row.get("to", state) if row else state


def states_with_requests(role):
    """States in which a component can be sent a message, in the order of a run."""
    return [state for state in paths(role) if transition(role, state, event="work failed")]


def paths(role):
    """As few messages as possible that lead from the start to each state; without Restore, since what it reads must
    have been saved before."""
    found: dict[str, list] = {START: []}
    queue = deque([START])
    while queue:
        state = queue.popleft()
        for row in TRANSITIONS:
            if role not in row["roles"] or state not in row["from"] or "to" not in row:
                continue
            name = row.get("message")
            if row["to"] not in found and (name or row.get("event") == WORK_DONE) and name != "Restore":
                found[row["to"]] = found[state] + ([name] if name else [])
                queue.append(row["to"])
    return found


def describe(envelope):
    """«Kinematics #4 of step 2», for people."""
    text = message_name(envelope) or "an empty Envelope"
    if envelope.sequence:
        text += f" #{envelope.sequence}"
    if envelope.step >= 0 and envelope.sequence:
        text += f" of step {envelope.step}"
    if envelope.WhichOneof("body") == "failure":
        text += f" (code {envelope.failure.code}: {envelope.failure.reason})"
    return text
