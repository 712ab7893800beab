"""A step is done once, whatever happens to the messages about it."""

from functools import partial

from copepod_conformance.protocol import SETUP, STEP, describe
from copepod_conformance.subject import STEPS, Trial
from copepod_conformance.verdicts import Check, Rule, Violation

_REPEAT = Rule(
    "Exactly once",
    "a request with the number of the last one is answered with the same bytes as before, without computing anything",
)
_IGNORE = Rule("Exactly once", "older numbers and messages of another session or epoch are ignored")
_SKIP = Rule(
    "Exactly once",
    "a number that skips ahead, the number 0, and a step that is not the next one are refused with code 65",
)
_DAMAGED = Rule("Lanes", "a frame that does not end with its checksum was damaged on its way and counts as lost")
_FINISH = Rule("Exactly once", "a component stays for 0.5 s after its Finished, should the coupler have to ask again")
_QUEUE = Rule("A run", "a request that comes during the bulk update waits in the queue")
_SAME = Rule("Same bits", "the same case gives the same replies and the same digest")


def _repeated(trial, name, times=1, is_early=False):
    """`is_early`: the second copy is in the queue while the first is worked on."""
    if name == "Save":
        trial.subject.require("checkpoint")
    if name == SETUP[trial.role]:
        trial.reach("greeted")
    else:
        trial.configure(steps=2)
    request = trial.make(name)
    trial.send(request)
    answers = [] if is_early else [trial.expect_reply(name, request)]
    for attempt in range(1, times + 1):
        trial.send(request, " again", sequence=trial.sequence, attempt=attempt)
        answers.append(trial.expect_reply(name, request))
    if is_early:
        answers.append(trial.expect_reply(name, request))
    if len({answer.data for answer in answers}) > 1:
        raise Violation(f"another {answers[0].name} than the first time")
    if name == "Finish":
        trial.expect_exit(0)
    else:
        trial.expect_undisturbed_end()


def _old_number(trial):
    trial.send(trial.case.step_request(1), sequence=trial.sequence - 1)
    trial.expect_undisturbed_end()


def _foreign(trial, field):
    """A request of a foreign session must not count, whatever its number."""
    foreign = {field: getattr(trial, field) + 1}
    trial.send(trial.make("Finish"), f" with another {field}", sequence=trial.sequence + 1, **foreign)
    trial.expect_undisturbed_end()


def _no_number(trial):
    """There is no reply yet that could be repeated."""
    trial.reach("greeted")
    trial.send(trial.make(SETUP[trial.role]), sequence=0)
    trial.expect_failure(65)


def _out_of_turn(trial, step, number):
    """Where step 2 and the next number are due."""
    remark = "" if step == 2 else " where step 2 is due"
    trial.send(trial.case.step_request(step), remark, sequence=trial.sequence + number)
    trial.expect_failure(65)


def _damaged(trial):
    """Lost like any other: the coupler sends it again."""
    trial.sequence += 1
    request = trial.with_header(trial.make(trial.step_name))
    trial.send_damaged(request, f"{describe(request)} with one bit changed")
    trial.send(request, sequence=trial.sequence, attempt=1)
    trial.next_step += 1
    trial.expect_reply(trial.step_name, request)
    trial.expect_undisturbed_end()


def _early(trial):
    """All steps at once: replies in order, none lost."""
    for _ in range(STEPS):
        trial.send(trial.make(trial.step_name))
    trial.expect_undisturbed([trial.receive("a reply").content for _ in range(STEPS)])
    trial.expect_undisturbed_end()


def checks(subject):
    step, check = STEP[subject.role], partial(Check, "exactly once")
    repeated = [SETUP[subject.role], *(["KinematicsRequest"] if subject.role == "body" else []), "Save", "Summarise"]
    left_out = [] if subject.role == "controller" else [(3, 1)]
    return [
        check("two runs are the same", _SAME, Trial.expect_undisturbed_end, steps=0),
        check("a step requested twice is done once", _REPEAT, _repeated, (step,)),
        check("a step requested four times is done once", _REPEAT, _repeated, (step, 3)),
        check("a step requested again while it is done is done once", _REPEAT, _repeated, (step, 1, True)),
        *(check(f"a repeated {name} is answered as before", _REPEAT, _repeated, (name,)) for name in repeated),
        check("an older number is ignored", _IGNORE, _old_number, steps=3),
        check("another session is ignored", _IGNORE, _foreign, ("session_id",), steps=1),
        check("another epoch is ignored", _IGNORE, _foreign, ("epoch",), steps=1),
        check("a number that skips ahead is refused", _SKIP, _out_of_turn, (2, 2), steps=2),
        check("a request without a number is refused", _SKIP, _no_number),
        *(check("a step left out is refused", _SKIP, _out_of_turn, how, steps=2) for how in left_out),
        check("a step done before is refused", _SKIP, _out_of_turn, (1, 1), steps=2),
        check("a damaged request counts as lost", _DAMAGED, _damaged, steps=1),
        check("a repeated Finish is answered", _FINISH, _repeated, ("Finish",)),
        check("requests that come early are answered in order", _QUEUE, _early, steps=0),
    ]
