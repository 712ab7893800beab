#!/usr/bin/python3
"""Hurts runs at random, resumes them with other ranks, and compares the end with an undisturbed run.

    python3 tests/faults/random_faults.py [--faults N] [--seed N] [--jobs N] [--only KIND…] [--bodies own|bullet|mujoco]
                                          [--record FILE.jsonl] [--report FILE.jsonl…]

Faults, victims, moments and ranks follow from the seed; how far a run is at that moment does not.
"""

import argparse
import dataclasses
import hashlib
import json
import os
import random
import re
import resource
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from pathlib import Path

from hurt_run import (
    LONGEST_S,
    VICTIMS,
    digest,
    go_on,
    has_checkpoint,
    start_again,
    wait_for,
)

AT_START = 0.25  # of the signals hit a rank that has just started, when MPI is easily hurt
JUST_STARTED_S = 0.02
MOST_FAULTS_PER_RUN = 3
LOST, STORAGE = 69, 73
DISK = "500m"
SERVICES = tuple(victim for victim in VICTIMS if victim not in ("command", "coupler"))
STOPS = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)


@dataclasses.dataclass
class Hurt:
    """What a fault did to a run; `codes` with which the command may then end."""

    codes: tuple
    words: str = ""  # regular expression that the last line must match unless the code is 0


class Chance:
    """One run, and the random numbers that decide what happens to it."""

    def __init__(self, run, folder, choose, latest_s):
        self.run, self.folder, self.choose, self.latest_s = run, folder, choose, latest_s

    def victim(self, among):
        """One of them that lives, after a random wait; None if none does any more."""
        victims = list(among)
        self.choose.shuffle(victims)
        if self.choose.random() < AT_START:
            victims.sort(key=lambda victim: not victim.startswith("fluid"))
            wait_for(lambda: self.run.has(victims[0]) or self.has_ended(), self.latest_s)
            time.sleep(self.choose.uniform(0.0, JUST_STARTED_S))
        else:
            time.sleep(self.choose.uniform(0.0, self.latest_s))
        return next((victim for victim in victims if not self.has_ended() and self.run.has(victim)), None)

    def has_ended(self):
        return self.run.process.poll() is not None

    def send(self, number, victim):
        os.kill(self.run.pid(victim), number)


def kill(chance, victim):
    chance.send(signal.SIGKILL, victim)
    return Hurt((-9,) if victim == "command" else (LOST,), "killed by signal 9")


def crash(chance, victim):
    number = chance.choose.choice((signal.SIGSEGV, signal.SIGABRT, signal.SIGBUS))
    chance.send(number, victim)
    return Hurt((LOST,), f"killed by signal {int(number)}|did not connect")


def freeze(chance, victim):
    chance.send(signal.SIGSTOP, victim)
    return Hurt((LOST,), "frozen|did not connect")


def pause(chance, victim):
    """For a moment that is forgiven: the command for any time, others for less than the time that a freeze takes."""
    pid = chance.run.pid(victim)
    os.kill(pid, signal.SIGSTOP)
    time.sleep(chance.choose.uniform(0.0, 3.0 if victim == "command" else 0.7))
    with suppress(ProcessLookupError):
        os.kill(pid, signal.SIGCONT)
    return Hurt((0,))


def stop(chance, victim):
    """Asked to end, the run may save a checkpoint first."""
    number = chance.choose.choice(STOPS)
    chance.send(number, victim)
    return Hurt((128 + number, -number), "stopped by")  # the latter before the command's first line is read


def end_a_service(chance, victim):
    chance.send(chance.choose.choice(STOPS), victim)
    return Hurt((LOST,))


def ask_for_a_checkpoint(chance, victim):
    chance.send(signal.SIGUSR1, victim)
    return Hurt((0,))


def quota(chance, victim):
    """No file may grow any more, the shared memory of the ranks included."""
    size = chance.choose.choice((0, 1 << 12, 1 << 20))
    resource.prlimit(chance.run.pid(victim), resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))
    return Hurt((0, STORAGE), "written|File too large|cannot be made")


def obstacle(chance, victim):
    """A file in the place of a checkpoint."""
    folder = chance.folder / "out/checkpoints"
    with suppress(OSError):
        (folder / f"step_{chance.choose.randrange(100, 1001, 100):09}").write_text("notes")
    return Hurt((0,))


def damage(chance, victim):
    """The coupler is killed, and a bit of what it had saved last is flipped."""
    chance.send(signal.SIGKILL, "coupler")
    chance.run.end(LONGEST_S)
    files = sorted(path for path in (chance.folder / "out/checkpoints").glob("step_*/*") if path.stat().st_size)
    newest = [path for path in files if path.parent == files[-1].parent]
    if newest:
        with open(chance.choose.choice(newest), "r+b") as file:
            place = chance.choose.randrange(os.fstat(file.fileno()).st_size)
            file.seek(place)
            byte = file.read(1)[0]
            file.seek(place)
            file.write(bytes([byte ^ 1 << chance.choose.randrange(8)]))
    return Hurt((LOST,), "killed by signal 9")


