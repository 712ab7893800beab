#!/usr/bin/python3
"""A Containerfile carried out without a container runtime: its stages as folders, its steps with chroot.

    container_image.py CONTAINERFILE CONTEXT FOLDER

Needs root and mmdebstrap. Understands what deploy/container/Containerfile has: FROM, COPY, RUN, WORKDIR, USER, ENV and
ENTRYPOINT. A stage of Debian 12 is the smallest that Debian can make; `debian:12-slim` has no more than that.
"""

import json
import re
import shlex
import shutil
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

SHM = "size=64m"  # what container runtimes give


class NoDebian(Exception):
    """mmdebstrap could not make a root, and why."""


@dataclass
class Image:
    root: Path
    user: str = "root"
    workdir: str = "/"
    environment: dict[str, str] = field(default_factory=lambda: {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin"})
    entrypoint: list[str] = field(default_factory=list)

    def run(self, *command, user=None, **options):
        """A completed process; its mounts and processes end with it."""
        mounts = " && ".join(
            f"mount -t {kind} -o {how} {kind} {self.root}/{place}"
            for kind, how, place in (("proc", "ro", "proc"), ("tmpfs", SHM, "dev/shm"))
        )
        entered = ["chroot", f"--userspec={user or self.user}", str(self.root), "/bin/sh", "-c", 'cd "$0" && exec "$@"']
        inside = shlex.join([*entered, self.workdir, *map(str, command)])
        home = "/root" if (user or self.user) == "root" else f"/home/{user or self.user}"
        return subprocess.run(
            ["unshare", "--mount", "--pid", "--fork", "--kill-child", "sh", "-c", f"{mounts} && exec {inside}"],
            env={"HOME": home, "DEBIAN_FRONTEND": "noninteractive", **self.environment},
            stdin=subprocess.DEVNULL,
            **options,
        )

    def __call__(self, *arguments, **options):
        """The image as a user starts it."""
        return self.run(*self.entrypoint, *arguments, **options)


def build(containerfile, context, folder, built=None):
    """The image of the last stage.

    @param context  what COPY copies from
    @param built    folder that stands for /src/build of the stage «build», which is then left out
    """
    stages, image = {}, None
    for word, rest in instructions(containerfile.read_text()):
        if word == "FROM":
            name = rest.split(" AS ")[1] if " AS " in rest else "last"
            image = None if built and name == "build" else base(folder / name)
            stages[name] = image
        elif image is None:
            continue
        elif word == "COPY":
            *sources, target = rest.split()
            origin = context
            if sources[0].startswith("--from="):
                stage = stages[sources.pop(0).removeprefix("--from=")]
                origin = stage.root if stage else built
            copy(
                origin, [re.sub("^/src/build/", "/", s) if origin == built else s for s in sources], image.root, target
            )
        elif word == "RUN":
            image.run("/bin/sh", "-c", rest, check=True, stdout=subprocess.DEVNULL)
        elif word == "WORKDIR":
            image.workdir = rest
        elif word == "USER":
            image.user = rest
        elif word == "ENV":
            image.environment.update([rest.split("=", 1)])
        elif word == "ENTRYPOINT":
            image.entrypoint = json.loads(rest)
        else:
            raise ValueError(f"unknown instruction {word}")
    return image


def instructions(text):
    """(word, rest) of each instruction, its lines joined."""
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    for line in re.sub(r"\\\n", "", "\n".join(lines)).splitlines():
        word, _, rest = line.partition(" ")
        yield word, rest.strip()


def base(root):
    """A new Debian 12 with the packages that a minimal system has. Raises NoDebian if it cannot be fetched."""
    root.parent.mkdir(parents=True, exist_ok=True)
    command = ["mmdebstrap", "--quiet", "--mode=root", "--variant=minbase", "--skip=cleanup/apt"]
    command += ["--dpkgopt=force-unsafe-io", "bookworm", str(root)]  # the root is not kept: nothing waits for the disk
    made = subprocess.run(command, stderr=subprocess.PIPE, text=True)
    if made.returncode != 0:
        raise NoDebian(made.stderr.strip()[-500:])
    return Image(root)


def copy(origin, sources, root, target):
    """Files, or the content of a folder, as COPY does."""
    place = root / target.lstrip("/")
    place.mkdir(parents=True, exist_ok=True)
    for source in sources:
        found = [origin] if source == "." else sorted(origin.glob(source.lstrip("/")))
        if not found:
            raise FileNotFoundError(f"{source} in {origin}")
        for path in found:
            if path.is_dir():
                shutil.copytree(path, place, symlinks=True, dirs_exist_ok=True, ignore=shutil.ignore_patterns(".git"))
            else:
                shutil.copy(path, place)


if __name__ == "__main__":
    made = build(Path(sys.argv[1]), Path(sys.argv[2]), Path(sys.argv[3]))
    size = subprocess.run(["du", "-sxm", made.root], capture_output=True, text=True, check=True).stdout.split()[0]
    print(f"{made.root}: {size} MB")
