"""Configures and builds the checkout: nothing is run while the programs are up to date, ninja decides otherwise."""

import hashlib
import json
import os
import re
import select
import shlex
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from copepod_run import packages
from copepod_run.checkout import BUILD, PROGRAMS, ROOT, chosen_programs, program
from copepod_run.errors import ExitCode, Stop
from copepod_run.messages import Stage, elapsed_text, say
from copepod_run.run_directory import Lock, take_lock

_BYTES_PER_COMPILER = 1.5e9  # memory set aside for each g++ process
_SHOWN_LINES = 40
_MOMENT_S = 1.0  # a build that takes longer is announced
_LOOK_EVERY_S = 0.2  # at a build that another process has under way
_ALL = "all"  # in the stamp, for a build of every target
_STAMP = BUILD / "up_to_date.json"  # the sources and packages of the last build, and the targets that it made
_LOG = BUILD / "build.log"
_SOURCES = "CMakeLists.txt CMakePresets.json cmake proto fluid_service body_service coupler in_process tests".split()
_COUNTER = re.compile(rb"^\[(\d+)/(\d+)\]", re.MULTILINE)  # ninja's


def ensure_programs() -> None:
    """Packages, the programs of a run, and what components in Python need; all up to date."""
    ensure_targets(("copepod_programs", "copepod_python"))


def ensure_everything() -> None:
    """Packages and all targets, tests included."""
    ensure_targets(())


def ensure_targets(targets: Sequence[str]) -> None:
    """Builds `targets` (none: all) unless they are up to date. Raises Stop(1) with the compiler's errors."""
    if chosen_programs() or _only_its_owner_builds() or _is_up_to_date(targets):
        return
    packages.ensure()
    if not shutil.which("ninja") or not shutil.which("cmake"):
        raise Stop(
            ExitCode.BAD_CASE,
            "cmake and ninja are not in PATH (not a Debian machine?). Install them, g++ 12 "
            "and these libraries' equivalents: " + " ".join(packages.BUILD_AND_RUN),
        )
    BUILD.mkdir(exist_ok=True)
    with _one_build_at_a_time():
        sources = _state_of_sources()
        if not _is_stamp_valid(_read_stamp(), sources):
            _STAMP.unlink(missing_ok=True)  # the build may be interrupted
        if not _is_configured():
            _configure()
        _build(targets)
        _write_stamp(sources, targets)


def parallel_jobs() -> int:
    """Compilers at once: one per core, fewer if the memory is small."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return max(1, min(len(os.sched_getaffinity(0)), int(memory / _BYTES_PER_COMPILER)))


def _only_its_owner_builds() -> bool:
    """Whether the programs are there and this user may not build them, as in an installation for many users."""
    folder = BUILD if BUILD.exists() else ROOT
    if os.access(folder, os.W_OK):
        return False
    if all(program(name).exists() for name in PROGRAMS):
        return True
    raise Stop(
        ExitCode.BAD_CASE,
        f"{folder} belongs to another user and holds no complete build (you may not write there). "
        f"Ask its owner to run: {ROOT}/deploy/copepod setup",
    )


def _is_up_to_date(targets: Sequence[str]) -> bool:
    """Whether `targets` were built from the present sources and packages; takes no lock and some milliseconds."""
    stamp = _read_stamp()
    made = set(stamp["targets"])
    return bool(targets) and (_ALL in made or made.issuperset(targets)) and _is_stamp_valid(stamp, _state_of_sources())


def _read_stamp() -> dict[str, Any]:
    try:
        stamp = json.loads(_STAMP.read_text())
        return {"sources": stamp["sources"], "configured": stamp["configured"], "targets": list(stamp["targets"])}
    except (OSError, ValueError, KeyError, TypeError):
        return {"sources": None, "configured": None, "targets": []}


def _is_stamp_valid(stamp: dict[str, Any], sources: str) -> bool:
    """Whether it is of the present sources and configuration, and the programs are there."""
    present = all(program(name).exists() for name in PROGRAMS)
    return present and stamp["sources"] == sources and stamp["configured"] == _time_of_configuration()


def _write_stamp(sources: str, targets: Sequence[str]) -> None:
    """`sources`: their state before the build; what has changed since is built by the next call."""
    made = sorted({*_read_stamp()["targets"], *(targets or [_ALL])})
    stamp = {"sources": sources, "configured": _time_of_configuration(), "targets": made}
    fresh = _STAMP.with_suffix(".new")
    fresh.write_text(json.dumps(stamp) + "\n")
    fresh.replace(_STAMP)


def _time_of_configuration() -> int:
    try:
        return (BUILD / "build.ninja").stat().st_mtime_ns
    except OSError:
        return 0


def _state_of_sources() -> str:
    """Digest of the names, times and sizes of all sources, and of the list of installed packages."""
    digest = hashlib.sha256(os.fsencode(ROOT))
    for path in (*(ROOT / name for name in _SOURCES), Path("/var/lib/dpkg/status")):
        _add_state(os.fsencode(path), digest.update)
    return digest.hexdigest()


def _add_state(path: bytes, add: Callable[[bytes], None]) -> None:
    try:
        if os.path.isdir(path):
            for entry in sorted(os.listdir(path)):
                if not entry.startswith(b".") and entry != b"__pycache__":
                    _add_state(path + b"/" + entry, add)
        else:
            state = os.stat(path)
            add(b"%b %d %d\n" % (path, state.st_mtime_ns, state.st_size))
    except OSError:  # removed meanwhile, or no such file on this machine
        add(path + b" is missing\n")


@contextmanager
def _one_build_at_a_time() -> Iterator[None]:
    """Lock on the build folder itself, so that no lock file can be left behind."""
    folder = os.open(BUILD, os.O_RDONLY | os.O_DIRECTORY)
    try:
        while (found := take_lock(folder)) is Lock.HELD:
            _wait_for_other_build(folder)
        if found is Lock.IMPOSSIBLE:
            say(f"{BUILD} cannot be locked (its file system has no locks). Let no other copepod build there now.")
        yield
    finally:
        os.close(folder)


def _wait_for_other_build(folder: int) -> None:
    """Until the process that builds now has ended its build; shows which one that is, and how far."""
    builder = _process_that_locks(folder)
    if builder is None:  # it has just ended
        time.sleep(_LOOK_EVERY_S)
        return
    what = f"waiting for the build of another command: {_description(builder)}; log: {_LOG}"
    with Stage(what) as stage:
        while _process_that_locks(folder) == builder:
            stage.count(*_progress_in_log())
            time.sleep(_LOOK_EVERY_S)


def _process_that_locks(folder: int) -> int | None:
    """Process id of the lock's holder, 0 if it is invisible here (another container), None if there is none."""
    inode = str(os.fstat(folder).st_ino)
    for line in Path("/proc/locks").read_text().splitlines():
        words = line.split()  # number: FLOCK ADVISORY WRITE pid device:inode start end
        if words[1] == "FLOCK" and words[5].rpartition(":")[2] == inode:
            return max(int(words[4]), 0)
    return None


