"""A restored component continues with the same bits; a damaged checkpoint is rejected."""

import shutil
from functools import partial
from pathlib import Path

from copepod_conformance.subject import SAVED_STEP
from copepod_conformance.verdicts import Check, Rule, Violation

_SAVE = Rule("Checkpoints", "Save writes the complete state to a new file or folder and changes nothing")
_RESTORE = Rule("Checkpoints", "after Restore the component continues with the same bits as an undisturbed run")
_RETURN = Rule("Checkpoints", "another setup between two steps begins anew, at step 0 or before a Restore")
_UNWRITABLE = Rule(
    "Checkpoints", "a path that cannot be written: Saved with a problem, and the component remains usable"
)
_STORAGE = Rule("Checkpoints", "a state that is missing or damaged: Failure with code 73")


def _configure_for_restore(trial):
    """The setup of a resumed run names the step that it starts at."""
    trial.reach("greeted")
    _set_up(trial, SAVED_STEP)


def _set_up(trial, step):
    setup = trial.case.setup_request()
    setup.step = trial.next_step = step
    trial.request(setup)


def _save_changes_nothing(trial):
    trial.request("Save")
    if not (trial.folder / "checkpoint").exists():
        raise Violation("Saved, but there is no such file or folder")
    trial.expect_undisturbed_end()


def _saved_again(trial):
    """Two checkpoints of one run."""
    for name in ("first", "second"):
        trial.advance(1)
        trial.request(trial.make("Save", trial.folder / name))
    trial.expect_undisturbed_end()


def _restored(trial):
    _configure_for_restore(trial)
    path, digest = trial.subject.checkpoint
    trial.request(trial.make("Restore", path))
    if (found := trial.digest()) != digest:
        raise Violation(f"digest {found:016x} after Restore, but {digest:016x} when the state was saved")
    trial.expect_undisturbed_end()


def _returned(trial):
    """To a state of the middle, then to the start."""
    trial.configure(steps=SAVED_STEP + 1)
    _set_up(trial, SAVED_STEP)
    trial.request(trial.make("Restore", trial.subject.checkpoint[0]))
    trial.expect_undisturbed_end()
    _set_up(trial, 0)
    trial.expect_undisturbed_end()


def _unwritable(trial):
    if not trial.request(trial.make("Save", trial.folder / "no such folder" / "checkpoint")).envelope.saved.problem:
        raise Violation("Saved without a problem, but there is no such folder")
    trial.advance(1)
    trial.expect_undisturbed_end()


def _damaged(trial, change, text):
    """`change` makes what the largest file holds of its content; None: there is no file at all."""
    _configure_for_restore(trial)
    path, _ = trial.subject.checkpoint
    copy = trial.folder / "damaged"
    if change:
        shutil.copytree(path, copy) if Path(path).is_dir() else shutil.copyfile(path, copy)
        files = (file for file in (copy, *copy.rglob("*")) if file.is_file())
        largest = max(files, key=lambda file: file.stat().st_size)
        largest.write_bytes(change(largest.read_bytes()))
    trial.send(trial.make("Restore", copy), f" of {text}")
    trial.expect_failure(73)


def checks(subject):
    damages = (
        (None, "a file that does not exist"),
        (lambda content: b"", "an empty file"),
        (lambda content: content[: len(content) // 2], "half a file"),
        (lambda content: b"\xff" * len(content), "a file overwritten with ones"),
    )
    check = partial(Check, "checkpoints", needs=("checkpoint",))
    return [
        check("a run continues after Save as without it", _SAVE, _save_changes_nothing, steps=2),
        check("two states of one run are saved", _SAVE, _saved_again, steps=0),
        check("a restored run equals the undisturbed one", _RESTORE, _restored),
        check("a run that returns equals the undisturbed one", _RETURN, _returned, needs=("checkpoint", "snapshots")),
        check("Save to a folder that does not exist", _UNWRITABLE, _unwritable, steps=1),
        *(check(f"Restore of {text}", _STORAGE, _damaged, (change, text)) for change, text in damages),
    ]
