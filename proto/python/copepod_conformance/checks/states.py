"""Every state × every message: what the table allows is done, everything else is answered with a Failure."""

from copepod_component.messages import legal_messages, transition
from copepod_conformance import protocol
from copepod_conformance.protocol import MESSAGES
from copepod_conformance.subject import SAVED_STEP
from copepod_conformance.verdicts import Check, Rule

_REFUSED = 65
_SAMPLING = 5


def _rule(state, settled, message, row):
    queued = f"a message waits until a {state} component is {settled}; there " if settled != state else ""
    if row is None and message in protocol.HANDSHAKE:
        return Rule("States", f"{queued}a {message} is ignored: the handshake is over")
    if row is None and settled == protocol.START:
        return Rule("Exactly once", f"{message} before the Welcome is ignored")
    if row is None:
        return Rule("States", f"{queued}{message} is not allowed: a Failure (code 65) names state and legal messages")
    answer = f"is answered with {row['reply']}" if "reply" in row else f"leads to {row.get('to', settled)}"
    return Rule("States", f"{queued}{message} {answer}")


def _is_announced(trial, settled, message):
    """False for what only components with a feature are sent that this one does not announce."""
    if message in ("Save", "Restore"):
        return trial.subject.can("checkpoint")
    return message != protocol.SETUP[trial.role] or settled == "greeted" or trial.subject.can("snapshots")


def _run(trial, state, settled, message, row):
    can = _is_announced(trial, settled, message)
    saved = trial.subject.checkpoint[0] if row is not None and can and message == "Restore" else ""
    trial.reach(state)
    if message == "Welcome":
        trial.welcome()
    elif message == "Refusal":
        trial.send(trial.make(message), sequence=0, session_id=0, epoch=0)
    else:  # as it would come in a run; of a message that is not allowed only the kind matters
        request = trial.make(message, saved)
        if saved:
            request.step = SAVED_STEP
        trial.send(request)
    if settled != state:
        trial.expect(protocol.reply_to(protocol.paths(trial.role)[state][-1]))  # to the work at hand
    if row is not None and not can:
        trial.expect_failure(_REFUSED)
    elif row is not None and message == "Refusal":
        trial.expect_failure(_REFUSED, is_sent=False)
    elif row is not None:
        if "reply" in row:
            trial.expect(row["reply"])
        if message == "Finish":
            trial.expect_exit(0)
        else:
            trial.finish()
    elif message in protocol.HANDSHAKE:
        trial.finish()
    elif settled == protocol.START:
        trial.sequence = 0  # it did not count
        trial.welcome()
        trial.finish()
    else:
        legal = [name for name in legal_messages(trial.role, settled) if _is_announced(trial, settled, name)]
        trial.expect_failure(_REFUSED, words=(settled, *legal))


def checks(subject):
    """Without `thorough`: all that is not refused; of what is, some messages in each state and every one in some."""
    found = []
    for place, state in enumerate(protocol.states_with_requests(subject.role)):
        settled = protocol.settled(subject.role, state)
        for number, message in enumerate(MESSAGES):
            row = transition(subject.role, settled, message=message)
            is_refused = row is None and message not in protocol.HANDSHAKE
            rule, how = _rule(state, settled, message, row), (state, settled, message, row)
            thorough = is_refused and (number + place) % _SAMPLING != 0
            found.append(Check("states", f"{state}: {message}", rule, _run, how, thorough=thorough))
    return found