def _description(pid: int) -> str:
    """«copepod test (process 4711, started 2 min 05 s ago)»"""
    try:
        words = Path(f"/proc/{pid}/cmdline").read_bytes().decode(errors="replace").split("\0")[:-1]
        ticks = int(Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[19])
    except (OSError, IndexError, ValueError):
        return f"process {pid}" if pid else "in another container"
    age_s = time.clock_gettime(time.CLOCK_BOOTTIME) - ticks / os.sysconf("SC_CLK_TCK")
    command = ["copepod", *words[words.index("copepod_command") + 1 :]] if "copepod_command" in words else words
    return f"{shlex.join(command)} (process {pid}, started {elapsed_text(age_s)} ago)"


def _progress_in_log() -> tuple[int, int]:
    """(done, total) of the last counter in build.log, (0, 0) if there is none."""
    try:
        with open(_LOG, "rb") as log:
            log.seek(max(0, log.seek(0, os.SEEK_END) - 65536))
            counters = _COUNTER.findall(log.read())
    except OSError:
        return 0, 0
    return (int(counters[-1][0]), int(counters[-1][1])) if counters else (0, 0)


def _is_configured() -> bool:
    """Whether build.ninja exists and belongs to this checkout (a moved or copied folder must be configured anew)."""
    try:
        cache = (BUILD / "CMakeCache.txt").read_text()
    except FileNotFoundError:
        return False
    return (BUILD / "build.ninja").exists() and f"CMAKE_HOME_DIRECTORY:INTERNAL={ROOT}\n" in cache


def _configure() -> None:
    with Stage("configuring"), open(_LOG, "wb") as log:
        code = subprocess.run(
            ["cmake", "--fresh", "--preset", "release"],
            cwd=ROOT,
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=subprocess.STDOUT,
        ).returncode
        if code:
            raise Stop(ExitCode.FAILED, _failure("cmake could not configure the build"))


def _build(targets: Sequence[str]) -> None:
    """Runs ninja; prints nothing if that is over in a moment."""
    environment = dict(os.environ, NINJA_STATUS="[%f/%t] ")
    ninja = subprocess.Popen(
        ["ninja", "-C", str(BUILD), "-j", str(parallel_jobs()), *targets],
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    assert ninja.stdout is not None
    try:
        beginning = _output_of_first_moment(ninja, ninja.stdout)
        if ninja.poll() == 0:
            return
        with Stage(f"building (log: {_LOG})") as stage:
            _follow(beginning, ninja.stdout, stage)
            if ninja.wait() != 0:
                raise Stop(ExitCode.FAILED, _failure("the build failed"))
    finally:
        if ninja.poll() is None:
            ninja.terminate()
        ninja.wait()
        ninja.stdout.close()


def _output_of_first_moment(process: subprocess.Popen[bytes], stdout: IO[bytes]) -> bytes:
    """What the process writes before it ends, or until it is clear that it has real work to do."""
    output = b""
    deadline = time.monotonic() + _MOMENT_S
    while (left := deadline - time.monotonic()) > 0 and select.select([stdout], [], [], left)[0]:
        received = os.read(stdout.fileno(), 65536)
        if not received:
            process.wait()
            break
        output += received
    return output


def _follow(beginning: bytes, stream: IO[bytes], stage: Stage) -> None:
    """Copies ninja's output to build.log and its counter to the stage's line."""
    with open(_LOG, "wb") as log:
        log.write(beginning)
        for line in iter(stream.readline, b""):
            log.write(line)
            log.flush()
            if counter := _COUNTER.match(line):
                stage.count(int(counter[1]), int(counter[2]))


def _failure(what: str) -> str:
    """Message with the end of build.log, from the first failed command on if ninja names one."""
    lines = _LOG.read_text(errors="replace").splitlines()
    failed = next((number for number, line in enumerate(lines) if line.startswith("FAILED:")), len(lines))
    shown = lines[failed : failed + _SHOWN_LINES] or lines[-_SHOWN_LINES:]
    return "\n".join([f"{what}:", *shown, f"copepod: {what} (above). The full output is in {_LOG}."])
