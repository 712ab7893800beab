"""Where things are: this checkout or installed package, its build folder, the programs."""

import hashlib
import json
import os
import re
from pathlib import Path

MODULES = Path(__file__).resolve().parent.parent  # the folder of this package and its neighbours
_IS_CHECKOUT = (MODULES.parent / "deploy/copepod").exists()
_OF_PACKAGE = MODULES.parent.parent.parent  # as /usr, with Python's part in lib/python3/dist-packages
# Where a package was installed; None in a checkout.
PREFIX = _OF_PACKAGE if not _IS_CHECKOUT and (_OF_PACKAGE / "libexec/copepod").is_dir() else None


def _root() -> Path:
    """The checkout that holds this file, or the one that pip has installed it from; shared files of a package."""
    if _IS_CHECKOUT:
        return MODULES.parent
    if PREFIX:
        return PREFIX / "share/copepod"
    from importlib import metadata  # a checkout starts without what only a package needs
    from urllib.parse import unquote, urlsplit

    record = metadata.distribution("copepod").read_text("direct_url.json") or "{}"  # PEP 610
    return Path(unquote(urlsplit(json.loads(record).get("url", "")).path))


ROOT = _root()
BUILD = ROOT / "build"
CACHE = Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "copepod") if PREFIX else BUILD
COMMAND = PREFIX / "bin/copepod" if PREFIX else ROOT / "deploy/copepod"
PROGRAMS = ("coupler", "fluid_service", "body_service", "in_process_run")
_OF_ENGINES = ("bullet_body_service", "mujoco_body_service")  # only where the libraries are


def version() -> str:
    """As «2.0.0»; the build has that of a checkout from the same place."""
    if PREFIX:
        from importlib import metadata

        return metadata.version("copepod")
    found = re.search(r"^project\(copepod VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text(), re.MULTILINE)
    return found[1] if found else "unknown"


def chosen_programs() -> Path | None:
    """Folder of ready-made programs, of COPEPOD_BIN_DIR or a package; with it nothing is installed or built."""
    if folder := os.environ.get("COPEPOD_BIN_DIR"):
        return Path(folder).resolve()
    return PREFIX / "libexec/copepod" if PREFIX else None


def program(name: str) -> Path:
    """Path of one of PROGRAMS."""
    return (chosen_programs() or BUILD / "bin") / name


def python_path_of_components() -> str:
    """PYTHONPATH with what the user had in it first: a component runs on the kit that it was installed with. That of
    Copepod, which alone its command has left in it, is for components that bring none."""
    own = (MODULES, ROOT / "proto/python", (chosen_programs() or BUILD / "bin").parent / "python")
    variables = ("COPEPOD_USERS_PYTHONPATH", "PYTHONPATH")
    entries = [entry for name in variables for entry in os.environ.get(name, "").split(os.pathsep)]
    return os.pathsep.join(sorted(filter(None, entries), key=lambda entry: Path(entry) in own))


def present_programs() -> list[str]:
    """Those that are there; a folder that the user has put together may lack some."""
    return [name for name in (*PROGRAMS, *_OF_ENGINES) if program(name).exists()]


def build_digest() -> str:
    """First 16 digits of the digest of all programs: the same programs, the same build."""
    digest = hashlib.sha256()
    for name in present_programs():
        with program(name).open("rb") as file:
            hashlib.file_digest(file, lambda: digest)
    return digest.hexdigest()[:16]


def called_as() -> str:
    """How the user called this command, for messages that suggest what to type next."""
    return os.environ.get("COPEPOD_CALLED_AS", "copepod" if PREFIX else "deploy/copepod")