def full_disk(chance, victim):
    """The disk of the run directory has almost no room left, for a moment or until the run ends."""
    disk = os.statvfs(chance.folder)
    used = (disk.f_blocks - disk.f_bfree) * disk.f_frsize + chance.choose.choice((1 << 14, 1 << 17))
    if _mount("-o", f"remount,size={used}", chance.folder):  # the run may have written more meanwhile
        wait_for(chance.has_ended, chance.choose.choice((chance.choose.uniform(0.05, 1.0), LONGEST_S)))
        _mount("-o", f"remount,size={DISK}", chance.folder)
    return Hurt((0, STORAGE), "No space left|free")


def strangers(chance, victim):
    """Idle connections, and some that send what is not of the protocol."""
    address = chance.run.address
    crowd = []
    with suppress(OSError):
        for number in range(chance.choose.randrange(1, 300)):
            crowd.append(socket.create_connection(address, timeout=5))
            if number % 3 == 0:
                crowd[-1].sendall(chance.choose.randbytes(chance.choose.randrange(1, 2000)))
    wait_for(chance.has_ended, LONGEST_S)
    for stranger in crowd:
        stranger.close()
    return Hurt((0,))


def reset(chance, victim):
    """Every connection of the run is broken at once; ss asks the kernel."""
    port = chance.run.address[1]
    subprocess.run(["ss", "--kill", "state", "connected", "sport", "=", f":{port}"], capture_output=True, check=False)
    return Hurt((0,))


KINDS = {  # what is done, to whom, how often it is drawn
    "kill": (kill, VICTIMS, 6),
    "crash": (crash, ("body", "fluid 0", "fluid 1"), 2),
    "freeze": (freeze, ("coupler", *SERVICES), 2),
    "pause": (pause, VICTIMS, 2),
    "stop": (stop, ("command", "coupler"), 4),
    "end of a service": (end_a_service, ("body",), 1),
    "wish for a checkpoint": (ask_for_a_checkpoint, ("command", "coupler"), 1),
    "quota": (quota, ("coupler", "body", "fluid 0"), 2),
    "obstacle": (obstacle, ("command",), 1),
    "damage": (damage, ("coupler",), 2),
    "full disk": (full_disk, ("command",), 2),
    "strangers": (strangers, ("coupler",), 1),
    "reset": (reset, ("coupler",), 1),
}
NETWORK = ("strangers", "reset")
AS_ROOT = ("full disk", "reset")


def run_under_fire(seed, latest_s, bodies="own", kinds=None):
    """One run that is hurt up to three times before it may end; one dictionary per fault.

    `latest_s`: about as long as an undisturbed run takes.
    """
    choose = random.Random(seed)
    kinds = kinds or [kind for kind in KINDS if kind not in AS_ROOT or can_mount()]
    with _private_disk() as folder:
        faults, ending = [], "by itself"
        for _ in range(choose.randint(1, MOST_FAULTS_PER_RUN)):
            fault, finished = _hurt_once(folder, choose, latest_s, bodies, kinds)
            faults += fault
            if finished:
                break
        else:
            ending = go_on(folder, *_arguments(choose, bodies))
        return [{**fault, "seed": seed, "ending": ending, "result": result(folder)} for fault in faults]


def _hurt_once(folder, choose, latest_s, bodies, kinds):
    """([what was done and how the command took it], empty if it was too late; whether the run finished)."""
    name = choose.choices(kinds, [KINDS[kind][2] for kind in kinds])[0]
    act, among, _ = KINDS[name]
    arguments = _arguments(choose, bodies)
    if name in NETWORK:
        address = ("127.0.0.1", _free_port())
        arguments += ["--set", f"services.transport=tcp://127.0.0.1:{address[1]}"]
    run, _ = start_again(folder, *arguments)
    if name in NETWORK:
        run.address = address
    chance = Chance(run, folder, choose, latest_s)
    victim = chance.victim(among)
    start = time.monotonic()
    try:
        hurt = None if victim is None else act(chance, victim)
    except (AssertionError, ProcessLookupError):  # it ended in this very moment
        hurt = None
    if not wait_for(chance.has_ended, LONGEST_S):
        run.process.terminate()
    code = run.end(LONGEST_S)
    if hurt is None:
        return [], code == 0
    seconds = time.monotonic() - start
    if victim == "command" and code < 0 and has_checkpoint(folder):
        leftovers = []  # a resume waits by itself until the guard has cleaned up
    else:
        leftovers = run.final_leftovers() if code < 0 else run.leftovers()
    message = run.stderr[-1].strip() if run.stderr else ""
    problem = _problem(hurt, code, message) or (f"left behind: {leftovers}" if leftovers else "")
    fault = {"kind": name, "victim": victim, "seconds": seconds, "code": code, "message": message, "problem": problem}
    return [fault], code == 0


