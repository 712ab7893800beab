"""Configures and builds the checkout; ninja decides what there is to do, nothing is said when that is next to nothing."""

import fcntl
import os
import re
import select
import shutil
import subprocess
import time
from contextlib import contextmanager

from copepod_command import exit_codes, packages
from copepod_command.checkout import BUILD, PROGRAMS, ROOT, chosen_programs, program
from copepod_command.errors import Stop
from copepod_command.stages import Stage

_BYTES_PER_COMPILER = 1.5e9  # memory set aside for each g++ process
_SHOWN_LINES = 40
_MOMENT_S = 1.0  # a build that takes longer is announced


def ensure_programs():
    """Packages, the programs of a run, and what components in Python need; all up to date."""
    ensure_targets(("copepod_programs", "copepod_python"))


def ensure_everything():
    """Packages and all targets, tests included."""
    ensure_targets(())


def ensure_targets(targets):
    """Builds `targets` (none: all). Raises Stop(1) with the compiler's last words if that fails."""
    if chosen_programs() or _belongs_to_somebody_else():
        return
    packages.ensure()
    if not shutil.which("ninja") or not shutil.which("cmake"):
        raise Stop(
            exit_codes.BAD_CASE,
            "cmake and ninja are not in PATH (no Debian machine?). Install them, g++ 12 "
            "and these libraries' equivalents: " + " ".join(packages.BUILD_AND_RUN),
        )
    BUILD.mkdir(exist_ok=True)
    with _one_build_at_a_time():
        if not _is_configured():
            _configure()
        _build(targets)


def _belongs_to_somebody_else():
    """Whether the programs are there and only their owner can build them, as in an installation for many users."""
    folder = BUILD if BUILD.exists() else ROOT
    if os.access(folder, os.W_OK):
        return False
    if all(program(name).exists() for name in PROGRAMS):
        return True
    raise Stop(
        exit_codes.BAD_CASE,
        f"{folder} belongs to somebody else and holds no complete build (you may not write there). "
        f"Ask its owner to run: {ROOT}/deploy/copepod setup",
    )


def parallel_jobs():
    """Compilers at once: one per core, fewer if the memory is small."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return max(1, min(len(os.sched_getaffinity(0)), int(memory / _BYTES_PER_COMPILER)))


@contextmanager
def _one_build_at_a_time():
    """Lock on the build folder itself, so that no lock file can be left behind."""
    folder = os.open(BUILD, os.O_RDONLY | os.O_DIRECTORY)
    try:
        fcntl.flock(folder, fcntl.LOCK_EX)
        yield
    finally:
        os.close(folder)


def _is_configured():
    """Whether build.ninja exists and belongs to this checkout (a moved or copied folder must be configured anew)."""
    try:
        cache = (BUILD / "CMakeCache.txt").read_text()
    except FileNotFoundError:
        return False
    return (BUILD / "build.ninja").exists() and f"CMAKE_HOME_DIRECTORY:INTERNAL={ROOT}\n" in cache


def _configure():
    with Stage("configuring"), open(BUILD / "build.log", "wb") as log:
        code = subprocess.run(
            ["cmake", "--fresh", "--preset", "release"],
            cwd=ROOT,
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=subprocess.STDOUT,
        ).returncode
        if code:
            raise Stop(exit_codes.PREPARATION_FAILED, _failure("cmake could not configure the build"))


def _build(targets):
    """Runs ninja; says nothing if that is over in a moment."""
    # With paths relative to the checkout, ccache serves every clone on this machine.
    environment = dict(os.environ, NINJA_STATUS="[%f/%t] ", CCACHE_BASEDIR=str(ROOT))
    ninja = subprocess.Popen(
        ["ninja", "-C", str(BUILD), "-j", str(parallel_jobs()), *targets],
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    try:
        beginning = _output_of_first_moment(ninja)
        if ninja.poll() == 0:
            return
        with Stage(f"building (log: {BUILD / 'build.log'})") as stage:
            _follow(beginning, ninja.stdout, stage)
            if ninja.wait() != 0:
                raise Stop(exit_codes.PREPARATION_FAILED, _failure("the build failed"))
    finally:
        if ninja.poll() is None:
            ninja.terminate()
        ninja.wait()
        ninja.stdout.close()


def _output_of_first_moment(process):
    """What the process writes before it ends, or until it is clear that it has real work to do."""
    output = b""
    deadline = time.monotonic() + _MOMENT_S
    while (left := deadline - time.monotonic()) > 0 and select.select([process.stdout], [], [], left)[0]:
        received = os.read(process.stdout.fileno(), 65536)
        if not received:
            process.wait()
            break
        output += received
    return output


def _follow(beginning, stream, stage):
    """Copies ninja's output to build.log and its counter to the stage's line."""
    with open(BUILD / "build.log", "wb") as log:
        log.write(beginning)
        for line in iter(stream.readline, b""):
            log.write(line)
            log.flush()
            counter = re.match(rb"\[(\d+)/(\d+)\]", line)
            if counter:
                stage.count(int(counter[1]), int(counter[2]))


def _failure(what):
    """Message with the end of build.log, from the first failed command on if ninja tells it."""
    lines = (BUILD / "build.log").read_text(errors="replace").splitlines()
    failed = next((number for number, line in enumerate(lines) if line.startswith("FAILED:")), len(lines))
    shown = lines[failed : failed + _SHOWN_LINES] or lines[-_SHOWN_LINES:]
    return "\n".join([f"{what}:", *shown, f"copepod: {what} (above). The full output is in {BUILD / 'build.log'}."])
