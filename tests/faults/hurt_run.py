"""A run of the real services under `copepod run` that is halted in a known phase, hurt, and gone on with."""

import json
import os
import re
import shlex
import signal
import sys
import tempfile
import threading
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "integration"))
from copepod_session import PROMPT_S, ROOT, Session  # noqa: E402

PROGRAMS = Path(os.environ.get("COPEPOD_BUILT_PROGRAMS", ROOT / "build/bin"))
CASE = HERE / "case.yaml"
LONGEST_S = 180  # a run of some seconds that takes longer is stuck, however busy the machine


class HurtRun(Session):
    """One `copepod run` in a folder of its own."""

    def __init__(self, folder, *arguments, case=CASE):
        super().__init__(["run", case, *arguments], folder, PROGRAMS)

    def pid(self, victim):
        """Process of a victim: command, coupler, body, mpirun, or fluid 0, fluid 1, …"""
        if victim == "command":
            return self.process.pid
        component, _, rank = victim.partition(" ")
        if component == "mpirun":
            return self.pid_of("fluid", None)
        return self.pid_of(component, rank or None)

    def has(self, victim):
        try:
            return self.pid(victim) is not None
        except AssertionError:
            return False

    def leftovers(self):
        """What would be in the way of the next run, or of the machine's owner."""
        mark = f"/copepod-{self.process.pid}-"
        left = [f"process {pid}" for pid in self.processes()]
        left += [f"guard {pid}" for pid in _processes_with_argument(mark)]
        left += map(str, self.scratch_folders())
        return left

    def final_leftovers(self):
        """What is left once the guard has had time to clean up."""
        wait_for(lambda: not self.leftovers(), PROMPT_S)
        return self.leftovers()


@dataclass
class Finding:
    """What came of one fault."""

    victim: str
    phase: str
    fault: str
    seconds: float  # from the fault to the end of the command, everything cleaned up
    code: int
    message: str
    leftovers: list
    went_on: str  # resumed, afresh, or by itself
    digest: str

    @property
    def is_named(self):
        return re.search(_expected_words(self.victim, self.fault), self.message) is not None


def _expected_words(victim, fault):
    """Required words of the last line; a killed command prints nothing, a stopped one continues later."""
    if victim == "command":
        return ""
    service = {"coupler": "coupler", "body": "body service"}.get(victim, "fluid service")
    rank = {"mpirun": r"0-\d" if fault == "kill" else "0"}.get(victim, victim.partition(" ")[2] or "0")
    words = {"kill": "killed by signal 9", "freeze": "frozen", "hang": "hangs"}[fault]
    if victim == "mpirun" and fault == "freeze":
        words = r"frozen: its process \d+ \(mpirun\)"
    missing = rf"The {service.split()[0]} component did not connect"  # it never sent its Hello
    return rf"({service} on host \S+, rank {rank}, .*{words})" + (f"|({missing})" if fault == "hang" else "")


PHASES = {  # phase of the run: where the halting component stands, and from which step on
    "starting": ("", 0),
    "handshake": ("start", 0),
    "configuring": ("construct", 0),
    "exchanging": ("exchange", 230),
    "between reply and bulk update": ("advance", 230),
    "checkpointing": ("save", 150),
    "finishing": ("summarise", 0),
}
VICTIMS = ("coupler", "body", "fluid 0", "fluid 1", "mpirun", "command")
FAULTS = ("kill", "freeze", "hang")
DEADLINE_S = 2.0  # for hangs; a default run waits longer


def makes_sense(victim, phase, fault):
    """Only solvers hang; bodies have no bulk update, and before there is a solver nothing can hang in it."""
    if fault != "hang":
        return True
    is_solver = victim == "body" or victim.startswith("fluid")
    return is_solver and phase != "starting" and not (victim == "body" and phase.startswith("between"))


def hurt(victim, phase, fault):
    """Finding of one fault in one phase."""
    with tempfile.TemporaryDirectory(prefix="copepod_faults_") as folder:
        folder = Path(folder).resolve()
        run = _start(folder, victim, phase, fault)
        try:
            seconds, code = _inject(run, victim, fault)
            leftovers = run.final_leftovers()
            message = run.stderr[-1].strip() if run.stderr else ""
            went_on = "by itself" if code == 0 else go_on(folder)
            return Finding(victim, phase, fault, seconds, code, message, leftovers, went_on, digest(folder))
        finally:
            _end_for_sure(run)


def slow_down(victim, seconds, deadline_s):
    """Digest of a run in which one step of a component takes long, but shows progress."""
    with tempfile.TemporaryDirectory(prefix="copepod_faults_") as folder:
        folder = Path(folder).resolve()
        run = _start(folder, victim, "exchanging", "slow", deadline_s)
        try:
            time.sleep(seconds)
            (folder / "halted").unlink()
            code = run.end(LONGEST_S)
            return digest(folder) if code == 0 else run.last_line
        finally:
            _end_for_sure(run)


def signals_caught(victim):
    """Numbers of the signals that a component handles itself."""
    with tempfile.TemporaryDirectory(prefix="copepod_faults_") as folder:
        run = _start(Path(folder).resolve(), victim, "exchanging", "freeze")
        try:
            status = Path(f"/proc/{run.pid(victim)}/status").read_text()
            caught = int(re.search(r"SigCgt:\s*(\w+)", status)[1], 16)
            return {number for number in range(1, 65) if caught >> (number - 1) & 1}
        finally:
            _end_for_sure(run)


