"""`copepod run`: plan, folder, three processes, watching, result; restarts if asked for."""

import shlex

from copepod_campaign import campaign
from copepod_run import build, components, exit_codes, run_directory, speed
from copepod_run.attempt import Attempt
from copepod_run.checkout import called_as
from copepod_run.errors import Stop
from copepod_run.plan import request_plan
from copepod_run.stages import say, speak_json
from copepod_run.table import result_table

_WORTH_A_RESTART = (exit_codes.COMPONENT_LOST, exit_codes.DEADLINE_PASSED)


def run(options):
    """Runs a case to its end. Returns 0; every other ending is a Stop."""
    if options.progress == "json":
        speak_json()
    build.ensure_programs()
    plan = request_plan(options)
    if plan.sweep:
        return campaign.run_sweep(options, plan)
    plan = components.settled(plan, options)
    for warning in plan.warnings:
        say(warning)
    if options.resume:
        directory = run_directory.reopen(plan.name, options.out)
    else:
        directory = run_directory.create(plan.name, options.out)
    try:
        return _attempts(options, plan, directory)
    finally:
        directory.close()


def _attempts(options, plan, directory):
    """One attempt, and up to --restarts more as long as a component is lost."""
    resume = options.resume
    for left in range(options.restarts, -1, -1):
        ending = Attempt(options, plan, directory, resume).run()
        if ending.summary:
            summary = directory.summary()
            if summary is None:
                raise Stop(
                    exit_codes.STORAGE_FAILED,
                    f"{ending.summary} cannot be read (the disk is full?). Make room and run again.",
                )
            speed.remember(summary)
            print(result_table(summary, directory.shown), flush=True)
            return exit_codes.FINISHED
        if ending.signal:
            raise _stopped_by(ending.signal, options, directory)
        if left == 0 or ending.failure.code not in _WORTH_A_RESTART:
            raise Stop(
                ending.failure.code,
                f"{ending.failure.sentence()} {_advice_after(ending.failure, resume, options, directory)}",
            )
        resume = directory.has_checkpoint()
        say(ending.failure.sentence())
        say(f"starting again {'from the last checkpoint' if resume else 'from the beginning'}, {left} restart(s) left")


def _stopped_by(number, options, directory):
    name = {2: "Ctrl-C", 15: "SIGTERM", 1: "SIGHUP"}[number]
    code = exit_codes.INTERRUPTED if number == 2 else exit_codes.TERMINATED
    return Stop(code, f"stopped by {name}. {_advice(code, options, directory)}")


def _advice_after(failure, resumed, options, directory):
    if (
        resumed and failure.code == exit_codes.STORAGE_FAILED and failure.step < 0
    ):  # of the checkpoint: it says what to do
        return f"Logs: {directory.shown}/logs."
    return _advice(failure.code, options, directory)


def _advice(code, options, directory):
    """How to go on after a run that did not finish."""
    logs = f"Logs: {directory.shown}/logs."
    if code in (exit_codes.BAD_CASE, exit_codes.REFUSED, exit_codes.SOLVER_FAILED):
        return logs
    if directory.has_checkpoint():
        return f"{logs} Go on from the last checkpoint: {_resume_command(options, directory)}"
    return f"{logs} There is no checkpoint: run again from the start."


def _resume_command(options, directory):
    words = [called_as(), "run", options.case, "--out", directory.shown]
    for setting in options.set:
        words += ["--set", setting]
    for name in ("ranks", "fluid", "body"):
        if getattr(options, name) is not None:
            words += [f"--{name}", str(getattr(options, name))]
    return shlex.join([*words, "--resume"])
