"""On another host of a run: owns what runs there, reports what is wrong, and ends it with the run or its connection.

    python3 -m copepod_run.host_guard     stdin: the order, one line of JSON; then questions, until it is closed

There are two on every host: one that watches, and one that has started the ranks. Each notices when the other is gone.
"""

import fcntl
import hashlib
import json
import os
import select
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

from copepod_run import cleanup
from copepod_run.processes import ENDED, Attention, Looker, adopt_orphans, reap_orphans, start_child, state_of

GUARD = "COPEPOD_GUARD"  # in the environment of the guard that watches, with the mark of the run
STARTER = "COPEPOD_STARTER"  # the same of the one that starts
_LOOK_EVERY_S = 0.5
_SILENT_S = 1.5  # without a question; the shared disk may then show that the run is over
_GRACE_S = 2.0  # the command decides first that a connection is lost
_OTHER_STOPPED_FOR_S = 2.0
_FILE_APPEARS_WITHIN_S = 5.0  # network file systems show new files late
_IN_READING = 1 << 16


def main() -> int:
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    lines = _Lines()
    if (order := next(lines.wait(None), None)) is None:
        return 1
    adopt_orphans()
    return _start(order, lines) if "command" in order else _watch(order, lines)


class _Lines:
    """JSON objects on stdin, one per line."""

    def __init__(self) -> None:
        self._rest = b""
        self.is_open = True

    def wait(self, timeout_s: float | None, *others: int) -> Iterator[dict[str, Any]]:
        """What arrives within that time, at least one complete line if there is no limit; ends at once when one of
        the `others` becomes readable."""
        while self.is_open:
            ready, _, _ = select.select([0, *others], [], [], timeout_s)
            if 0 not in ready:
                return
            received = os.read(0, _IN_READING)
            self.is_open = bool(received)
            *complete, self._rest = (self._rest + received).split(b"\n")
            yield from map(json.loads, complete)
            if complete or timeout_s is not None:
                return


def _look_at_sign(sign: Path, sign_is_gone: threading.Event) -> None:
    """A file on the shared disk that exists as long as the run does. In a thread: the disk may not answer."""
    try:
        sign.open().close()  # network file systems ask their server then
    except FileNotFoundError:
        sign_is_gone.set()
    except OSError:  # of the disk
        pass


def _watch(order: dict[str, Any], lines: _Lines) -> int:
    """Answers questions until asked to end, or until nothing arrives in either direction and the run is over, or long
    enough for it to have given up this host."""
    problem = _problem(order) or _make_folders(order)
    os.environ.pop(GUARD, None)
    cleaner = cleanup.Guard(f"{cleanup.MARK}={order['mark']}", order["folders"])  # if this process is killed
    address = os.environ.get("SSH_CONNECTION", "").partition(" ")[0]
    _answer("ready", problem=problem, address=address, build="" if problem else digest(order["program"]))
    looker = Looker(order["host"])
    confirmed = asked = time.monotonic()  # confirmed: when the last answer was sent that has arrived
    sent: dict[int, float] = {}
    attention = Attention()
    look, sign_is_gone = threading.Thread(), threading.Event()
    starters: set[int] = set()
    is_over = False
    limit_s = order["silence_s"] + _GRACE_S
    while lines.is_open and not is_over and not sign_is_gone.is_set() and time.monotonic() - confirmed < limit_s:
        for question in lines.wait(_LOOK_EVERY_S):
            asked = time.monotonic()
            if "end" in question:
                is_over = True
            else:
                confirmed = max(confirmed, sent.get(question["received"], 0.0))
                sent = {number: then for number, then in sent.items() if number > question["received"]}
                sent[question["ping"]] = asked
                marks = [f"{name}={order['mark']}" for name in (cleanup.MARK, STARTER)]
                pids = [pid for mark in marks for pid in cleanup.marked_processes(mark)]
                wrong = looker.wrong(pids, fluid_lives=True)  # unless mpirun has ended, too
                _answer("pong", ping=question["ping"], wrong=[asdict(each) for each in wrong])
        if attention.was_away():  # and so was the command
            confirmed = time.monotonic()
        if time.monotonic() - asked > _SILENT_S and not look.is_alive():
            look = threading.Thread(target=_look_at_sign, args=(Path(order["sign"]), sign_is_gone), daemon=True)
            look.start()
        present = set(cleanup.marked_processes(f"{STARTER}={order['mark']}"))
        if any(state_of(pid) in ENDED for pid in starters - present):
            # It was killed. What it had started keeps the connection open, and mpirun would notice nothing.
            _end_all(order["mark"])
        starters = present
    left = _end_all(order["mark"])
    for starter in cleanup.marked_processes(f"{STARTER}={order['mark']}"):
        cleanup.send(starter, signal.SIGKILL)
    cleanup.remove_folders(order["folders"])
    cleaner.dismiss()
    if is_over:
        _answer("ended", left=left)
    return 0