def go_on(folder, *arguments):
    """Resumes the run, or starts it again where it had no checkpoint yet."""
    run, how = start_again(folder, *arguments)
    try:
        return how if run.end(LONGEST_S) == 0 else f"failed: {run.last_line}"
    finally:
        _end_for_sure(run)


def start_again(folder, *arguments):
    """A run that resumes, or begins in an empty directory where there is no checkpoint; and which of the two."""
    resumes = has_checkpoint(folder)
    if not resumes and (folder / "out").exists():
        (folder / "out").rename(folder / f"out_{time.monotonic_ns()}")
    run = HurtRun(folder, "--out", "out", *(["--resume"] if resumes else []), *arguments)
    return run, "resumed" if resumes else "afresh"


def has_checkpoint(folder):
    return any((folder / "out/checkpoints").glob("step_*/manifest.json"))


def digest(folder):
    """Digest of the finished run, empty if there is none."""
    try:
        return json.loads((folder / "out/summary.json").read_text())["digest"]
    except (OSError, ValueError):
        return ""


def undisturbed_digest(*arguments):
    """What every run with these arguments must end with."""
    with tempfile.TemporaryDirectory(prefix="copepod_faults_") as folder:
        went_on = go_on(Path(folder).resolve(), *arguments)
        if went_on != "afresh":
            raise SystemExit(f"the undisturbed run {went_on}")
        return digest(Path(folder))


def wait_for(condition, patience_s, pause_s=0.01):
    """Whether the condition holds, at the latest after `patience_s`; `pause_s` between two looks."""
    deadline = time.monotonic() + patience_s
    while not (holds := condition()) and time.monotonic() < deadline:
        time.sleep(pause_s)
    return holds


def _start(folder, victim, phase, fault, deadline_s=DEADLINE_S):
    """A run that stands in `phase`."""
    place, step = PHASES[phase]
    arguments = ["--out", "out"]
    if fault in ("hang", "slow"):
        arguments += ["--set", f"services.progress_deadline_s={deadline_s}"]
    if fault == "hang" and phase == "handshake":
        arguments += ["--set", f"services.connect_deadline_s={deadline_s}"]
    if phase == "starting":
        return _start_with_held_coupler(folder, arguments)
    halting, rank = _who_halts(victim, phase, fault)
    words = [PROGRAMS / f"halting_{halting}", "--halt-in", place, "--halt-at-step", step, "--halt-rank", rank]
    words += ["--halt-file", folder / "halted"] + (["--hang"] if fault == "hang" else [])
    command = shlex.join(map(str, words))
    run = HurtRun(folder, *arguments, f"--{halting}", command)
    if not wait_for((folder / "halted").exists, LONGEST_S) or not wait_for(lambda: run.has(victim), 5):
        raise AssertionError(f"{phase} was never reached:\n{''.join(run.stderr)}")
    return run


def _who_halts(victim, phase, fault):
    """Component and rank: the victim itself where it has work in that phase."""
    if phase == "finishing" and fault != "hang":
        return "body", 0
    if victim == "body" and not phase.startswith("between"):
        return "body", 0
    return "fluid", int(victim.partition(" ")[2] or 0) if victim.startswith("fluid") else 0


def _start_with_held_coupler(folder, arguments):
    """The coupler reads its case from a pipe, and waits there: the plan gets it, the run does not."""
    case = folder / "held.yaml"
    os.mkfifo(case)
    thread = threading.Thread(target=case.write_text, args=(CASE.read_text(),), daemon=True)
    thread.start()
    run = HurtRun(folder, *arguments, case=case)
    thread.join(20)
    run.wait_for("copepod: starting")
    if not wait_for(lambda: all(run.has(victim) for victim in VICTIMS), 10):
        raise AssertionError(f"not every process started:\n{''.join(run.stderr)}")
    return run


def _inject(run, victim, fault):
    """Seconds until the command has ended, and its exit code."""
    start = time.monotonic()
    if fault != "hang":  # a hang is there already
        os.kill(run.pid(victim), signal.SIGKILL if fault == "kill" else signal.SIGSTOP)
    if victim == "command":
        if fault == "kill":
            run.final_leftovers()
        else:
            _let_finish(run)
            start = time.monotonic()
            os.kill(run.pid(victim), signal.SIGCONT)
    code = run.end(LONGEST_S)
    return time.monotonic() - start, code


def _let_finish(run):
    """A stopped command (Ctrl-Z) must not stop the run."""
    (run.folder / "halted").unlink(missing_ok=True)
    held = run.folder / "held.yaml"
    if held.exists():
        held.write_text(CASE.read_text())
    wait_for((run.folder / "out/summary.json").exists, 30)


def _end_for_sure(run):
    for victim in VICTIMS:
        if victim != "command":
            with suppress(AssertionError, ProcessLookupError):  # it may end by itself meanwhile
                os.kill(run.pid(victim), signal.SIGKILL)
    if run.process.poll() is None:
        run.process.kill()
        run.end()


def _processes_with_argument(text):
    found = []
    for entry in Path("/proc").iterdir():
        try:
            if entry.name.isdigit() and text.encode() in (entry / "cmdline").read_bytes():
                found.append(int(entry.name))
        except OSError:
            continue
    return found