def _problem(hurt, code, message):
    """What is wrong with the end of a command; a fault may come too late to matter."""
    if code not in (0, *hurt.codes):
        return f"code {code} instead of {hurt.codes}"
    if code > 0 and not re.search(hurt.words, message):
        return f"the last line lacks «{hurt.words}»"
    if code in (LOST, STORAGE) and not re.search(r"(at|after) step \d+|before the first step|did not connect", message):
        return "the last line names no step"
    return ""


def _arguments(choose, bodies):
    return ["--ranks", str(choose.randint(1, 3)), "--set", f"body.solver={bodies}"]


def _free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


_mounting = threading.Lock()


@contextmanager
def _private_disk():
    """A folder, with root's rights a disk of its own."""
    with tempfile.TemporaryDirectory(prefix="copepod_faults_") as name:
        folder = Path(name).resolve()
        if not can_mount():
            yield folder
            return
        with _mounting:
            _mount("-t", "tmpfs", "-o", f"size={DISK}", "none", folder)
        try:
            yield folder
        finally:
            wait_for(lambda: subprocess.run(["umount", folder], stderr=subprocess.DEVNULL).returncode == 0, 20, 0.2)


def _mount(*arguments):
    """Whether it succeeded."""
    return subprocess.run(["mount", *arguments], capture_output=True, check=False).returncode == 0


def can_mount():
    if os.geteuid() != 0:
        return False
    probe = ["unshare", "--mount", "mount", "-t", "tmpfs", "none", "/mnt"]
    return subprocess.run(probe, capture_output=True, check=False).returncode == 0


def result(folder):
    """Digest and trajectory of the finished run."""
    path = folder / "out/trajectory.csv"
    return digest(folder), hashlib.sha256(path.read_bytes()).hexdigest()[:16] if path.exists() else ""


def undisturbed(bodies="own"):
    """(result of a run that nothing happens to, seconds that it takes)."""
    start = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="copepod_faults_") as folder:
        go_on(Path(folder).resolve(), "--set", f"body.solver={bodies}")
        return result(Path(folder)), time.monotonic() - start


def report(faults, expected):
    """Prints what came of all faults; the number of problems."""
    print("| fault | times | too late or without effect | median | worst |\n|---|---|---|---|---|")
    for kind in KINDS:
        own = [fault for fault in faults if fault["kind"] == kind]
        if own:
            seconds = [fault["seconds"] for fault in own]
            finished = sum(fault["code"] == 0 for fault in own)
            print(f"| {kind} | {len(own)} | {finished} | {statistics.median(seconds):.1f} | {max(seconds):.1f} |")
    wrong = [fault for fault in faults if tuple(fault["result"]) != expected or fault["problem"]]
    runs = {fault["seed"]: fault["ending"] for fault in faults}
    endings = ", ".join(f"{list(runs.values()).count(ending)} {ending}" for ending in sorted(set(runs.values())))
    print(f"\n{len(faults)} faults in {len(runs)} runs ({endings}); {len(wrong)} with a problem")
    for fault in wrong:
        print(f"problem: {fault}")
    return len(wrong)


def draw(number, seed, jobs, latest_s, bodies="own", kinds=None, record=None):
    """At least so many faults, of runs with this and the next seeds."""
    faults = []
    with ThreadPoolExecutor(jobs) as pool:
        while len(faults) < number:
            runs = pool.map(lambda seed: run_under_fire(seed, latest_s, bodies, kinds), range(seed, seed + jobs))
            seed += jobs
            fresh = [fault for run in runs for fault in run]
            faults += fresh
            if record:
                with record.open("a") as file:
                    file.writelines(json.dumps(fault) + "\n" for fault in fresh)
    return faults


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--faults", type=int, default=200, metavar="N", help="at least so many (200)")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the first run (1)")
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="runs at a time")
    parser.add_argument("--only", nargs="+", choices=KINDS, metavar="KIND", help="only faults of these kinds")
    parser.add_argument("--bodies", default="own", choices=("own", "bullet", "mujoco"), help="body.solver (own)")
    parser.add_argument("--record", type=Path, metavar="FILE", help="add what happened to this file")
    parser.add_argument("--report", type=Path, nargs="+", metavar="FILE", help="only print what was recorded")
    options = parser.parse_args()
    expected, latest_s = undisturbed(options.bodies)
    faults = [json.loads(line) for file in options.report or [] for line in file.read_text().splitlines()]
    if not options.report:
        faults = draw(
            options.faults, options.seed, options.jobs, latest_s, options.bodies, options.only, options.record
        )
    return 1 if report(faults, expected) else 0


if __name__ == "__main__":
    sys.exit(main())
