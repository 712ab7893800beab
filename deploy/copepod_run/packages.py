"""Debian packages that Copepod needs: which are missing, and installing them."""

import os
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any, BinaryIO

from copepod_run.checkout import BUILD
from copepod_run.errors import BadCase
from copepod_run.messages import Stage

# Of the Debian packages of Copepod itself, these are dependencies (cmake/CopepodPackages.cmake).
KIT = (
    *("libzmq3-dev", "cppzmq-dev", "libxxhash-dev", "libprotobuf-dev", "libeigen3-dev", "libspdlog-dev"),
    *("libcli11-dev", "nlohmann-json3-dev"),
)
RUN = (
    "openmpi-bin",
    *("python3-jinja2", "python3-numpy", "python3-matplotlib", "python3-scipy", "python3-h5py"),  # reports
    *("python3-zmq", "python3-xxhash", "python3-protobuf"),  # components in Python
    "libjs-three",  # moving bodies in pages
)
BUILD_AND_RUN = (
    *("g++", "cmake", "ninja-build", "ccache", "pkg-config"),
    *("libopenmpi-dev", "protobuf-compiler", "libgtest-dev", "libyaml-cpp-dev", "libhdf5-openmpi-dev"),
    *("libbenchmark-dev", "libbullet-dev", "libmujoco-dev"),  # the latter are engines of the body service
    *KIT,
    *RUN,
)
PYTHON = ("python3-pandas", "python3-xarray", "python3-yaml")  # for `import copepod`
DOCUMENTATION = ("python3-sphinx", "python3-myst-parser", "furo", "python3-breathe", "doxygen", "graphviz")
CONTINUOUS_INTEGRATION = (
    *PYTHON,
    *DOCUMENTATION,
    *("python3-jsonschema", "python3-nbclient", "python3-ipykernel"),
    *("python3-pip", "python3-setuptools", "python3-wheel"),
    *("clang-format", "clang-tidy", "clang", "libclang-rt-dev", "lld", "gcovr", "valgrind"),
    *("help2man", "python3-argcomplete", "man-db", "git", "black", "flake8", "mypy"),
    *("gfortran", "dpkg-dev", "file", "lintian", "mmdebstrap"),
    *("nodejs", "npm", "chromium", "openssh-server", "iproute2", "slurm-wlm"),
)
# Often installed from elsewhere, in versions that conflict with Debian's: the command is what counts.
_COMMANDS = {"nodejs": "node", "npm": "npm"}


def missing(names: Sequence[str]) -> list[str]:
    """The packages of `names` that are not installed, in their order; none where there is no dpkg."""
    if not shutil.which("dpkg-query"):
        return []
    ask = ["dpkg-query", "-W", "-f=${Package} ${db:Status-Status}\n", *names]
    answer = subprocess.run(ask, capture_output=True, text=True)
    installed = {line.split()[0] for line in answer.stdout.splitlines() if line.endswith(" installed")}
    installed |= {name for name, command in _COMMANDS.items() if shutil.which(command)}
    return [name for name in names if name not in installed]


def ensure(names: Sequence[str] = BUILD_AND_RUN) -> None:
    """Installs what is missing of `names`; quiet when nothing is.

    Raises Stop(2) with the exact command to run if we are not root, and if apt-get fails.
    """
    if os.geteuid() != 0:
        require(names, "only root can install them")
    if not (wanted := missing(names)):
        return
    BUILD.mkdir(exist_ok=True)
    log_path = BUILD / "packages.log"
    install = ["install", "-y", "--no-install-recommends", *wanted]
    with Stage(f"installing {len(wanted)} Debian packages (log: {log_path})"), open(log_path, "wb") as log:
        if any(Path("/var/lib/apt/lists").glob("*_Packages*")) and _apt_get(install, log) == 0:
            return
        _apt_get(["update"], log)  # they may also be outdated
        if _apt_get(install, log) != 0:
            raise BadCase(
                f"apt-get could not install the packages (see {log.name}). Try: apt-get install -y {' '.join(wanted)}"
            )


def require(names: Sequence[str], reason: str) -> None:
    """Raises Stop(2) with the exact command to run if any of `names` is missing; installs nothing."""
    if wanted := missing(names):
        root = "" if os.geteuid() == 0 else "sudo "
        raise BadCase(
            f"{len(wanted)} Debian packages are missing ({reason}). "
            f"Run: {root}apt-get install -y {' '.join(wanted)}"
        )


def _apt_get(arguments: Sequence[str], log: BinaryIO) -> int:
    """Exit code of one apt-get call that asks nothing and waits for another one to end."""
    environment = dict(os.environ, DEBIAN_FRONTEND="noninteractive")
    return run_into(log, ["apt-get", "-o", "DPkg::Lock::Timeout=300", *arguments], env=environment)


def run_into(log: BinaryIO, command: Sequence[str], **settings: Any) -> int:
    """Exit code of a command that asks nothing and writes to `log`; `settings`: as for subprocess.run."""
    streams: dict[str, Any] = {"stdin": subprocess.DEVNULL, "stdout": log, "stderr": subprocess.STDOUT}
    return subprocess.run(command, **streams, **settings).returncode
