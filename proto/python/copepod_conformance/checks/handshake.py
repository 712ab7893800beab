"""How a component introduces itself, and which couplers it accepts."""

import difflib
import json
from functools import partial

from copepod_component.messages import FEATURES, PROTOCOL_MAJOR, PROTOCOL_MINOR, Envelope
from copepod_conformance.conversation import CONTROL, DATA
from copepod_conformance.protocol import ROLE_NUMBER, content
from copepod_conformance.verdicts import Check, Rule, Silence, Violation

_HELLO = Rule(
    "A run", "a component sends Hello on both lanes: role, versions, token, host, one instance number for both"
)
_CAPABILITIES = Rule("Command line", "--capabilities prints the content of the Hello: name, version, role, features")
_FEATURES = Rule("Features", "a component announces names of the table, or neglects:NAME")
_ESTIMATE = Rule(
    "Estimates", "--estimate reads a setup and prints memory_bytes and problem as JSON, or ends with 2 and an error"
)
_REFUSAL = Rule("A run", "after a Refusal the component ends with exit code 65")
_DEADLINE = Rule("Command line", "a coupler that does not answer within --connect-deadline: exit code 74")
_OPTIONS = Rule("Command line", "a bad command line: exit code 2")
_VERSIONS = Rule(
    "Versions",
    "another major version, or a minor one that was not offered, is refused with code 65; "
    "fields of a newer minor version are ignored",
)
# Of physics and runs, a component may also announce that it neglects them, or the whole group before a colon.
_NEGLECTABLE = {name for name, kind in FEATURES.items() if kind in ("physics", "run")}
_KNOWN = {*FEATURES, *(f"neglects:{what}" for name in _NEGLECTABLE for what in (name, name.partition(":")[0]))}
_OTHER_MAJORS = (PROTOCOL_MAJOR - 1, PROTOCOL_MAJOR + 1)
_UNKNOWN_FIELD = b"\xfa\x3f\x03new"  # number 1023, three bytes: what a newer minor version might add


def _hello(trial):
    trial.await_hello()
    hellos = {lane: trial.hellos[lane].envelope.hello for lane in (DATA, CONTROL)}
    first = hellos[DATA]
    for lane, hello in hellos.items():
        envelope, versions = trial.hellos[lane].envelope, hello.versions
        has_begun = envelope.session_id or envelope.epoch or envelope.sequence
        for wrong, text in (
            (hello.role != ROLE_NUMBER[trial.role], f"role {hello.role}, not that of a {trial.role} component"),
            (hello.session_token != trial.token, "a session token that is not the one of --session"),
            (hello.instance != first.instance, "another instance number on each lane"),
            (not hello.instance, "no instance number"),
            (not hello.host, "no host"),
            (hello.pid <= 0, f"process id {hello.pid}"),
            (hello.ranks < 1, f"{hello.ranks} ranks"),
            (versions.major != PROTOCOL_MAJOR, f"protocol {versions.major}, not {PROTOCOL_MAJOR}"),
            (versions.minor_min > versions.minor_max, "a range of minor versions that is empty"),
            (envelope.protocol_major != versions.major, "an Envelope of another version than its Hello"),
            (has_begun, "a session, epoch or number before the Welcome"),
        ):
            if wrong:
                raise Violation(f"a Hello on the {lane} lane with {text}")


def _capabilities(trial):
    trial.await_hello()
    told, printed = trial.hellos[DATA].envelope.hello.capabilities, trial.subject.capabilities
    pairs = {"name": told.name, "version": told.version, "role": trial.role, "features": sorted(told.features)}
    for key, value in pairs.items():
        if not value and key != "features":
            raise Violation(f"no {key}")
        if (sorted(printed.get(key, [])) if key == "features" else printed.get(key)) != value:
            raise Violation(f"{key} {printed.get(key)!r} from --capabilities, but {value!r} in the Hello")


def _known_features(trial):
    """A coupler cannot require a name that is not in its table."""
    trial.sent.append("nothing; read the features from --capabilities")
    texts = []
    for name in sorted(trial.subject.features - _KNOWN):
        near = difflib.get_close_matches(name, FEATURES, n=1)
        hint = f" (did you mean {near[0]}?)" if near else ""
        texts.append(f"feature '{name}', which is not a known name{hint}")
    if texts:
        raise Violation("; ".join(texts))


