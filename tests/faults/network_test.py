"""Runs over a network that is cut for a while: the fluid is in a network namespace of its own, as on another host."""

import os
import shlex
import shutil
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

from hurt_run import LONGEST_S, PROGRAMS, HurtRun, digest, undisturbed_digest, wait_for

CUT_S = 2.0  # TCP notices about as late again that the network is back


def has_namespaces():
    """Whether this user may make network namespaces."""
    name = f"copepod-try-{os.getpid()}"
    if os.geteuid() != 0 or not shutil.which("ip"):
        return False
    made = subprocess.run(["ip", "netns", "add", name], capture_output=True).returncode == 0
    return made and subprocess.run(["ip", "netns", "delete", name]).returncode == 0


@unittest.skipUnless(has_namespaces(), "makes network namespaces, which needs root and ip")
class CutNetwork(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="copepod_faults_")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name).resolve()
        self.host, self.link = f"copepod-{os.getpid()}", f"cop{os.getpid()}"
        self.address = f"10.{os.getpid() // 250 % 250}.{os.getpid() % 250}"
        self.ip(f"netns add {self.host}")
        self.addCleanup(self.ip, f"netns delete {self.host}")
        self.ip(f"link add {self.link} type veth peer name cut netns {self.host}")
        self.addCleanup(self.ip, f"link delete {self.link}")
        self.ip(f"address add {self.address}.1/24 dev {self.link}")
        self.ip(f"link set {self.link} up")
        self.ip(f"-n {self.host} address add {self.address}.2/24 dev cut")
        self.ip(f"-n {self.host} link set cut up")

    def ip(self, words):
        subprocess.run(["ip", *words.split()], check=True)

    def start_halted(self, *arguments):
        """A run over tcp whose fluid stands still in a step until the file `halted` is removed."""
        self.halted = self.folder / "halted"
        words = [PROGRAMS / "halting_fluid", "--halt-in", "exchange", "--halt-at-step", "20"]
        command = ["ip", "netns", "exec", self.host, *words, "--halt-file", self.halted]
        transport = f"services.transport=tcp://{self.address}.1:17611"  # below the ports that the system hands out
        run = HurtRun(
            *(self.folder, "--out", "out", "--fluid", shlex.join(map(str, command)), "--ranks", "1"),
            *("--set", transport, *arguments),
        )
        self.addCleanup(lambda: run.process.poll() is None and (run.process.terminate(), run.end()))
        self.assertTrue(wait_for(self.halted.exists, LONGEST_S), "".join(run.stderr))
        return run

    def test_short_cut_changes_nothing(self):
        run = self.start_halted()
        self.ip(f"-n {self.host} link set cut down")
        self.halted.unlink()
        time.sleep(CUT_S)
        self.ip(f"-n {self.host} link set cut up")
        self.assertEqual(run.end(LONGEST_S), 0, "".join(run.stderr))
        self.assertEqual(digest(self.folder), undisturbed_digest())
        self.assertEqual(run.leftovers(), [])

    def test_cut_that_lasts_longer_than_the_case_allows_is_named(self):
        run = self.start_halted("--set", "services.silence_s=1.5")
        self.ip(f"-n {self.host} link set cut down")
        self.halted.unlink()
        self.assertEqual(run.end(LONGEST_S), 69, "".join(run.stderr))
        self.assertRegex(run.last_line, "fluid service on host .*: The fluid component .* is frozen .*host unreachable")
        self.assertEqual(run.leftovers(), [])


if __name__ == "__main__":
    unittest.main()
