"""Liveness, stop requests, loss of the coupler; and the remains of a component afterwards."""

from copepod_conformance.conversation import CONTROL
from copepod_conformance.subject import Trial
from copepod_conformance.verdicts import Check, Rule, Violation

_ALIVE = Rule("Lanes", "a Ping is answered in the middle of a step too, with its stamp, step and sequence numbers")
_FOREIGN = Rule("Exactly once", "messages of another session or epoch are ignored, on both lanes")
_ABORT = Rule(
    "Who is alive", "after an Abort the component ends with the code that it carries, at the latest 2 s later"
)
_ORPHAN = Rule(
    "Who is alive",
    "a coupler whose connection is broken for 3 s, or that sends no ping for --orphan-after "
    "seconds, is lost: the component ends with code 69, at the latest 2 s later",
)
_SUSPENDED = Rule(
    "Who is alive", "a component that was suspended itself for more than a second begins to wait for its coupler anew"
)
_END = Rule("A run", "Finish is answered with Finished; then the component ends with exit code 0")
_NOTHING_LEFT = Rule("Who is alive", "whatever ends a component, no process of it is left behind 2 s later")
_IDLE = Rule("Who is alive", "a process that waits uses less than 5 % of a core")

_MARGIN_S = 3.0  # of a busy machine, beyond the times of the protocol
_GRACE_S = 2.0
_BROKEN_S = 3.0
_PONG_S = 1.0
_BURST = 200  # steps in the queue: enough work to be interrupted in
_OBSERVED_S = 2.0
_IDLE_SHARE = 0.05


def _pong_at_rest(trial):
    trial.wait(0.2)  # the bulk update of the last step
    pong, _ = trial.answer_to_ping()
    found, due = (pong.step, pong.received_sequence, pong.replied_sequence), (1, trial.sequence, trial.sequence)
    if found != due:
        raise Violation(f"Pong with step, received and replied sequence {found} instead of {due}")


def _pong_at_work(trial):
    _queue_steps(trial)
    _, seconds = trial.answer_to_ping()
    if seconds > _PONG_S:
        raise Violation(f"a Pong after {seconds:.1f} s instead of {_PONG_S} s")


def _foreign_ping(trial):
    trial.stop_pings()
    trial.wait(0.2)
    foreign, own = trial.ping(session_id=trial.session_id + 1), trial.ping()
    if (stamp := trial.expect("Pong", CONTROL).envelope.pong.stamp_ns) != own:
        raise Violation("a Pong to the Ping of another session" if stamp == foreign else f"a Pong with stamp {stamp}")


def _queue_steps(trial):
    for _ in range(_BURST):
        trial.send(trial.make(trial.step_name))
    trial.sent[-_BURST:] = [f"{_BURST} steps at once"]


def _reach(trial, state):
    trial.reach(state)
    if state == "stepping":
        _queue_steps(trial)


def _aborted(trial, state, code, codes=None):
    _reach(trial, state)
    trial.abort(code)
    trial.expect_exit(*(codes or (code,)), within_s=_GRACE_S + _MARGIN_S)


def _orphaned(trial, state):
    _reach(trial, state)
    trial.vanish()
    trial.expect_exit(69, within_s=_BROKEN_S + _GRACE_S + _MARGIN_S)


def _left_without_pings(trial):
    trial.configure()
    trial.stop_pings()
    trial.sent.append("nothing any more, not even pings; --orphan-after is 1 s")
    trial.expect_exit(69, within_s=1 + _GRACE_S + _MARGIN_S)


def _kept_by_pings(trial):
    trial.configure()
    trial.wait(4.0)
    trial.sent.append("only pings for 4 s; --orphan-after is 2 s")
    trial.advance(1)
    trial.finish()


def _suspended(trial):
    trial.suspend(3.5)
    trial.advance(1)
    trial.finish()


def _nothing_left_after(trial, ending):
    ending(trial)
    trial.await_end(max(trial.subject.patience_s, _BROKEN_S + _GRACE_S + _MARGIN_S))
    left = trial.process.left_behind()
    if left:
        raise Violation(f"{len(left)} process(es) left behind: {'; '.join(left)}")


def _idle(trial):
    trial.wait(0.5)
    before = trial.process.cpu_seconds()
    trial.wait(_OBSERVED_S)
    after = trial.process.cpu_seconds()
    trial.sent.append(f"only pings for {_OBSERVED_S:g} s")
    shares = [(after[pid] - before.get(pid, 0.0)) / _OBSERVED_S for pid in after]
    if not shares or max(shares) > _IDLE_SHARE:
        raise Violation(f"{100 * max(shares, default=0):.0f} % of a core used by a process that waits")


def checks(subject):
    end, lane = "ends", "control lane"
    endings = (
        ("Finish", lambda trial: trial.request("Finish")),
        ("a Failure", lambda trial: trial.send(trial.case.step_request(0))),
        ("an Abort", lambda trial: trial.abort(70)),
        ("the loss of the coupler", lambda trial: trial.vanish()),
    )
    return [
        Check(lane, "a Pong has the state of a component that waits", _ALIVE, _pong_at_rest, steps=2),
        Check(lane, "a Pong comes within 1 s from a component that works", _ALIVE, _pong_at_work, steps=0),
        Check(lane, "a Ping of another session is ignored", _FOREIGN, _foreign_ping, steps=0),
        Check(end, "Finish: exit code 0", _END, Trial.finish, steps=1),
        *(
            Check(end, f"Abort (code {code}) when {state}: exit code {code}", _ABORT, _aborted, (state, code))
            for state, code in (("greeted", 70), ("configured", 69), ("ready", 74), ("stepping", 70))
        ),
        Check(end, "Abort with code 0: an exit code that is not 0", _ABORT, _aborted, ("ready", 0, range(1, 256))),
        *(
            Check(end, f"coupler gone when {state}: exit code 69", _ORPHAN, _orphaned, (state,))
            for state in ("greeted", "ready", "stepping")
        ),
        Check(end, "coupler silent: exit code 69", _ORPHAN, _left_without_pings, options=("--orphan-after", "1")),
        Check(end, "coupler only pings: the component waits", _ORPHAN, _kept_by_pings, options=("--orphan-after", "2")),
        Check(end, "suspended for 3.5 s: continues", _SUSPENDED, _suspended, steps=1, options=("--orphan-after", "2")),
        *(
            Check("processes", f"nothing is left after {text}", _NOTHING_LEFT, _nothing_left_after, (ending,), steps=1)
            for text, ending in endings
        ),
        Check("processes", "waiting costs no time", _IDLE, _idle, steps=1),
    ]
