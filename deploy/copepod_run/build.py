"""Configures and builds the checkout; ninja decides what there is to do."""

import os
import re
import select
import shlex
import shutil
import subprocess
import sys
import time
from argparse import Namespace
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from copepod_run import packages
from copepod_run.checkout import BUILD, PROGRAMS, ROOT, chosen_programs, program
from copepod_run.errors import BadCase, ExitCode, Stop
from copepod_run.messages import Stage, elapsed_text, say
from copepod_run.run_directory import Lock, take_lock

_BYTES_PER_COMPILER = 1.5e9  # memory set aside for each g++ process
_SHOWN_LINES = 40
_MOMENT_S = 1.0  # a build that takes longer is announced
_LOOK_EVERY_S = 0.2  # at a build that is under way
_LOG = BUILD / "build.log"
_OF_SOME_CASES = re.compile(rb"bullet|mujoco|in_process|campaign|\\\\")  # \\: a word may be spelled by codes
_COUNTER = re.compile(rb"^\[(\d+)/(\d+)\]", re.MULTILINE)  # ninja's


def ensure_programs(options: Namespace | None = None) -> None:
    """Packages, the programs of a run, and what components in Python need; all up to date.

    @param options  of a command about one case: programs that it does not need are then left for later
    """
    programs = "copepod_programs"
    if options is not None and (Path(options.case).is_file() or not Path(options.case).exists()):  # not a pipe
        # Nothing has read the case yet: may it name an engine or run in one process?
        text = Path(options.case).read_bytes() if Path(options.case).exists() else b""
        words = [*options.set, options.fluid or "", options.body or ""]
        if not _OF_SOME_CASES.search(text + " ".join(words).encode()):
            programs = "copepod_services"
    ensure_targets((programs, "copepod_python"))


def ensure_targets(targets: Sequence[str] = ()) -> None:
    """Packages and `targets` (none: all, tests included), unless they are up to date. Raises Stop(1) with the
    compiler's errors."""
    if chosen_programs() or _only_its_owner_builds():
        return
    packages.ensure()
    if not shutil.which("ninja") or not shutil.which("cmake"):
        raise BadCase(
            "cmake and ninja are not in PATH (not a Debian machine?). Install them, g++ 12 "
            "and these libraries' equivalents: " + " ".join(packages.BUILD_AND_RUN)
        )
    ask = ["ninja", "-n", "-C", str(BUILD), *targets]  # takes no lock: another build is not waited for
    if _is_configured() and b"no work to do" in subprocess.run(ask, capture_output=True).stdout:
        return
    BUILD.mkdir(exist_ok=True)
    with _one_build_at_a_time():
        if not _is_configured():
            with Stage("configuring"), open(_LOG, "wb") as log:
                if packages.run_into(log, ["cmake", "--fresh", "--preset", "release"], cwd=ROOT) != 0:
                    raise Stop(ExitCode.FAILED, _failure("cmake could not configure the build"))
        _build(targets)


def _only_its_owner_builds() -> bool:
    """Whether the programs are there and this user may not build them, as in an installation for many users."""
    folder = BUILD if BUILD.exists() else ROOT
    if os.access(folder, os.W_OK):
        return False
    if all(program(name).exists() for name in PROGRAMS):
        return True
    raise BadCase(
        f"{folder} belongs to another user and holds no complete build (you may not write there). "
        f"Ask its owner to run: {ROOT}/deploy/copepod setup"
    )


@contextmanager
def _one_build_at_a_time() -> Iterator[None]:
    """Lock on a file that names the command that builds; while another one does, shows which, and how far it is."""
    with open(BUILD / "builder", "a+") as builder:
        found = take_lock(builder.fileno())
        while found is Lock.HELD:
            builder.seek(0)
            since = os.fstat(builder.fileno()).st_mtime
            other = f"{builder.read()}, started {elapsed_text(time.time() - since)} ago)"
            with Stage(f"waiting for the build of another command: {other}; log: {_LOG}") as stage:
                while since == os.fstat(builder.fileno()).st_mtime and found is Lock.HELD:
                    stage.count(*_progress_in_log())
                    found = take_lock(builder.fileno(), _LOOK_EVERY_S)
        if found is Lock.IMPOSSIBLE:
            say(f"{BUILD} cannot be locked (its file system has no locks). Let no other copepod build there now.")
        words = sys.orig_argv
        command = ["copepod", *words[words.index("copepod_command") + 1 :]] if "copepod_command" in words else words
        builder.truncate(0)
        builder.write(f"{shlex.join(command)} (process {os.getpid()}")
        builder.flush()
        yield


def _progress_in_log() -> tuple[int, int]:
    """(done, total) of the last counter in build.log, (0, 0) if there is none."""
    counters: list[Any] = [(0, 0)]
    with suppress(OSError), open(_LOG, "rb") as log:
        log.seek(max(0, log.seek(0, os.SEEK_END) - 65536))
        counters += _COUNTER.findall(log.read())
    done, total = map(int, counters[-1])
    return done, total


def _is_configured() -> bool:
    """Whether build.ninja exists and belongs to this checkout (a moved or copied folder must be configured anew)."""
    try:
        cache = (BUILD / "CMakeCache.txt").read_text()
    except FileNotFoundError:
        return False
    return (BUILD / "build.ninja").exists() and f"CMAKE_HOME_DIRECTORY:INTERNAL={ROOT}\n" in cache


def _build(targets: Sequence[str]) -> None:
    """Runs ninja; prints nothing if that is over in a moment."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    jobs = max(1, min(len(os.sched_getaffinity(0)), int(memory / _BYTES_PER_COMPILER)))
    command = ["ninja", "-C", str(BUILD), "-j", str(jobs), *targets]
    streams: dict[str, Any] = {"stdin": subprocess.DEVNULL, "stderr": subprocess.STDOUT}
    environment = {**os.environ, "NINJA_STATUS": "[%f/%t] "}
    with open(_LOG, "wb") as log, subprocess.Popen(command, stdout=log, env=environment, **streams) as ninja:
        try:
            if _ends_within(_MOMENT_S, ninja) and ninja.returncode == 0:
                return
            with Stage(f"building (log: {_LOG})") as stage:
                while ninja.returncode is None and not _ends_within(_LOOK_EVERY_S, ninja):
                    stage.count(*_progress_in_log())
                if ninja.returncode != 0:
                    raise Stop(ExitCode.FAILED, _failure("the build failed"))
        finally:
            ninja.terminate()


def _ends_within(seconds: float, process: subprocess.Popen[bytes]) -> bool:
    with open(os.pidfd_open(process.pid)) as end:  # wait() would look every 50 ms
        select.select([end], [], [], seconds)
    return process.poll() is not None


def _failure(what: str) -> str:
    """Message with the end of build.log, from the first failed command on if ninja names one."""
    lines = _LOG.read_text(errors="replace").splitlines()
    failed = next((number for number, line in enumerate(lines) if line.startswith("FAILED:")), len(lines))
    shown = lines[failed : failed + _SHOWN_LINES] or lines[-_SHOWN_LINES:]
    return "\n".join([f"{what}:", *shown, f"copepod: {what} (above). The full output is in {_LOG}."])
