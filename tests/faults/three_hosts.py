"""Hosts on one machine: each has its own network, processes, name, temporary folders and sshd, and shares the disk."""

import itertools
import os
import shlex
import shutil
import signal
import subprocess
import time
from pathlib import Path

from hurt_run import ROOT, wait_for

NAMES = ("a", "b", "c")
_PORT = 2222
_SSHD = "/usr/sbin/sshd"
_numbers = itertools.count()
_SUBNET = "10.77.0"  # every set of hosts has a switch of its own


def missing():
    """Why hosts cannot be made here; empty if they can."""
    for program in ("ip", "unshare", "nsenter", "ssh", "ssh-keygen", _SSHD):
        if not shutil.which(program):
            return f"{program} is missing"
    if os.geteuid() != 0:
        return "network namespaces need root"
    name = f"copepod-try-{os.getpid()}"
    if subprocess.run(["ip", "netns", "add", name], capture_output=True).returncode:
        return "network namespaces cannot be made here"
    subprocess.run(["ip", "netns", "delete", name])
    return ""


class Hosts:
    """Three hosts on a switch. `folder` is on the shared disk, not in /tmp, which every host has for itself."""

    _DAEMONS: tuple[str, ...] = ("sshd:",)  # how the command lines of a host's own processes begin

    def __init__(self, folder):
        self._folder = Path(folder)
        self._spaces = f"copepod-{os.getpid()}-{next(_numbers)}"
        self._init = {}  # name: its first process
        self._boots = {}  # name: what has started it
        self._cuts = set()  # (host, the host that it sends to in vain)
        names = "".join(f"{self.address(name)} {name}\n" for name in NAMES)
        (self._folder / "hosts").write_text(f"127.0.0.1 localhost\n{names}")
        self._prepare()
        try:
            self._make_network()
            for name in NAMES:
                self._boot(name)
            self._wait_until_up()
        except BaseException:
            self.close()
            raise

    def address(self, name):
        return f"{_SUBNET}.{NAMES.index(name) + 1}"

    def command(self, name, *words):
        """Words that carry out a command on a host."""
        place = ["nsenter", "--target", str(self._init[name]), "--net", "--uts", "--mount", "--pid", "--"]
        return [*place, *map(str, words)]

    @property
    def ssh(self):
        """For COPEPOD_SSH."""
        return shlex.join(["ssh", "-F", str(self._folder / "ssh_config")])

    def processes(self, name):
        """{process: environment} of everything on a host."""
        space = os.readlink(f"/proc/{self._init[name]}/ns/pid")
        found = {}
        for entry in Path("/proc").iterdir():
            try:
                if entry.name.isdigit() and os.readlink(entry / "ns/pid") == space:
                    pairs = (entry / "environ").read_bytes().decode(errors="replace").split("\0")
                    found[int(entry.name)] = dict(pair.split("=", 1) for pair in pairs if "=" in pair)
            except OSError:
                continue
        return found

    def left(self):
        """What is there beside the host's own: processes but for sshd, and temporary folders."""
        found = []
        for name in NAMES:
            for pid in self.processes(name):
                words = _words(pid)
                if pid != self._init[name] and words and not words.startswith((*self._DAEMONS, "sleep 0.5")):
                    found.append(f"{name}: {pid} {words}")
            root = Path(f"/proc/{self._init[name]}/root")
            for place in ("tmp", "dev/shm"):
                found += [f"{name}: {path.name}" for path in (root / place).glob("copepod-*")]
        return found

    def cut(self, name, direction="both"):
        """Loses what a host sends (out), what it is sent (in), or both; no sender notices, as with a torn cable."""
        others = [other for other in NAMES if other != name]
        lost = [(name, other) for other in others if direction in ("out", "both")]
        lost += [(other, name) for other in others if direction in ("in", "both")]
        for sender, receiver in lost:
            unused = "02:00:00:00:00:01"  # a link address that no host has
            self._ip(f"-n {self._space(sender)} neigh replace {self.address(receiver)} lladdr {unused} dev net")
            self._cuts.add((sender, receiver))

    def mend(self):
        for sender, receiver in self._cuts:
            self._ip(f"-n {self._space(sender)} neigh delete {self.address(receiver)} dev net", check=False)
        self._cuts.clear()

    def close(self):
        for pid in self._init.values():
            os.kill(pid, signal.SIGKILL)  # and with it everything on that host
        for process in self._boots.values():
            process.wait()
        for name in (*NAMES, "switch"):
            self._ip(f"netns delete {self._space(name)}", check=False)

    def _space(self, name):
        return f"{self._spaces}-{name}"

    def _make_network(self):
        switch = self._space("switch")
        self._ip(f"netns add {switch}")
        self._ip(f"-n {switch} link add bridge type bridge")
        self._ip(f"-n {switch} link set bridge up")
        for name in NAMES:
            space = self._space(name)
            self._ip(f"netns add {space}")
            self._ip(f"-n {switch} link add name to_{name} type veth peer name net netns {space}")
            self._ip(f"-n {switch} link set to_{name} master bridge up")
            self._ip(f"-n {space} address add {self.address(name)}/24 dev net")
            self._ip(f"-n {space} link set net up")
            self._ip(f"-n {space} link set lo up")

    def _boot(self, name):
        """Its first process collects orphans, and keeps the daemons."""
        names = self._folder / "hosts"
        shared = shlex.quote(str(ROOT))  # perhaps in /tmp
        script = (
            f"hostname {name}; mount --bind {names} /etc/hosts; "
            f"mount --bind {shared} /mnt; mount -t tmpfs none /tmp; mkdir -p {shared}; mount --move /mnt {shared}; "
            f"mount -t tmpfs none /dev/shm; cd /; {self._daemons(name)} while :; do wait; sleep 0.5; done"
        )
        space = ["ip", "netns", "exec", self._space(name), "unshare", "--pid", "--fork", "--kill-child"]
        process = subprocess.Popen(
            [*space, "--mount-proc", "--uts", "--mount", "/bin/bash", "-c", script],
            stdin=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
            cwd="/",
        )
        self._boots[name] = process
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
        if not wait_for(lambda: children.read_text().split(), 10):
            raise AssertionError(f"host {name} does not start")
        self._init[name] = int(children.read_text().split()[0])

    def _daemons(self, name):
        """Commands of a shell that start them."""
        return f"mkdir -p /run/sshd; {_SSHD} -D -f {self._folder}/sshd_config -E {self._folder}/sshd_{name}.log & "

    def _wait_until_up(self):
        if not wait_for(lambda: all(self._accepts(name) for name in NAMES[1:]), 20):
            raise AssertionError("sshd does not answer")

    def _prepare(self):
        folder = self._folder
        for key in ("host_key", "user_key"):
            subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", folder / key], check=True)
        (folder / "sshd_config").write_text(
            f"Port {_PORT}\nHostKey {folder}/host_key\nAuthorizedKeysFile {folder}/user_key.pub\nStrictModes no\n"
            f"UsePAM no\nPermitRootLogin yes\nPidFile none\nMaxStartups 100\n"
            f"SetEnv HOME={folder}\n"  # what a login starts on this machine is not part of the test
        )
        (folder / "ssh_config").write_text(
            f"Host *\n  Port {_PORT}\n  IdentityFile {folder}/user_key\n  IdentitiesOnly yes\n  BatchMode yes\n"
            "  StrictHostKeyChecking no\n  UserKnownHostsFile /dev/null\n  LogLevel ERROR\n  ConnectTimeout 10\n"
        )

    def _accepts(self, name):
        words = self.command("a", "bash", "-c", f"exec 3<>/dev/tcp/{name}/{_PORT}")
        return subprocess.run(words, capture_output=True).returncode == 0

    @staticmethod
    def _ip(words, check=True):
        subprocess.run(["ip", *words.split()], check=check, capture_output=not check)


def _words(pid):
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace").strip()
    except OSError:
        return ""


def clean_within(hosts, patience_s):
    """(seconds until nothing was left on any host, what was left then)"""
    start = time.monotonic()
    wait_for(lambda: not hosts.left(), patience_s)
    return time.monotonic() - start, hosts.left()