def _start(order: dict[str, Any], lines: _Lines) -> int:
    """Carries out the command as ssh would, and ends with it; also ends it, and all the rest, with the connection."""
    mark, host = order["mark"], order["host"]
    if (watcher := next(iter(cleanup.marked_processes(f"{GUARD}={mark}")), None)) is None:
        _report(host, "its guard has ended, and nothing is started without it.")
        return 1
    own = {name: value for name, value in os.environ.items() if name not in (GUARD, STARTER, "PYTHONPATH")}
    environment = {**own, **order["environment"], cleanup.MARK: mark, cleanup.COMPONENT: order["component"]}
    shell = ["/bin/sh", "-c", order["command"]]
    process = start_child(shell, signal.SIGKILL, env=environment, cwd=order["cwd"], stdin=subprocess.DEVNULL)
    ended = os.pidfd_open(process.pid)
    stopped_since: float | None = None
    attention = Attention()
    while lines.is_open and process.poll() is None:
        for _ in lines.wait(_LOOK_EVERY_S, ended):
            pass
        state = state_of(watcher)
        if attention.was_away() or state != "T":
            stopped_since = None
        if state == "T":
            stopped_since = stopped_since or time.monotonic()
        is_frozen = stopped_since is not None and time.monotonic() - stopped_since > _OTHER_STOPPED_FOR_S
        if state in ENDED or is_frozen:
            how = "is stopped (SIGSTOP)" if is_frozen else "was killed"
            _report(host, f"its guard, process {watcher}, {how}.")
            break
    code = process.poll()
    if code != 0:  # what it had started goes with it
        _end_all(mark)
    if code is None:
        cleanup.send(watcher, signal.SIGCONT)  # it sees by itself that the connection is gone
        return 1
    if code < 0 or code > 128:
        number = -code if code < 0 else code - 128
        if number != signal.SIGTERM:  # which the other guard sends when the run has ended
            words = (word for word in order["command"].split() if "=" not in word)
            program = next((word for word in words if not word.startswith(("export", ";"))), order["command"])
            _report(host, f"{Path(program).name} was killed by signal {number}.")
        return 128 + number
    return code


def _problem(order: dict[str, Any]) -> str:
    """Why the run cannot use this host; empty if it can. Grammar: «problem (why). What to do.»"""
    sign = Path(order["sign"])
    folder = sign.parent.parent
    deadline = time.monotonic() + _FILE_APPEARS_WITHIN_S
    while not os.path.exists(sign) and time.monotonic() < deadline:
        with suppress(OSError):
            os.listdir(folder)  # makes some network file systems look again
        if select.select([0], [], [], 0.05)[0]:  # asked to end already, or the connection is gone
            break
    if not os.path.exists(sign):
        return f"{folder} is not there (no shared file system). Choose an --out that every host sees."
    if not os.access(folder, os.W_OK):
        return f"{folder} cannot be written to. Choose another --out, or change its permissions there."
    if not os.access(order["program"], os.R_OK | os.X_OK):
        return f"{order['program']} is not there. Copepod must be at the same path on every host."
    return ""


def _make_folders(order: dict[str, Any]) -> str:
    """Private folders of the same names as on the first host, locked as long as this process lives, and the files in
    them; a problem if that fails."""
    try:
        for name in order["folders"]:
            folder = Path(name)
            with suppress(FileExistsError):  # /tmp is shared
                folder.mkdir(mode=0o700)
                cleanup.claim(folder, order["mark"])
            if not cleanup.is_claimed(folder, order["mark"]):
                return f"{folder} is in the way (not made by this run). Run again."
            lock = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
            with suppress(OSError):
                fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
        for name, content in order["files"].items():
            with suppress(FileExistsError):  # likewise
                cleanup.write_private(name, content)
    except OSError as problem:
        return f"{problem.filename} cannot be made ({problem.strerror}). Free space there, or ask its owner."
    return ""


def digest(program: str) -> str:
    return hashlib.sha256(Path(program).read_bytes()).hexdigest()[:16]


def _end_all(mark: str) -> int:
    left = cleanup.end_marked(f"{cleanup.MARK}={mark}")
    reap_orphans()
    return left


def _answer(event: str, **words: Any) -> None:
    with suppress(OSError):  # the connection is gone, which stdin shows too
        os.write(1, json.dumps({"event": event, **words}).encode() + b"\n")


def _report(host: str, reason: str) -> None:
    with suppress(OSError):
        os.write(2, f"copepod: host {host}: {reason}\n".encode())


if __name__ == "__main__":
    sys.exit(main())