def _estimate(trial):
    code, output, words = _run_estimate(trial, content(trial.case.setup_request()).SerializeToString(), "a setup")
    if code != 0:
        raise Violation(f"exit code {code} instead of 0; its last words: {words}")
    try:
        estimate = json.loads(output)
        fits = estimate["memory_bytes"] > 0 and isinstance(estimate["problem"], str)
    except (ValueError, KeyError, TypeError):
        fits = False
    if not fits:
        raise Violation(f"«{output.strip()[:300]}» instead of JSON with memory_bytes and problem")


def _estimate_of_garbage(trial):
    code, _, words = _run_estimate(trial, b"\xff" * 20, "20 bytes that are not a setup")
    if code != 2 or "error" not in words:
        raise Violation(f"exit code {code} and last words «{words}» instead of 2 and «error: …»")


def _run_estimate(trial, standard_input, text):
    trial.sent.append(f"{text} on standard input of --estimate")
    return trial.subject.run_to_end("--estimate", standard_input=standard_input)


def _no_options(trial):
    trial.sent.append("nothing; started without options")
    code, *_ = trial.subject.run_to_end()
    if code is None:
        raise Silence("no end of the process")
    if code != 2:
        raise Violation(f"exit code {code} instead of 2")


def _refusal(trial):
    trial.await_hello()
    refusal = {"reason": "The component was refused (as part of a check). Ignore this."}
    message = Envelope(protocol_major=PROTOCOL_MAJOR, step=-1, refusal=refusal)
    for lane in (DATA, CONTROL):
        trial.send_bytes(message.SerializeToString(), "Refusal", lane)
    trial.expect_failure(65, is_sent=False)


def _no_answer(trial):
    trial.await_hello()
    trial.sent.append("nothing: the coupler does not answer the Hello, --connect-deadline is 1 s")
    trial.expect_exit(74, within_s=1 + trial.subject.patience_s)


def _other_welcome(trial, major=None):
    """Of another major version, or of a minor one that the component does not support."""
    trial.await_hello()
    minor = trial.hellos[DATA].envelope.hello.versions.minor_max + 1
    if major is None:
        trial.welcome(f" with minor version {minor}, which the Hello did not offer", minor)
    else:
        trial.welcome(f" of protocol {major}.0", protocol_major=major)
    trial.expect_failure(65, is_sent=False)


def _other_request(trial, major):
    trial.send(trial.make(trial.step_name), f" of protocol {major}.0", protocol_major=major)
    trial.expect_failure(65)


def _newer_minor(trial):
    trial.sequence += 1
    message = trial.with_header(trial.make(trial.step_name), protocol_minor=PROTOCOL_MINOR + 1)
    text = f"{trial.step_name} of minor version {PROTOCOL_MINOR + 1} with a field of that version"
    trial.send_bytes(message.SerializeToString() + _UNKNOWN_FIELD, text)
    trial.expect_reply(trial.step_name, message)


def checks(subject):
    check, version = partial(Check, "handshake"), partial(Check, "versions")
    return [
        check("Hello on both lanes", _HELLO, _hello),
        check("capabilities are the same from --capabilities and in the Hello", _CAPABILITIES, _capabilities),
        check("every feature is a known name", _FEATURES, _known_features),
        check("an estimate of the memory", _ESTIMATE, _estimate, needs=("estimate",)),
        check("no estimate of garbage", _ESTIMATE, _estimate_of_garbage, needs=("estimate",)),
        check("ends when it is refused", _REFUSAL, _refusal),
        check("ends without an answer", _DEADLINE, _no_answer, options=("--connect-deadline", "1")),
        check("ends without --endpoint and --session", _OPTIONS, _no_options),
        *(version(f"a Welcome of protocol {n}.0 is refused", _VERSIONS, _other_welcome, (n,)) for n in _OTHER_MAJORS),
        *(
            version(f"a request of protocol {n}.0 is refused", _VERSIONS, _other_request, (n,), steps=0)
            for n in _OTHER_MAJORS
        ),
        version("a Welcome of a minor version that it does not support is refused", _VERSIONS, _other_welcome),
        version("fields of a newer minor version are ignored", _VERSIONS, _newer_minor, steps=0),
    ]
